"""Geoms of a scene: which are visual and which collide, where they are, and which a ray hits first."""

import copy
import os
from pathlib import Path

import mujoco
import numpy as np
import trimesh
from numpy.typing import ArrayLike

from sim.errors import SimulationError

VISIBLE, HIDDEN = 2, 3
"""Geom groups: drawn, and for collisions only."""

CORNERS = np.stack(np.meshgrid(*[(-1.0, 1.0)] * 3), axis=-1).reshape(8, 3)
"""(8, 3) corners of a box about the origin, in halves of its sides."""


def yaw_quat(yaw: float) -> np.ndarray:
    """Return the (4,) quaternion, w first, of a rotation about z, rad."""
    return np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)])


def is_solid(model: mujoco.MjModel) -> np.ndarray:
    """Return (ngeom,) bool: which geoms collide."""
    return np.asarray((model.geom_contype != 0) | (model.geom_conaffinity != 0))


def solid_geoms(model: mujoco.MjModel, body: str) -> np.ndarray:
    """Return the indices of a body's geoms that collide."""
    return np.flatnonzero(is_solid(model) & (model.geom_bodyid == model.body(body).id))


def with_descendants(model: mujoco.MjModel, *bodies: int) -> np.ndarray:
    """Return (nbody,) bool: which bodies are among some bodies and their descendants."""
    found = np.isin(np.arange(model.nbody), bodies)
    for body in range(1, model.nbody):
        found[body] |= found[model.body_parentid[body]]
    return found


def columns(model: mujoco.MjModel, joint: str) -> tuple[slice, slice]:
    """Return the slices of a joint in a model's qpos and qvel."""
    found = model.joint(joint)
    place, dof = int(found.qposadr[0]), int(found.dofadr[0])
    positions, velocities = (7, 6) if found.type[0] == mujoco.mjtJoint.mjJNT_FREE else (1, 1)
    return slice(place, place + positions), slice(dof, dof + velocities)


def joint_at(model: mujoco.MjModel, place: int) -> str:
    """Return the name of the joint to which an index of a model's qpos belongs."""
    return str(model.joint(int(np.searchsorted(model.jnt_qposadr, place, side="right")) - 1).name)


def box_corners(data: mujoco.MjData, geoms: np.ndarray) -> np.ndarray:
    """Return the (G, 8, 3) corners of the bounding boxes of G geoms, m."""
    boxes = data.model.geom_aabb[geoms, None, :3] + CORNERS * data.model.geom_aabb[geoms, None, 3:]
    return boxes @ data.geom_xmat[geoms].reshape(-1, 3, 3).transpose(0, 2, 1) + data.geom_xpos[geoms, None]


def plain_solid(model: mujoco.MjModel, geom: int) -> trimesh.Trimesh | None:
    """Return a geom of a primitive type as a mesh in its own frame, m; None for other types."""
    size = model.geom_size[geom]
    match int(model.geom_type[geom]):
        case mujoco.mjtGeom.mjGEOM_BOX:
            return trimesh.creation.box(2 * size)
        case mujoco.mjtGeom.mjGEOM_SPHERE:
            return trimesh.creation.icosphere(radius=size[0])
        case mujoco.mjtGeom.mjGEOM_ELLIPSOID:
            return trimesh.creation.icosphere().apply_scale(size)
        case mujoco.mjtGeom.mjGEOM_CYLINDER:
            return trimesh.creation.cylinder(size[0], 2 * size[1])
        case mujoco.mjtGeom.mjGEOM_CAPSULE:
            solid = trimesh.creation.capsule(2 * size[1], size[0], count=[16, 32])
            # Its origin differs between versions of trimesh.
            return solid.apply_translation(-solid.bounds.mean(axis=0))
    return None


def opaque(model: mujoco.MjModel, geoms: np.ndarray) -> mujoco.MjModel:
    """Return a copy of a model in which rays hit only the geoms selected by (ngeom,) bool."""
    copied = copy.copy(model)
    copied.geom_matid[:], copied.geom_rgba[:, 3] = -1, geoms
    return copied


def first_met(
    model: mujoco.MjModel, data: mujoco.MjData, start: np.ndarray, direction: np.ndarray, *, without: int = -1
) -> tuple[int, float]:
    """Return the first geom that a ray from a (3,) point, m, hits, and the distance in lengths of `direction`.

    Both are -1 if it hits none; it passes through the body `without`.
    """
    geom = np.array([-1], dtype=np.int32)
    distance = mujoco.mj_ray(model, data, start, direction, None, True, without, geom)
    return int(geom[0]), float(distance)


def draw_solid(
    spec: mujoco.MjSpec,
    body: mujoco.MjsBody,
    name: str,
    solid: trimesh.Trimesh,
    material: str,
    *,
    pos: ArrayLike = (0.0, 0.0, 0.0),
    quat: ArrayLike = (1.0, 0.0, 0.0, 0.0),
) -> None:
    """Add a visual geom with the solid's own normals to a body, in a pose in its frame, m.

    It has neither collisions nor mass. The geom and its mesh bear the name.
    """
    mesh = spec.add_mesh(name=name, uservert=solid.vertices.ravel(), userface=solid.faces.ravel())
    mesh.usernormal, mesh.userfacenormal = solid.vertex_normals.ravel(), solid.faces.ravel()
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, material=material)
    geom.pos, geom.quat = pos, quat
    geom.contype = geom.conaffinity = geom.mass = 0
    geom.group, geom.rgba = VISIBLE, [0.5, 0.5, 0.5, 1]  # MuJoCo's default, in place of which it uses the material's


def as_utf8(path: Path) -> str:
    """Return a path as MuJoCo takes it, in UTF-8, or raise `SimulationError`.

    In a locale other than UTF-8, Python's paths may contain surrogates instead of characters.
    """
    try:
        return os.fsencode(path).decode()
    except UnicodeDecodeError:
        raise SimulationError(f"{path}: MuJoCo reads only files whose paths are UTF-8") from None
