"""The hand close to objects: straight motions, closing lines free of collisions, and what it holds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from sim.errors import BlockedError, SimulationError
from sim.motion.trajectory import wrap
from sim.simulation.workcell import Workcell
from sim.skills.skill import SkillError
from sim.world.shapes import Grip

HOVER_HEIGHT_M = 0.12
"""Height of the tool over a slot's centre before and after it grasps or releases: a held block clears a resting one."""

PASSAGE_CLEARANCE_M = 0.03
"""Least clearance at which the tool or its load passes over objects at rest."""

CLOSING_CHECKS = 4
"""Number of gripper widths checked for collision while closing: a finger, 11 mm thick, cannot pass a wall between."""

FINGER_CLEARANCE_M = 0.0015
"""Least clearance of the fingers from other bodies: the arm comes to rest within 1 mm of its reference."""

OPEN_DURATION_S = 0.25
"""Duration of opening the hand."""

BLEND_M = 0.02
"""Distance of the tool from its goal at which the next movement may begin."""


def move_tool(
    cell: Workcell,
    position: np.ndarray,
    yaws: Sequence[float],
    *,
    within: float = 0.0,
    seconds: float = 0.0,
    watch: Callable[[], None] = lambda: None,
) -> float:
    """Move the tool along a straight line to a (3,) position nearby, m; return which of the yaws, rad, it took.

    Args:
        cell: the running simulation.
        position: of the tool at its goal, m.
        yaws: those that would do, rad.
        within: distance from the goal at which the next movement may begin, m; 0 to come to rest there.
        seconds: least duration, s.
        watch: called again and again meanwhile; if it raises an error, the arm brakes.
    """
    goal, yaw = cell.arm.reach(position, list(yaws))
    references = cell.arm.move(cell.reference, goal, position, yaw, seconds=seconds, ending=cell.ending)
    cell.follow(references, within=within, watch=watch)
    return yaw


def free_closing_line(
    cell: Workcell, position: np.ndarray, options: Sequence[tuple[float, Grip]]
) -> tuple[float, Grip]:
    """Return the first closing line, with its grip, on which the fingers close on an object without a collision.

    Args:
        cell: the running simulation.
        position: (3,) of the object's centre, m.
        options: closing lines, rad, and grips to try in turn.

    Raises:
        BlockedError: none is free.
    """
    blockers: set[str] = set()
    for line, grip in options:
        q, _ = cell.arm.reach(position + [0.0, 0.0, grip.lift], [line, line + np.pi])
        widths = np.linspace(grip.opening, grip.width, CLOSING_CHECKS)
        obstacles = {
            obj for width in widths for obj in cell.collisions(q, width=float(width), clearance=FINGER_CLEARANCE_M)
        }
        if not obstacles:
            return line, grip
        blockers |= obstacles
    raise BlockedError(f"no room for the fingers: they would touch {' and '.join(sorted(blockers))}", blockers)


def passage_height(cell: Workcell, objects: Iterable[str], *, held: str | None = None) -> float:
    """Return the height of the tool at which it and its load clear some objects at rest, m."""
    shapes = cell.scene.shapes
    tops = [cell.observe(obj).position[2] + shapes[obj].half[2] for obj in objects if obj != held]
    below = shapes[held].half[2] if held else cell.scene.robot.gripper.fingertip_m
    return max(tops, default=0.0) + below + PASSAGE_CLEARANCE_M


def reaches(cell: Workcell, position: np.ndarray) -> bool:
    """Return whether the hand reaches a (3,) position, m, from above, in any of eight directions."""
    if position[2] < 0:
        return False
    lines = [np.pi / 4 * k for k in range(8)]
    try:
        for height in (0.0, HOVER_HEIGHT_M):
            cell.arm.reach(position + [0.0, 0.0, height], lines)
    except SimulationError:
        return False
    return True


def held_grip(cell: Workcell, obj: str) -> Grip:
    """Return the grip in which the hand holds an object."""
    turn = cell.arm.tool(cell.angles).yaw - cell.observe(obj).yaw
    return min(cell.scene.shapes[obj].grips, key=lambda grip: abs(wrap(turn - grip.turn, np.pi)))


def check_held(cell: Workcell, obj: str) -> None:
    """Raise SkillError unless the hand holds an object."""
    if cell.held() != obj:
        raise SkillError(f"no contact force on both finger pads: {obj} is not held")
