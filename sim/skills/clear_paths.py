"""Paths of the arm that are free of collisions, seen from where it is now."""

from __future__ import annotations

import numpy as np

from sim.errors import BlockedError
from sim.motion.planning import EDGE_STEPS_M
from sim.simulation.collision import CollisionChecker
from sim.simulation.workcell import Workcell


def check_path(cell: Workcell, references: np.ndarray, *, clearance: float, touching: bool = True) -> CollisionChecker:
    """Check a movement from where the arm is now for collisions, those of the robot's own links included.

    Returns the checker, as it has seen what there is.

    Args:
        cell: the running simulation.
        references: (N, n) of the movement, rad; what is left of the one before is added.
        clearance: bodies nearer than this count as in collision, m (`CollisionChecker.blockers`).
        touching: whether the fingers may touch the handled object though they do not hold it.

    Raises:
        BlockedError: there is one.
    """
    held = cell.held() is not None
    checker = cell.collision_checker(held=held, width=None if held else cell.width, touching=touching)
    met = checker.blockers(np.vstack([cell.angles, cell.blended(references)]), clearance=clearance)
    if met:
        raise BlockedError.on_the_way(met)
    return checker


def planned_path(cell: Workcell, goal: np.ndarray, *, clearance: float, step: float = EDGE_STEPS_M[0]) -> np.ndarray:
    """Return a path, (K, n) rad, from where the arm is, or comes to rest, to a goal.

    What is near at the start may be as near on the way, but not touched unless it is from the start.

    Args:
        cell: the running simulation.
        goal: (n,) joint angles, rad.
        clearance: bodies nearer than this count as in collision, m.
        step: distance of two checks, m; see `EDGE_STEPS_M`.

    Raises:
        BlockedError: none was found.
    """
    checker = cell.collision_checker(touching=False)
    near = checker.touches(cell.reference, clearance=clearance)
    touched = checker.touches(cell.reference)
    known: dict[bytes, set[str]] = {}

    def met(q: np.ndarray) -> set[str]:
        if (question := q.tobytes()) not in known:  # searches ask again for the ends of their edges
            close = checker.touches(q, clearance=clearance)
            found = close - near
            if not found and close - touched:
                found = checker.touches(q) - touched
            known[question] = {other for _, other in found}
        return known[question]

    return cell.planner.plan(cell.reference, goal, met, step=step)
