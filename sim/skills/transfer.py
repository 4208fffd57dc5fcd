"""Transfer motions: paths of the tool over all objects at rest, or planned paths if those are in collision."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from sim.errors import BlockedError, SimulationError
from sim.motion.planning import EDGE_STEPS_M
from sim.motion.timing import along, begun_late
from sim.motion.trajectory import ToolPose
from sim.simulation.workcell import Workcell
from sim.skills.clear_paths import check_path, planned_path
from sim.skills.hand import (
    BLEND_M,
    PATH_CLEARANCE_M,
    PLACING_MARGIN_RAD,
    PLANNING_CLEARANCE_M,
    check_approach,
    move_tool,
)

DETOURS_M = ((0.0, 0.0), (0.1, 0.0), (0.0, 0.15))
"""Paths over all objects, to try in turn: additional height of the tool, and how much nearer to the base it passes
midway, m."""

OVERLAPS = (0.5, 0.25, 0.0)
"""Share of each line of a planned path that is blended with the next, to try in turn: corners are cut less and less."""


def travel(cell: Workcell, goals: Sequence[ToolPose], *, height: float, onward: ToolPose | None = None) -> None:
    """Move the tool to one of several distant poses along the first path that is free of collisions.

    Paths over all objects come first: they look natural and need no search. If all of them collide, one is planned.

    Args:
        cell: the running simulation.
        goals: acceptable poses.
        height: of the tool as it passes over objects at rest, m.
        onward: pose to which the tool then moves straight from its goal; None if it is not known or right below.

    Raises:
        BlockedError: no path is free of collisions.
        SimulationError: the goals, or `onward`, are out of reach.
    """
    blockers: set[str] = set()
    for references in itertools.chain(_over(cell, goals, height), _planned(cell, goals, onward, blockers)):
        try:
            if onward is not None:
                check_approach(cell, references[-1], cell.arm.tool(references[-1]), onward)
            check_path(cell, references, clearance=PATH_CLEARANCE_M, touching=False)
        except BlockedError as error:
            blockers.update(error.by)
            continue
        except SimulationError:
            continue
        cell.follow(references, within=BLEND_M)
        return
    if blockers:
        raise BlockedError.on_the_way(blockers)
    cell.arm.reach(goals, near=cell.reference, margin=PLACING_MARGIN_RAD)  # raises if none is in reach
    raise SimulationError("the arm would have to change its configuration on the way")


def leave(cell: Workcell, before: ToolPose, *, seconds: float = 0.0) -> None:
    """Move the open hand away from the handled object that it has let go, straight to a pose if the object stays free.

    Where the arm cannot keep to the straight line (`Arm.move`), a finger would push the object: it then goes round it.

    Args:
        cell: the running simulation.
        before: the pose.
        seconds: least duration of moving straight, s.

    Raises:
        BlockedError: no path is free of collisions.
        SimulationError: the pose is out of reach.
    """
    try:
        move_tool(cell, [before], within=BLEND_M, seconds=seconds, touching=False)
    except BlockedError:
        travel(cell, [before], height=float(before.position[2]))


def _over(cell: Workcell, goals: Sequence[ToolPose], height: float) -> Iterator[np.ndarray]:
    """Yield the (N, n) references, rad, of movements over all objects; they are not checked for collisions."""
    near = cell.arm.configurations(goals, near=cell.reference, margin=PLACING_MARGIN_RAD, seeds=0)
    for (goal, pose), (raised, drawn_in) in itertools.product(itertools.islice(near, 1), DETOURS_M):
        try:
            yield cell.arm.move(
                cell.reference,
                goal,
                pose,
                height=height + raised,
                drawn_in=drawn_in,
                ending=cell.ending,
                load=cell.load,
            )
        except SimulationError:
            continue


def _planned(
    cell: Workcell, goals: Sequence[ToolPose], onward: ToolPose | None, blockers: set[str]
) -> Iterator[np.ndarray]:
    """Yield the (N, n) references, rad, of movements along planned paths; add the bodies in the way to the blockers.

    The edges of a path are checked coarsely, so movements along it may still collide: if the caller asks for more,
    paths are planned with finer checks.
    """
    ends: Iterable[tuple[np.ndarray, ToolPose]]
    ends = cell.arm.configurations(goals, near=cell.reference, margin=PLACING_MARGIN_RAD)
    for step in EDGE_STEPS_M:
        reached = []
        for goal, pose in ends:
            try:
                if onward is not None:
                    check_approach(cell, goal, pose, onward)  # before a path is planned in vain
                path = planned_path(cell, goal, clearance=PLANNING_CLEARANCE_M, step=step)
            except BlockedError as error:
                blockers.update(error.by)
            except SimulationError:
                continue
            else:
                reached.append((goal, pose))
                limits = cell.arm.limits(path[0], path[-1], load=cell.load)
                for overlap in OVERLAPS:
                    references = along(limits, path, overlap=overlap)
                    yield begun_late(limits, references, cell.reference, cell.ending)
        ends = reached
