"""The Franka Panda: names, limits, and its MJCF dressed with meshes where they are installed."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import mujoco
import numpy as np

ARM_JOINTS = tuple(f"joint{i}" for i in range(1, 8))
"""Arm joints from base to wrist; the position actuators bear the same names (commands in rad)."""

FINGER_JOINTS = ("finger_joint1", "finger_joint2")
"""Sliding joints of the fingers, 0 .. 0.04 m each; kept equal by a constraint."""

GRIPPER = "gripper"
"""Actuator of both fingers; its command is the width between the pads in m, 0 .. `MAX_WIDTH`."""

MAX_WIDTH = 0.08
"""Width between the pads of the open hand, m."""

TCP = "tcp"
"""Site midway between the pads: z points out of the hand, the fingers close along y."""

PADS = ("left_pad", "right_pad")
"""Geoms that touch what is grasped."""

VELOCITY_LIMITS = np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61])
"""(7,) greatest joint speeds, rad/s (Franka Control Interface, limits for Panda)."""

HOME = np.array([0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4])
"""(7,) rad, Franka's ready pose: the hand points down in front of the base."""

PACKAGE = Path(__file__).parent.parent / "assets"
LINKS = (*(f"link{i}" for i in range(8)), "hand")


def mesh_folder() -> Path | None:
    """Return the folder with `visual` and `collision` STL files, or None when they are not installed."""
    found = importlib.util.find_spec("gymnasium_robotics")
    if found is None or not found.submodule_search_locations:
        return None
    folder = Path(found.submodule_search_locations[0], "envs/assets/kitchen_franka/franka_assets/meshes")
    return folder if folder.is_dir() else None


def panda_spec(*, meshes: bool) -> mujoco.MjSpec:
    """Return the robot, its base frame at the origin.

    Args:
        meshes: dress it with meshes; otherwise it keeps its capsules. Kinematics, pads and inertia are the same.
    """
    spec = mujoco.MjSpec.from_file(str(PACKAGE / "panda.xml"))
    if meshes:
        pass
    return spec
