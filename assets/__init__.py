"""MJCF and materials."""
