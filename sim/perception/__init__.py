"""Perception: sensors, contact monitoring, and the symbolic state grounded in them."""
