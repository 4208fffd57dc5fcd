"""Collision-free paths of the arm from its current configuration, with the objects as last observed."""

from __future__ import annotations

import numpy as np

from sim.errors import BlockedError
from sim.motion.joint_trajectory import JointTrajectory
from sim.motion.planning import EDGE_STEPS_M
from sim.simulation.workcell import Workcell


def check_path(cell: Workcell, movement: JointTrajectory, *, clearance: float, touching: bool = True) -> None:
    """Check a movement from the current configuration for collisions, including those between the robot's own links.

    Args:
        cell: the running simulation.
        movement: from where the arm will rest; the rest of the previous movement is added to it.
        clearance: bodies nearer than this count as in collision, m (`CollisionChecker.blockers`).
        touching: whether the fingers may hold or touch the handled object even if it is not attached.

    Raises:
        BlockedError: there is a collision.
    """
    held = cell.held() if touching or cell.attached else None
    touched = cell.contacts.handled if touching else None
    width = cell.width if held is None else None
    checker = cell.collision_checker(touching=touched, held=held or cell.attached, width=width)
    met = checker.blockers(np.vstack([cell.angles, cell.blended(movement.references)]), clearance=clearance)
    if met:
        raise BlockedError.on_the_way(met)


def planned_path(cell: Workcell, goal: np.ndarray, *, clearance: float, step: float = EDGE_STEPS_M[0]) -> np.ndarray:
    """Return a path, (K, n) rad, to a goal from where the arm rests, or will rest when its movement ends.

    Bodies within the clearance at the start may be within it on the whole path, but must not come into contact, unless
    they are in contact at the start.

    Args:
        cell: the running simulation.
        goal: (n,) joint angles, rad.
        clearance: bodies nearer than this count as in collision, m.
        step: distance between checks, m; see `EDGE_STEPS_M`.

    Raises:
        BlockedError: the goal is in collision, or no path was found.
    """
    checker = cell.collision_checker(held=cell.attached)
    near = checker.touches(cell.reference, clearance=clearance)
    touched = checker.touches(cell.reference)
    known: dict[bytes, set[str]] = {}

    def met(q: np.ndarray) -> set[str]:
        if (question := q.tobytes()) not in known:  # a search checks the ends of its edges repeatedly
            close = checker.touches(q, clearance=clearance)
            found = close - near
            if not found and close - touched:
                found = checker.touches(q) - touched
            known[question] = {other for _, other in found}
        return known[question]

    return cell.planner.plan(cell.reference, goal, met, step=step)
