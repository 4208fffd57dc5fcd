"""Geoms of a scene: which are drawn and which only collide, and meshes that are drawn."""

from __future__ import annotations

import mujoco
import numpy as np
import trimesh

VISIBLE, HIDDEN = 2, 3
"""Geom groups: what is drawn, and what only collides."""


def solid_geoms(model: mujoco.MjModel, body: str) -> np.ndarray:
    """Return the indices of a body's geoms that collide."""
    solid = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    return np.flatnonzero(solid & (model.geom_bodyid == model.body(body).id))


def add_solid(spec: mujoco.MjSpec, name: str, solid: trimesh.Trimesh) -> None:
    """Add a mesh that is drawn with the solid's own normals."""
    mesh = spec.add_mesh(name=name, uservert=solid.vertices.ravel(), userface=solid.faces.ravel())
    mesh.usernormal, mesh.userfacenormal = solid.vertex_normals.ravel(), solid.faces.ravel()
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL


def draw_solid(
    spec: mujoco.MjSpec,
    body: mujoco.MjsBody,
    name: str,
    solid: trimesh.Trimesh,
    material: str,
    *,
    xy: np.ndarray | tuple[float, float] = (0.0, 0.0),
    z: float = 0.0,
) -> None:
    """Give a body a solid at (xy, z) of its frame, m, that collides with nothing and weighs nothing.

    The geom and its mesh bear the name.
    """
    add_solid(spec, name, solid)
    geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, material=material, pos=[*xy, z])
    geom.contype = geom.conaffinity = geom.mass = 0
    geom.group = VISIBLE
