"""Transfer motions: paths of the tool over all objects at rest, or planned paths if those are in collision."""

import itertools
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from sim.errors import BlockedError, SimulationError
from sim.motion.joint_trajectory import JointTrajectory
from sim.motion.planning import EDGE_STEPS_M
from sim.motion.timing import along
from sim.motion.trajectory import ToolPose
from sim.simulation.collision import MAX_NEARING_M
from sim.simulation.workcell import Workcell
from sim.skills.hand import (
    BLEND_M,
    PATH_CLEARANCE_M,
    PLACING_MARGIN_RAD,
    PLANNING_CLEARANCE_M,
    RECONFIGURED,
    check_approach,
    check_path,
    move_tool,
)

DETOURS_M = ((0.0, 0.0), (0.1, 0.0), (0.0, 0.15))
"""Paths over all objects, to try in turn: additional height of the tool, and how much nearer to the base it passes
midway, m."""

SLOW_S = 7.0
"""A movement that takes longer is followed only if no quicker one is found, s; most take less than 3 s."""

OVERLAPS = (0.5, 0.25, 0.0)
"""Share of each line of a planned path that is blended with the next, to try in turn: corners are cut less and less."""


def travel(cell: Workcell, goals: Sequence[ToolPose], *, height: float, onward: ToolPose | None = None) -> None:
    """Move the tool to one of several distant poses along the first path that is free of collisions.

    Paths over all objects, at a `height` of the tool, m, are tried first: they look natural, need no search, and may
    begin before the arm is at rest. If all of them collide, the arm comes to rest, and they are tried again: the end of
    its previous movement may be nearer to bodies than a path may be. Then a path is planned. From its goal, the tool
    must be able to move straight to the pose `onward`, if this is given.

    Raises:
        BlockedError: no path is free of collisions.
        SimulationError: the goals, or `onward`, are out of reach.
    """
    blockers, slow, moving = set[str](), None, len(cell.ending) > 0
    ends = _ends(cell, goals, onward, blockers)
    first = list(itertools.islice(ends, 1))
    planned = () if moving else _planned(cell, itertools.chain(first, ends), blockers)
    for movement in itertools.chain(_over(cell, first, height), planned):
        try:
            if onward is not None:
                goal = movement.positions[-1]
                check_approach(cell, goal, cell.arm.tool(goal), onward)
            check_path(cell, movement, clearance=PATH_CLEARANCE_M, touching=False)
        except BlockedError as error:
            blockers.update(error.by)
            continue
        except SimulationError:
            continue
        if movement.seconds <= SLOW_S:
            cell.follow(movement, within=BLEND_M)
            return
        slow = movement if slow is None else min(slow, movement, key=len)
    if moving:
        cell.settle()
        travel(cell, goals, height=height, onward=onward)
        return
    if slow is not None:
        cell.follow(slow, within=BLEND_M)
        return
    if blockers:
        raise BlockedError.on_the_way(blockers, load=cell.attached)
    cell.arm.reach(goals, near=cell.reference, margin=PLACING_MARGIN_RAD)  # raises if none is in reach
    raise SimulationError(RECONFIGURED)


def leave(cell: Workcell, before: ToolPose, *, seconds: float = 0.0) -> None:
    """Move the open hand away from the object that it has let go, straight to a pose if no finger touches the object.

    Where the arm cannot keep to the straight line (`Arm.move`), a finger would push the object: the hand then goes
    round it. Moving straight takes at least `seconds`.

    Raises:
        BlockedError: no path is free of collisions.
        SimulationError: the pose is out of reach.
    """
    try:
        move_tool(cell, before, within=BLEND_M, seconds=seconds, touching=False)
    except BlockedError:
        travel(cell, [before], height=float(before.position[2]))


def _ends(
    cell: Workcell, goals: Sequence[ToolPose], onward: ToolPose | None, blockers: set[str]
) -> Iterator[tuple[np.ndarray, ToolPose]]:
    """Yield (n,) configurations, rad, each with its goal, from which the hand can move `onward`; add to `blockers`."""
    for q, k in cell.arm.configurations(goals, near=cell.reference, margin=PLACING_MARGIN_RAD):
        try:
            if onward is not None:
                check_approach(cell, q, goals[k], onward)
        except BlockedError as error:
            blockers.update(error.by)
        except SimulationError:
            continue
        else:
            yield q, goals[k]


def _over(cell: Workcell, ends: Iterable[tuple[np.ndarray, ToolPose]], height: float) -> Iterator[JointTrajectory]:
    """Yield movements over all objects; they are not checked for collisions."""
    for (goal, pose), (raised, drawn_in) in itertools.product(ends, DETOURS_M):
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
    cell: Workcell, ends: Iterable[tuple[np.ndarray, ToolPose]], blockers: set[str]
) -> Iterator[JointTrajectory]:
    """Yield movements along planned paths; add the bodies in the way to the blockers.

    Edges are checked coarsely at first: if the caller asks for more paths, they are planned with finer checks.
    """
    for step in EDGE_STEPS_M:
        reached = []
        for goal, pose in ends:
            try:
                path = planned_path(cell, goal, clearance=PLANNING_CLEARANCE_M, step=step)
            except BlockedError as error:
                blockers.update(error.by)
                continue
            reached.append((goal, pose))
            limits = cell.arm.limits(path[0], path[-1], load=cell.load)
            for overlap in OVERLAPS:
                yield along(limits, path, overlap=overlap)
        ends = reached


def planned_path(cell: Workcell, goal: np.ndarray, *, clearance: float, step: float = EDGE_STEPS_M[0]) -> np.ndarray:
    """Return a path, (K, n) rad, to a goal from where the arm rests.

    Bodies within the clearance at the start may come as near as along a movement (`CollisionChecker.blockers`).

    Args:
        cell: the running simulation.
        goal: (n,) joint angles, rad.
        clearance: bodies nearer than this count as in collision, m.
        step: distance between checks, m; see `EDGE_STEPS_M`.

    Raises:
        BlockedError: the goal is in collision, or no path was found.
    """
    checker = cell.collision_checker(held=cell.attached)
    least = {
        pair: PATH_CLEARANCE_M if distance >= PATH_CLEARANCE_M else distance - MAX_NEARING_M
        for pair, distance in checker.distances(cell.reference, within=clearance).items()
    }
    known: dict[bytes, set[str]] = {}

    def met(q: np.ndarray) -> set[str]:
        if (question := q.tobytes()) not in known:  # a search checks the ends of its edges repeatedly
            near = checker.distances(q, within=clearance)
            known[question] = {pair[1] for pair, distance in near.items() if distance < least.get(pair, clearance)}
        return known[question]

    return cell.planner.plan(cell.reference, goal, met, step=step)
