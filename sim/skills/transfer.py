"""Long ways of the hand: over everything that rests, and around what stands taller."""

from __future__ import annotations

import numpy as np

from sim.errors import BlockedError, SimulationError
from sim.simulation.workcell import Workcell

DETOURS = ((0.0, 0.0), (0.1, 0.0), (0.0, 0.15), (0.1, 0.15), (0.2, 0.0), (0.2, 0.2), (0.3, 0.0), (0.3, 0.2))
"""Ways to try in turn: how much higher the tool goes than over all objects, and how much nearer to the base, m."""

CLEARANCE = 0.006
"""Distance that the arm and what it carries keep from everything on the way, m: they trail by 2 mm at most."""

STRIDE = 3
"""Every so many joint references are looked at: the tool moves 18 mm meanwhile, which `CLEARANCE` makes up for."""


def travel(cell: Workcell, position: np.ndarray, line: float, *, height: float) -> None:
    """Move the tool to a position far away.

    Args:
        cell: the running simulation.
        position: (3,) where the tool shall be, m.
        line: heading of the closing line there, one end or the other, rad.
        height: at which it passes over everything that rests, m.

    Raises:
        BlockedError: something is in the way of every detour.
        SimulationError: the arm cannot get there, whatever the way.
    """
    goal, yaw = cell.arm.reach(position, [line, line + np.pi])
    met: set[str] = set()
    unreachable: SimulationError | None = None
    for raised, drawn_in in DETOURS:
        try:
            references = cell.arm.move(cell.reference, goal, position, yaw, height=height + raised, drawn_in=drawn_in)
        except SimulationError as error:
            unreachable = error
            continue
        obstacles = obstacles_on(cell, references)
        if not obstacles:
            cell.follow(references)
            return
        met |= obstacles
    if unreachable and not met:
        raise unreachable
    raise BlockedError(f"the way is blocked by {' and '.join(sorted(met))}", met)


def obstacles_on(cell: Workcell, references: np.ndarray) -> set[str]:
    """Return the names of the bodies that (N, 7) joint references come too near to; the first ones met are enough.

    What is too near already, such as an object that slipped against a finger, counts once it is left behind, and if
    it never is.
    """
    near = set(cell.foresee(cell.reference, clearance=CLEARANCE))
    for q in (*references[::STRIDE], references[-1]):
        met = set(cell.foresee(q, clearance=CLEARANCE))
        near &= met
        if met - near:
            return met - near
    return near
