"""Observations of all objects: taken when it is certain which one is held, and once all are at rest."""

from __future__ import annotations

import numpy as np

from sim.motion.trajectory import CONTROL_PERIOD_S
from sim.perception.sensors import ObjectPose
from sim.simulation.workcell import Workcell

REST_SPEED_M_S = 0.01
"""Greatest mean speed of an object at rest between two observations."""

REST_PERIOD_S = 0.2
"""Least time between two observations of objects that may be moving."""

REST_ERRORS = 6
"""How many standard deviations of an observed position an object at rest may seem to move."""

REST_TIMEOUT_S = 3.0
"""How long to wait for objects to come to rest."""


def await_grip(cell: Workcell) -> None:
    """Wait until it is certain whether the pads hold the handled object."""
    while cell.in_doubt:
        cell.wait(CONTROL_PERIOD_S)


def observed_poses(cell: Workcell) -> dict[str, ObjectPose]:
    """Return the observed pose of every object, taken when it is certain which object is held.

    Raises:
        ObservationTimeoutError: an object is not observed for too long.
    """
    poses = cell.survey(cell.shapes)
    while cell.in_doubt:
        await_grip(cell)
        poses = cell.survey(cell.shapes)
    return poses


def poses_at_rest(cell: Workcell) -> tuple[dict[str, ObjectPose], list[str]]:
    """Return the observed pose of every object once all are at rest, or after `REST_TIMEOUT_S`.

    Returns:
        The poses, and which objects move even then.

    Raises:
        ObservationTimeoutError: an object is not observed for too long.
    """
    # A noisy sensor tells so small a speed only after some time.
    period = max(REST_PERIOD_S, REST_ERRORS * cell.sensor.error / REST_SPEED_M_S)
    before, end = observed_poses(cell), cell.data.time + REST_TIMEOUT_S
    while True:
        cell.wait(period)
        poses = observed_poses(cell)
        moved = {
            obj: np.linalg.norm(pose.position - before[obj].position) for obj, pose in poses.items() if obj in before
        }
        moving = [obj for obj in poses if moved.get(obj, np.inf) > REST_SPEED_M_S * period]
        if not moving or cell.data.time > end:
            return poses, moving
        before = poses
