"""The robots to choose from, all with one interface: the names and commands of `sim.robots.panda`."""

from __future__ import annotations

import mujoco

from prefplan.errors import choices
from sim.errors import RobotError
from sim.robots.menagerie import menagerie_spec
from sim.robots.panda import ARM_JOINTS, TORQUE_LIMITS, panda_spec

ROBOTS = ("default", "menagerie")
"""Our own description of the Panda, and that of MuJoCo Menagerie, which has to be fetched."""


def robot_spec(robot: str = "default", *, meshes: bool | None = None) -> mujoco.MjSpec:
    """Return a robot, its base frame at the origin.

    Args:
        robot: one of `ROBOTS`.
        meshes: dress the default robot with meshes; None for where they are installed. Menagerie's has its own.

    Raises:
        RobotError: it is unknown or cannot be had.
    """
    if robot not in ROBOTS:
        raise RobotError(f"unknown robot {robot!r} {choices(robot, ROBOTS)}")
    spec = panda_spec(meshes=meshes) if robot == "default" else menagerie_spec()
    _limit_torques(spec)
    return spec


def arm_spec(robot: str = "default") -> mujoco.MjSpec:
    """Return a robot's kinematics alone: without shapes, fingers and whatever drives them.

    Raises:
        RobotError: it is unknown or cannot be had.
    """
    spec = robot_spec(robot, meshes=False)
    for finger in ("left_finger", "right_finger"):
        spec.delete(spec.body(finger))
    for element in (*spec.geoms, *spec.meshes):
        spec.delete(element)
    return spec


def _limit_torques(spec: mujoco.MjSpec) -> None:
    """Let the motors carry the arm's weight, as the real ones do, within the same limits as all that they give."""
    for name, limit in zip(ARM_JOINTS, TORQUE_LIMITS, strict=True):
        joint = spec.joint(name)
        joint.actgravcomp = True
        joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.actfrcrange = [-limit, limit]
