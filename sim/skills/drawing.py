"""Drawing free: an object without space for the fingers beside it is pressed from above and drawn away from walls."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np

from sim.errors import SimulationError
from sim.motion.trajectory import ToolPose
from sim.perception.sensors import ObjectPose, Posture
from sim.robots.gripper import SuctionGripper
from sim.simulation.kinematic_cell import PRESSED_N
from sim.simulation.workcell import Workcell
from sim.skills.grasp_choice import find_grasp
from sim.skills.hand import OPEN_DURATION_S, free_pose, move_tool
from sim.skills.placing import obstacles
from sim.skills.skill import SkillError
from sim.skills.transfer import travel
from sim.world.grasps import GraspPose

DISTANCES_M = (0.03, 0.045, 0.06, 0.09, 0.12)
"""How far to draw an object, to try in turn, m."""

STEP_M = 0.01
"""Distance between the places at which it must be free on the way, m."""

STROKE_M, MAX_STROKES = 0.03, 16
"""How far the fingers move while they press an object, m, and how often."""

SHARE_DRAWN = 0.8
"""Share of the distance after which an object counts as drawn free."""

MAX_DIRECTIONS = 3
"""Number of directions to try for each distance: where none of them frees it, the others hardly do."""

DIRECTIONS_RAD = np.radians(np.arange(0, 360, 22.5))
"""Headings in which to draw it."""

PRESS_DURATION_S = 3.0
"""Least duration of the last part of the way down, which ends when the fingertips feel the object."""

RISE_DURATION_S = 1.0
"""Least duration of raising the hand from an object, which may have tipped and springs back."""

PRESS_FORCE_N = 2.0
"""Force on a pad at which the way down ends."""

STROKE_STEP_M, STROKE_STEP_S = 0.003, 0.15
"""Length and least duration of the steps of a stroke; between them the hand gives way to the object or follows it."""

HOLD_DOWN_N, HOLD_DOWN_N_KG, COMPLIANCE_M_N, MAX_GIVE_M = 2 * PRESSED_N, 20.0, 0.0001, 0.001
"""Force with which the object is pressed in a stroke, and how much more for each kg of it, so that it slides rather on
what carries it; how far the hand rises for each N more, and at most in a step."""

BEHIND_CREST_M, MAX_ROLL_M = 0.004, 0.005
"""Where the middle of the fingertips is pressed on a round object that rolls under them, and how far over its crest it
comes then, m: where they leave it, it springs back. The Panda's are 20 mm wide."""

SLIDING, OFF_CENTRE = 0.8, (0.4, 0.75)
"""Friction of objects on the table, and how far from the middle of its top an object may be pressed, as a share of half
a side: the least and the most. What is high for its width tips over its front edge if it is pressed near its middle."""

OFFSETS = np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [1, -1], [-1, 1], [-1, -1]])
"""(K, 2) directions from the middle, to try in turn."""

TILTS_RAD = np.radians([0, 30, 45])
"""How far the hand leans over to where the object is drawn, away from a wall behind it, to try in turn."""

TIP_HALF_M = 0.01
"""Half the width of a fingertip, m: the edge of a tilted one is ahead of its middle."""

CLOSED = GraspPose(np.zeros(3), np.eye(3), width=0.004, clearance=0.0)
"""The hand as it presses: nearly closed, so that its pads do not press each other."""


class _FeltError(SimulationError):
    """The fingertips press the object hard enough."""


def find_draw(cell: Workcell, obj: str, pose: ObjectPose) -> np.ndarray | None:
    """Return the (3,) shift, m, by which to draw an object to where it can be taken; None if that is not found."""
    if isinstance(cell.scene.robot.gripper, SuctionGripper):
        return None
    for shift in _shifts(cell, obj, pose):
        drawn = replace(pose, position=pose.position + SHARE_DRAWN * shift)
        if find_grasp(cell, obj, drawn, pose.yaw, foreseen=False) is not None:
            with suppress(SimulationError):
                _pressing(cell, obj, pose, shift)
                return shift
    return None


def draw_free(cell: Workcell, obj: str, shift: np.ndarray) -> None:
    """Press an object from above with closed fingers and draw it aside, in several strokes, since it slips or rolls.

    Args:
        cell: the running simulation.
        obj: the object.
        shift: (3,) by which it is drawn, m.

    Raises:
        SkillError: it did not come along.
        BlockedError: bodies are in the way.
    """
    start = cell.measure(obj).position
    cell.grip(CLOSED.width, OPEN_DURATION_S)
    for _ in range(MAX_STROKES):
        pose = cell.measure(obj)
        came = (pose.position - start) * [1.0, 1.0, 0.0]
        if came @ shift >= SHARE_DRAWN * shift @ shift:
            cell.log_event("drawn free", object=obj, distance_mm=round(1000 * float(np.hypot(*came[:2])), 1))
            return
        _stroke(cell, obj, pose, shift - came)
    raise SkillError(f"{obj} could not be drawn free: it slips under the fingers")


