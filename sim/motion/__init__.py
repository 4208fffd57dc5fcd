"""Motions of the arm: tool paths, inverse kinematics, and what would be touched on the way."""
