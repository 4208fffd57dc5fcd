"""Observations of all objects, made when it is certain which one is held and the others are at rest."""

import numpy as np

from sim.motion.trajectory import CONTROL_PERIOD_S
from sim.perception.sensors import ObjectPose, on_table
from sim.simulation.workcell import Workcell

FALL_SPEED_M_S = 0.05
"""An object that moves faster is falling, rolling or was knocked over: its pose is not final."""

REST_SPEED_M_S = 0.005
"""Greatest mean speed of an object at rest between two observations: half of what a certificate allows at the end."""

REST_PERIOD_S = 0.2
"""Least time between two observations that decide whether objects are at rest."""

REST_TIMEOUT_S = 3.0
"""How long to wait for objects to come to rest."""

REST_ERRORS = 6
"""Apparent motion of an object at rest, in standard deviations of an observed position."""


def await_grip(cell: Workcell) -> None:
    """Wait until it is certain whether the pads hold the handled object."""
    while cell.in_doubt:
        cell.wait(CONTROL_PERIOD_S)


def settled_poses(cell: Workcell, *, at_rest: bool) -> tuple[dict[str, ObjectPose], list[str]]:
    """Return the observed pose of every object, and the objects that are still moving after `REST_TIMEOUT_S`.

    With `at_rest`, an arm that holds an object ends its movement first, and the other objects come to rest. Else, it is
    enough that none but the held object is falling. The time between two observations is such that a noisy sensor can
    tell a small speed from 0. `ObservationTimeoutError` is raised if an object is not observed for too long.
    """
    speed, period = (REST_SPEED_M_S, REST_PERIOD_S) if at_rest else (FALL_SPEED_M_S, CONTROL_PERIOD_S)
    period = max(period, REST_ERRORS * cell.sensor.error / speed)
    if at_rest and cell.held() is not None:
        cell.settle()
    before, end = _certain_poses(cell), cell.data.time + REST_TIMEOUT_S
    while True:
        cell.wait(period)
        poses, held = _certain_poses(cell), cell.held()
        moved = {obj: np.linalg.norm(poses[obj].position - before[obj].position) for obj in poses.keys() & before}
        loose = [obj for obj, pose in poses.items() if obj != held and on_table(pose)]
        moving = [obj for obj in loose if moved.get(obj, np.inf) > speed * period]
        if not moving or cell.data.time > end:
            return poses, moving
        before = poses


def _certain_poses(cell: Workcell) -> dict[str, ObjectPose]:
    """Return the observed pose of every object, at a time when it is certain which object is held."""
    poses = cell.survey(cell.shapes)
    while cell.in_doubt:
        await_grip(cell)
        poses = cell.survey(cell.shapes)
    return poses
