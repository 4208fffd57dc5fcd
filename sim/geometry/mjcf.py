"""Geoms of a scene: which are drawn and which only collide, and solids that are drawn."""

from __future__ import annotations

import mujoco

from sim.geometry.solids import Solid

VISIBLE, HIDDEN = 2, 3
"""Geom groups: what is drawn, and what only collides."""


def add_solid(spec: mujoco.MjSpec, name: str, solid: Solid) -> None:
    """Add a mesh that is drawn with the solid's own normals."""
    mesh = spec.add_mesh(name=name, uservert=solid.vertices.ravel(), userface=solid.faces.ravel())
    mesh.usernormal, mesh.userfacenormal = solid.normals.ravel(), solid.faces.ravel()
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
