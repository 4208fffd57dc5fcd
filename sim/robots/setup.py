"""Checks of what a scenario says of its robot."""

from __future__ import annotations

import math

from prefplan.errors import check_known, prefixed
from prefplan.models.manipulation.surroundings import GripperSetup, RobotSetup, check_point, with_height
from sim.errors import SimulationError

GRIPPERS = ("parallel", "suction")
"""Kinds of grippers: two fingers, and a suction cup."""

MAX_OPENING_M = 0.5
"""Largest opening of a gripper; larger ones are probably in millimetres."""

OWN_KEYS = ("joints", "tool", "gripper", "home", "velocity", "torque")
"""Keys that a robot of the user's own needs."""


def check_robot(robot: RobotSetup) -> None:
    """Raise `SimulationError` for an invalid pose of the base, or invalid keys of a robot of the user's own."""
    if robot.at is not None:
        with prefixed("", new=SimulationError):
            check_point(robot.at, "robot.at")
        height = with_height(robot.at)[2]
        if height < 0:
            raise SimulationError(f"robot.at: the base is {-height:g} m below the table top; at least 0")
    if not math.isfinite(robot.yaw):
        raise SimulationError(f"robot.yaw: must be a finite number of degrees, not {robot.yaw}")
    _check_own(robot)


def _check_own(robot: RobotSetup) -> None:
    """Raise `SimulationError` if the table of a robot of the user's own lacks a key or has an invalid value."""
    if robot.mjcf is None:
        for key in (*OWN_KEYS, "acceleration"):
            if getattr(robot, key):
                raise SimulationError(f"robot.{key}: needs robot.mjcf, the file of a robot of one's own")
        return
    for key in OWN_KEYS:
        if not getattr(robot, key):
            raise SimulationError(f"robot.{key}: missing; a robot with `mjcf` needs {', '.join(OWN_KEYS)}")
    count = len(robot.joints)
    for key in ("home", "velocity", "torque", "acceleration"):
        values = getattr(robot, key)
        if values and len(values) != count:
            raise SimulationError(
                f"robot.{key}: must have {count} entries, one for each of robot.joints, not {len(values)}"
            )
        if not all(math.isfinite(value) and (value > 0 or key == "home") for value in values):
            wanted = "finite numbers" if key == "home" else "positive numbers"
            raise SimulationError(f"robot.{key}: must be {wanted}, not {list(values)}")
    for joint in robot.joints:
        if robot.joints.count(joint) > 1:
            raise SimulationError(f"robot.joints: {joint!r} is listed twice")
    if robot.gripper is not None:
        _check_gripper(robot.gripper)


def _check_gripper(gripper: GripperSetup) -> None:
    where = "robot.gripper"
    check_known(f"{where}.kind", "kind", gripper.kind, GRIPPERS, SimulationError)
    if not (math.isfinite(gripper.force) and gripper.force > 0):
        raise SimulationError(f"{where}.force: must be positive, N, not {gripper.force}")
    if gripper.kind == "parallel":
        if gripper.open is None:
            raise SimulationError(f"{where}.open: missing; the greatest width between the fingers, m")
        if not 0 <= gripper.closed < gripper.open <= MAX_OPENING_M:
            raise SimulationError(
                f"{where}: 0 <= closed < open <= {MAX_OPENING_M:g} m, not {gripper.closed:g} and {gripper.open:g}"
            )
