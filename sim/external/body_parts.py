"""Bodies of a user's scene as convex parts, on which a hand finds where to press."""

from __future__ import annotations

import functools
from pathlib import Path

import mujoco
import numpy as np
import trimesh

from sim.external.meshes import MeshParts
from sim.external.user_scene import UserScene, bounds, read_file, solids
from sim.geometry.mjcf import plain_solid


def parts_of(path: Path, body: str) -> MeshParts | None:
    """Return the colliding shapes of a free body of a scene about the middle of their box.

    None if it is a single upright shape, which its box says all about.
    """
    return _parts_of(path, path.stat().st_mtime_ns, body)


@functools.lru_cache(maxsize=32)
def _parts_of(path: Path, changed: int, body: str) -> MeshParts | None:
    """Return the same; `changed` tells versions of the file apart."""
    scene = read_file(path)
    model, data, found = scene.mujoco, scene.data, solids(scene, body)
    turn, at = data.body(body).xmat.reshape(3, 3), data.body(body).xpos
    if len(found) == 1 and model.geom_type[found[0]] != mujoco.mjtGeom.mjGEOM_MESH:
        upright = turn.T @ data.geom_xmat[found[0]].reshape(3, 3)
        if np.allclose(np.abs(upright) @ [0, 0, 1], [0, 0, 1]) and np.allclose(np.abs(upright).max(axis=0), 1):
            return None
    middle = np.mean(bounds(scene, body), axis=0)
    parts: list[trimesh.Trimesh] = []
    for geom in found.tolist():
        part = _solid(scene, geom)
        pose = np.eye(4)
        pose[:3, :3] = turn.T @ data.geom_xmat[geom].reshape(3, 3)
        pose[:3, 3] = turn.T @ (data.geom_xpos[geom] - at) - middle
        part.apply_transform(pose)
        parts.append(part)
    whole = trimesh.util.concatenate(parts)
    assert isinstance(whole, trimesh.Trimesh)
    return MeshParts(whole, tuple(parts))


def _solid(scene: UserScene, geom: int) -> trimesh.Trimesh:
    """Return the convex solid that a geom collides as, in its own frame."""
    model = scene.mujoco
    solid = plain_solid(model, geom)
    if solid is not None:
        return solid
    mesh = model.mesh(int(model.geom_dataid[geom]))
    first, number = int(mesh.vertadr[0]), int(mesh.vertnum[0])
    return trimesh.Trimesh(model.mesh_vert[first : first + number]).convex_hull
