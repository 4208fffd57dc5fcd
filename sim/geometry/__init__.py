"""Geometry: rectangles on the table, visual meshes, MuJoCo geoms, and places of a surface that a gripper can press."""
