"""Scenes and runs as files that other programs open."""
