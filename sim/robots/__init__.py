"""Robots: names, limits and MJCF."""
