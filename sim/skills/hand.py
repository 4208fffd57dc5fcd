"""The hand close to objects: straight motions, closing lines free of collisions, and what it holds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim.errors import BlockedError
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

SETTLE_DURATION_S = 0.1
"""Wait before an object in the hand is measured and after it is let go."""


def move_tool(cell: Workcell, position: np.ndarray, yaws: Sequence[float]) -> float:
    """Move the tool along a straight line to a (3,) position nearby, m; return which of the yaws, rad, it took."""
    goal, yaw = cell.arm.reach(position, list(yaws))
    cell.follow(cell.arm.move(cell.reference, goal, position, yaw))
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


def passage_height(cell: Workcell, held: str | None = None) -> float:
    """Return the height of the tool at which it and its load clear all objects at rest, m."""
    shapes = cell.shapes
    tops = [cell.observe(obj).position[2] + shape.half[2] for obj, shape in shapes.items() if obj != held]
    below = shapes[held].half[2] if held else cell.scene.robot.gripper.fingertip_m
    return max(tops, default=0.0) + below + PASSAGE_CLEARANCE_M


def held_grip(cell: Workcell, obj: str) -> Grip:
    """Return the grip in which the hand holds an object."""
    turn = cell.arm.tool(cell.reference).yaw - cell.observe(obj).yaw
    return min(cell.scene.shapes[obj].grips, key=lambda grip: abs(wrap(turn - grip.turn, np.pi)))


def check_held(cell: Workcell, obj: str) -> None:
    """Raise SkillError unless the hand holds an object."""
    if cell.held() != obj:
        raise SkillError(f"no contact force on both finger pads: {obj} is not held")
