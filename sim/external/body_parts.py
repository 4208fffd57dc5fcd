"""Bodies of a user's scene as convex parts, on which grasps are sought."""

import numpy as np
import trimesh

from sim.external.meshes import MeshParts
from sim.external.user_scene import UserScene, bounds, solids
from sim.geometry.mjcf import plain_solid
from sim.geometry.solids import joined


def parts_of(scene: UserScene, body: str) -> MeshParts:
    """Return the colliding shapes of a free body of a scene about the middle of their box."""
    data, found = scene.data, solids(scene, body)
    turn, at = data.body(body).xmat.reshape(3, 3), data.body(body).xpos
    middle = np.mean(bounds(scene, body), axis=0)
    parts: list[trimesh.Trimesh] = []
    for geom in found.tolist():
        part = _solid(scene, geom)
        pose = np.eye(4)
        pose[:3, :3] = turn.T @ data.geom_xmat[geom].reshape(3, 3)
        pose[:3, 3] = turn.T @ (data.geom_xpos[geom] - at) - middle
        part.apply_transform(pose)
        parts.append(part)
    return MeshParts(joined(parts), tuple(parts))


def _solid(scene: UserScene, geom: int) -> trimesh.Trimesh:
    """Return the convex solid that a geom collides as, in its own frame."""
    model = scene.mujoco
    solid = plain_solid(model, geom)
    if solid is not None:
        return solid
    mesh = model.mesh(int(model.geom_dataid[geom]))
    first, number = int(mesh.vertadr[0]), int(mesh.vertnum[0])
    return trimesh.Trimesh(model.mesh_vert[first : first + number]).convex_hull
