"""Observations of all objects: taken when it is certain which one is held, and once all are at rest."""

from __future__ import annotations

import numpy as np

from sim.motion.trajectory import CONTROL_PERIOD_S
from sim.perception.sensors import ObjectPose
from sim.simulation.workcell import Workcell

REST_DISTANCE_M = 0.004
"""An object at rest moves by less than this within `REST_PERIOD_S`."""

REST_PERIOD_S = 0.2
"""Time between two observations of objects that may be moving."""

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


def poses_at_rest(cell: Workcell) -> dict[str, ObjectPose]:
    """Return the observed pose of every object once all are at rest, or after `REST_TIMEOUT_S`.

    Raises:
        ObservationTimeoutError: an object is not observed for too long.
    """
    poses = observed_poses(cell)
    for _ in range(round(REST_TIMEOUT_S / REST_PERIOD_S)):
        before = poses
        cell.wait(REST_PERIOD_S)
        poses = observed_poses(cell)
        if before.keys() != poses.keys():
            continue
        moved = (np.linalg.norm(pose.position - before[obj].position) for obj, pose in poses.items())
        if max(moved, default=0.0) < REST_DISTANCE_M:
            break
    return poses
