"""Perception: sensors, contact monitoring, grounding of observed poses in symbolic states, and the world model."""
