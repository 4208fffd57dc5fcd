"""The Franka Panda: names, limits, and its MJCF dressed with meshes where they are installed."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import trimesh

from sim.geometry.solids import Solid
from sim.robots.meshes import mesh_folder, surfaces

ARM_JOINTS = tuple(f"joint{i}" for i in range(1, 8))
"""Arm joints from base to wrist; the position actuators bear the same names (commands in rad)."""

FINGER_JOINTS = ("finger_joint1", "finger_joint2")
"""Sliding joints of the fingers, 0 .. 0.04 m each; kept equal by a constraint."""

GRIPPER = "gripper"
"""Actuator of both fingers; its command is the width between the pads in m, 0 .. `MAX_WIDTH`."""

MAX_WIDTH = 0.08
"""Width between the pads of the open hand, m."""

WRIST = "wrist"
"""The camera on the hand."""

TCP = "tcp"
"""Site midway between the pads: z points out of the hand, the fingers close along y."""

PADS = ("left_pad", "right_pad")
"""Geoms that touch what is grasped."""

VELOCITY_LIMITS = np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61])
"""(7,) greatest joint speeds, rad/s (Franka Control Interface documentation, limits for Panda)."""

TORQUE_LIMITS = np.array([87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0])
"""(7,) greatest joint torques, N m (the same page)."""

HOME = np.array([0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])
"""(7,) rad, Franka's ready pose: the hand points down in front of the base."""

VISIBLE, HIDDEN = 2, 3
"""Geom groups: what is drawn, and what only collides."""

MJCF = Path(__file__).parents[2] / "assets" / "panda.xml"


def panda_spec(*, meshes: bool | None = None) -> mujoco.MjSpec:
    """Return the robot, its base frame at the origin; materials `panda_shell`, ... are left to the caller.

    Args:
        meshes: dress it with meshes, or leave it its capsules; None for meshes where they are installed.
            Kinematics, inertia, fingers and pads are the same either way.

    Raises:
        FileNotFoundError: meshes are asked for and not installed.
    """
    spec = mujoco.MjSpec.from_file(str(MJCF))
    folder = mesh_folder()
    if meshes and folder is None:
        raise FileNotFoundError("the Panda's meshes come with the package gymnasium-robotics")
    if folder is not None and meshes is not False:
        _dress(spec, folder)
    return spec


def _dress(spec: mujoco.MjSpec, folder: Path) -> None:
    """Give every link its visual and collision meshes instead of capsules; the fingers keep their boxes."""
    bodies = {body.name: [body] for body in spec.bodies if body.name.startswith(("link", "hand"))}
    bodies["finger"] = [spec.body("left_finger"), spec.body("right_finger")]
    for geom in list(spec.geoms):
        if geom.parent.name in bodies:
            spec.delete(geom)
        else:
            geom.group = HIDDEN
    for link in bodies.keys() - {"finger"}:
        hull = trimesh.load_mesh(folder / "collision" / f"{link}.stl")
        spec.add_mesh(name=f"{link}_hull", uservert=hull.vertices.ravel(), userface=hull.faces.ravel())
        _add_geom(spec, bodies[link][0], f"{link}_hull", group=HIDDEN)
    for surface in surfaces(folder):
        name = f"{surface.link}_{surface.finish}"
        add_solid(spec, name, surface.solid)
        for body in bodies[surface.link]:
            geom = _add_geom(spec, body, name, group=VISIBLE)
            geom.material = f"panda_{surface.finish}"
            geom.contype = geom.conaffinity = 0
            geom.rgba = [0.5, 0.5, 0.5, 1]


def add_solid(spec: mujoco.MjSpec, name: str, solid: Solid) -> None:
    """Add a mesh that is drawn with the solid's own normals."""
    mesh = spec.add_mesh(name=name, uservert=solid.vertices.ravel(), userface=solid.faces.ravel())
    mesh.usernormal, mesh.userfacenormal = solid.normals.ravel(), solid.faces.ravel()
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL


def _add_geom(spec: mujoco.MjSpec, body: mujoco.MjsBody, mesh: str, *, group: int) -> mujoco.MjsGeom:
    geom = body.add_geom(spec.find_default("panda"))
    geom.type, geom.meshname, geom.group = mujoco.mjtGeom.mjGEOM_MESH, mesh, group
    return geom
