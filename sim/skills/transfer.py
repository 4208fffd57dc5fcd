"""Transfer motions: paths of the hand over all objects at rest, and detours around taller obstacles."""

from __future__ import annotations

import numpy as np

from sim.errors import BlockedError, SimulationError
from sim.simulation.workcell import Workcell
from sim.skills.hand import BLEND_M

DETOURS = ((0.0, 0.0), (0.1, 0.0), (0.0, 0.15), (0.1, 0.15), (0.2, 0.0), (0.2, 0.2), (0.3, 0.0), (0.3, 0.2))
"""Paths to try in turn: how much higher than needed the tool passes, and how much nearer to the base midway, m."""

ROUND_ABOUT_M = (0.0, 0.15, 0.3)
"""Paths to try then, no higher than their ends, past what stands too high to reach over it: how much nearer, m."""

PATH_CLEARANCE_M = 0.006
"""Least clearance of the arm and its load from obstacles along a path; they deviate from it by 2 mm at most."""

REFERENCES_PER_CHECK = 3
"""One joint reference in this many is checked for collisions; the tool moves up to 18 mm between two checks."""


def travel(cell: Workcell, position: np.ndarray, line: float, *, height: float) -> None:
    """Move the tool to a distant position along the first path that is free of collisions.

    Args:
        cell: the running simulation.
        position: (3,) of the tool at the goal, m.
        line: heading of the closing line there, in either direction, rad.
        height: of the tool as it passes over objects at rest, m.

    Raises:
        BlockedError: every path that the arm can follow collides with a body.
        SimulationError: the arm cannot follow any of the paths.
    """
    goal, yaw = cell.arm.reach(position, [line, line + np.pi])
    blockers: set[str] = set()
    unreachable: SimulationError | None = None
    over = [(height + raised, drawn_in) for raised, drawn_in in DETOURS]
    for passage, drawn_in in (*over, *((None, drawn_in) for drawn_in in ROUND_ABOUT_M)):
        try:
            references = cell.arm.move(
                cell.reference,
                goal,
                position,
                yaw,
                height=passage,
                drawn_in=drawn_in,
                ending=cell.ending,
            )
        except SimulationError as error:
            unreachable = error
            continue
        obstacles = obstacles_on(cell, references)
        if not obstacles:
            cell.follow(references, within=BLEND_M)
            return
        blockers |= obstacles
    if unreachable and not blockers:
        raise unreachable
    raise BlockedError(f"the way is blocked by {' and '.join(sorted(blockers))}", blockers)


def obstacles_on(cell: Workcell, references: np.ndarray) -> set[str]:
    """Return the names of the bodies within the clearance at the first collision along (N, joints) references, rad.

    A body that is within it at the start, such as an object that slipped against a finger, counts only if the arm
    comes near it again after leaving it, or never leaves it.
    """
    references = cell.blended(references)
    near = set(cell.collisions(cell.angles, clearance=PATH_CLEARANCE_M))
    for q in (*references[::REFERENCES_PER_CHECK], references[-1]):
        met = set(cell.collisions(q, clearance=PATH_CLEARANCE_M))
        near &= met
        if met - near:
            return met - near
    return near