def _stroke(cell: Workcell, obj: str, pose: ObjectPose, left: np.ndarray) -> None:
    """Draw an object at a pose towards where it is to be, (3,) m away, as far as it comes along; raise the hand."""
    before, over = _pressing(cell, obj, pose, left)
    up, heading = before.position - over.position, left / np.linalg.norm(left)
    if before.points_down:
        move_tool(cell, [before])
    else:
        travel(cell, [before], height=float(before.position[2]), onward=over)
    move_tool(cell, [over])

    lowest = over.shifted([0.0, 0.0, -cell.scene.robot.gripper.fingertip_m])
    hold_down = HOLD_DOWN_N + HOLD_DOWN_N_KG * cell.scene.shapes[obj].mass
    try:
        with suppress(_FeltError):
            move_tool(cell, [lowest], seconds=PRESS_DURATION_S, watch=lambda: _feel(cell, PRESS_FORCE_N))
        for _ in range(round(STROKE_M / STROKE_STEP_M)):
            excess = float(cell.contacts.pad_forces.sum()) - hold_down
            give = np.clip(COMPLIANCE_M_N * excess, -MAX_GIVE_M, MAX_GIVE_M)
            step = STROKE_STEP_M * heading + [0.0, 0.0, give]
            move_tool(cell, [cell.arm.tool(cell.reference).shifted(step)], seconds=STROKE_STEP_S)
            if _rolled(cell, obj, heading):
                break
    finally:
        move_tool(cell, [cell.arm.tool(cell.reference).shifted(up)], seconds=RISE_DURATION_S)


def _rolled(cell: Workcell, obj: str, heading: np.ndarray) -> bool:
    """Return whether a round object has rolled so far under the fingertips that they are about to leave its crest."""
    pose = cell.observe(obj)
    off = _lowest_point(cell, cell.arm.tool(cell.angles)) - pose.position
    axis = pose.rotation[:, 2]
    across = (off - (off @ axis) * axis)[:2]
    return _lies_round(pose) and np.hypot(*across) > MAX_ROLL_M and across @ heading[:2] > 0


def _feel(cell: Workcell, force: float) -> None:
    """Raise _FeltError if a pad is pressed with more than a force, N."""
    if cell.contacts.pad_forces.max() > force:
        raise _FeltError


def _pressing(cell: Workcell, obj: str, pose: ObjectPose, shift: np.ndarray) -> tuple[ToolPose, ToolPose]:
    """Return where the closed fingertips are just above an object at a pose, after from where they come.

    Nothing may be in their way where they would be if it gave way by as much as they are above it then.

    Raises:
        BlockedError: bodies are in the way everywhere.
        SimulationError: the arm reaches it nowhere.
    """
    refused = SimulationError(f"{obj} is out of reach")
    give = np.array([0.0, 0.0, cell.scene.robot.gripper.fingertip_m])
    for tilt, (offset, yaw) in itertools.product(TILTS_RAD, _presses(pose, shift)):
        turned = ToolPose.down(pose.position + [*offset, pose.above], yaw).leaning(tilt, shift)
        goal = turned.shifted(turned.position - _lowest_point(cell, turned) - give)
        try:
            before, lowest = free_pose(cell, [goal], CLOSED, near=cell.reference)
            free_pose(cell, [lowest.shifted(shift)], CLOSED, near=cell.reference)
        except SimulationError as error:
            refused = error
            continue
        return before, lowest.shifted(give)
    raise refused


def _lowest_point(cell: Workcell, tool: ToolPose) -> np.ndarray:
    """Return the (3,) middle of the fingertips, or of their edge that is lowest if the hand is tilted, m."""
    side = tool.rotation[:, 0]
    edge = 0.0 if tool.points_down else -np.sign(side[2]) * TIP_HALF_M
    return tool.ahead(cell.scene.robot.gripper.fingertip_m) + edge * side


def _presses(pose: ObjectPose, shift: np.ndarray) -> Iterator[tuple[np.ndarray, float]]:
    """Yield where to press an object, (2,) m from its middle, and the heading of the closing direction, rad.

    Drawn at its rear it tips the least. A round side is pressed along its crest, or a little behind it, by the
    fingertips' narrow side.
    """
    sides = pose.footprint
    share = np.clip(SLIDING * (pose.above + pose.below) / sides.half.min() - 1, *OFF_CENTRE)
    offsets = (share * OFFSETS * sides.half) @ sides.axes
    yaws = [sides.yaw, sides.yaw + np.pi / 2]
    if _lies_round(pose):
        axis = pose.rotation[:2, 2]
        across = np.array([-axis[1], axis[0]])
        behind = BEHIND_CREST_M * across * np.sign(across @ shift[:2])
        offsets = OFF_CENTRE[0] * pose.shape.half[2] * np.outer([0, 1, -1], axis)
        offsets, yaws = np.vstack([offsets - behind, offsets]), [float(np.arctan2(axis[1], axis[0]))]
    rear_first = sorted(offsets, key=lambda offset: round(float(offset @ shift[:2]), 6))
    return itertools.product(rear_first, yaws)


def _lies_round(pose: ObjectPose) -> bool:
    """Return whether an object lies on a round side."""
    return pose.shape.is_round and pose.posture != Posture.UPRIGHT


def _shifts(cell: Workcell, obj: str, pose: ObjectPose) -> Iterator[np.ndarray]:
    """Yield (3,) shifts to try, m, by which an object meets nothing: short ones first, then the middle of the free."""
    headings = np.column_stack([np.cos(DIRECTIONS_RAD), np.sin(DIRECTIONS_RAD), np.zeros(len(DIRECTIONS_RAD))])
    if _lies_round(pose):
        along = pose.rotation[:, 2] * [1.0, 1.0, 0.0]
        headings = np.array([[-along[1], along[0], 0.0], [along[1], -along[0], 0.0], along, -along])
    meets = obstacles(cell, obj)
    for distance in DISTANCES_M:
        steps = np.arange(distance, 0, -STEP_M)
        free = [
            heading
            for heading in headings
            if not any(meets(replace(pose, position=pose.position + step * heading)) for step in steps)
        ]
        middle = np.sum(free, axis=0) if free else np.zeros(3)
        yield from (
            distance * heading
            for heading in sorted(free, key=lambda heading: -float(heading @ middle))[:MAX_DIRECTIONS]
        )
