"""Dragging free: an object with too little space for the fingers beside it is pressed and dragged away from walls."""

import itertools
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np

from sim.errors import SimulationError
from sim.motion.trajectory import ToolPose
from sim.perception.sensors import ObjectPose
from sim.robots.gripper import GRAVITY_M_S2, SuctionGripper
from sim.simulation.kinematic_cell import PRESSED_N
from sim.simulation.workcell import Workcell
from sim.skills.grasp_choice import find_grasp
from sim.skills.hand import OPEN_DURATION_S, SIDEWAYS, free_pose, most_central, move_tool
from sim.skills.placing import obstacles
from sim.skills.skill import SkillError
from sim.skills.transfer import travel
from sim.world.grasps import GraspPose
from sim.world.objects import OBJECT_SURFACE

DISTANCES_M = (0.03, 0.045, 0.055)
"""Distances to drag an object, to try in turn, m: after `SHARE_DRAGGED` of each, it still counts as at its location."""

STEP_M = 0.01
"""Distance between the positions on the way at which the object is checked for collisions, m."""

STROKE_M = 0.03
"""How far the fingers move in one stroke, pressing the object, m."""

MIN_PROGRESS_M = 0.005
"""Least distance that a stroke drags an object towards its goal, m: if it is less, the fingers slip."""

SHARE_DRAGGED = 0.8
"""Share of the distance after which an object counts as dragged free."""

MAX_DIRECTIONS = 3
"""Number of directions to try for each distance: if none of them frees the object, another one rarely does."""

PRESS_DURATION_S = 3.0
"""Least duration of the last part of the way down, which ends early when the fingertips press the object."""

RISE_DURATION_S = 1.0
"""Least duration of raising the hand from an object: one that has tipped springs back."""

PRESS_FORCE_N = 2.0
"""Force on any pad at which the hand stops moving down, N."""

STROKE_STEP_M = 0.003
"""Length of the steps of a stroke, m; each also corrects the hand's height by the measured force."""

STROKE_STEP_S = 0.15
"""Least duration of a step of a stroke, s."""

HOLD_DOWN_N = 2 * PRESSED_N
"""Target force on both pads together in a stroke, N."""

COMPLIANCE_M_N = 0.0001
"""Rise of the hand in a step for each newton above the target force, m/N."""

MAX_GIVE_M = 0.001
"""Greatest correction of the hand's height in a step, m."""

SLIDING = OBJECT_SURFACE[0]
"""Friction coefficient of objects on what they lie on."""

SLIP_RESERVE = 1.1
"""Least ratio of the greatest friction force under the fingers to the force that makes an object slide."""

TIPPING_SHARE = 0.7
"""Share of the friction's lever that counts in the test for tipping: an object may rock forward a little.

Of random objects in corners that passed `find_drag`, 4 of 8 were dragged free with the tests for slipping and tipping,
and 6 of 43 without."""

BEHIND_CREST_M = 0.004
"""Distance behind the crest of a lying round object at which the fingertips' middle starts to roll it, m."""

MAX_ROLL_M = 0.005
"""Distance of the fingertips' middle beyond the crest at which a stroke ends, m: if the fingertips, 20 mm wide on the
Panda, left the crest, the object would spring back."""

OFF_CENTRE = 0.4, 0.75
"""Least and greatest distance from the middle of its top at which an object is pressed, as shares of half a side."""

OFFSETS = np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [1, -1], [-1, 1], [-1, -1]])
"""(K, 2) directions from the middle of the top to where it is pressed."""

TILTS_RAD = np.radians([0, 30, 45])
"""Tilts of the hand towards where the object is dragged, away from a wall behind it, to try in turn."""

TIP_HALF_M = 0.01
"""Half the width of a fingertip, m: one edge of a tilted fingertip is lower than its middle."""

CLOSED = GraspPose(np.zeros(3), np.eye(3), width=0.004, clearance=0.0)
"""The hand while it presses an object: nearly closed, so that its pads do not press each other."""


class _FeltError(SimulationError):
    """A pad is pressed hard enough: the hand stops moving down."""


def find_drag(cell: Workcell, obj: str, pose: ObjectPose) -> np.ndarray | None:
    """Return a (3,) shift, m, by which to drag an object to where it can be grasped; None if none is found.

    A suction cup drags no objects, and fingers drag none that would slip under them.
    """
    gripper = cell.scene.robot.gripper
    friction = float(cell.scene.mujoco.geom(gripper.pads[0]).friction[0])
    slips = friction * HOLD_DOWN_N < SLIP_RESERVE * SLIDING * (HOLD_DOWN_N + _weight(cell, obj))
    if slips or isinstance(gripper, SuctionGripper):
        return None
    for shift in _shifts(cell, obj, pose):
        drawn = replace(pose, position=pose.position + SHARE_DRAGGED * shift)
        if find_grasp(cell, obj, drawn, pose.yaw) is not None:
            with suppress(SimulationError):
                _pressing(cell, obj, pose, shift)
                return shift
    return None


def drag_free(cell: Workcell, obj: str, shift: np.ndarray) -> None:
    """Press an object from above with closed fingers and drag it by a (3,) shift, m, in strokes: it slides or rolls.

    Raises:
        SkillError: the object slips under the fingers.
        BlockedError: bodies are in the way.
        SimulationError: the arm does not reach the object.
    """
    start, length, reached = cell.measure(obj).position, float(np.linalg.norm(shift)), -np.inf
    cell.grip(CLOSED.width, OPEN_DURATION_S)
    while True:
        pose = cell.measure(obj)
        came = (pose.position - start) * [1.0, 1.0, 0.0]
        along = float(came @ shift) / length
        if along >= SHARE_DRAGGED * length:
            cell.log_event("drawn free", object=obj, distance_mm=round(1000 * float(np.hypot(*came[:2])), 1))
            return
        if along < reached + MIN_PROGRESS_M:
            raise SkillError(f"{obj} could not be dragged free: it slipped under the fingers")
        reached = along
        _stroke(cell, obj, pose, shift - came)


def _stroke(cell: Workcell, obj: str, pose: ObjectPose, left: np.ndarray) -> None:
    """Drag an object at a pose by at most one stroke along its remaining shift, (3,) m, and raise the hand."""
    before, over = _pressing(cell, obj, pose, left)
    up, heading = before.position - over.position, left / np.linalg.norm(left)
    lowest = over.shifted([0.0, 0.0, -cell.scene.robot.gripper.fingertip_m])
    travel(cell, [before], height=float(before.position[2]), onward=lowest)
    move_tool(cell, over)

    try:
        with suppress(_FeltError):
            move_tool(cell, lowest, seconds=PRESS_DURATION_S, watch=lambda: _feel(cell))
        for _ in range(round(STROKE_M / STROKE_STEP_M)):
            excess = float(cell.contacts.pad_forces.sum()) - HOLD_DOWN_N
            give = np.clip(COMPLIANCE_M_N * excess, -MAX_GIVE_M, MAX_GIVE_M)
            step = STROKE_STEP_M * heading + [0.0, 0.0, give]
            move_tool(cell, cell.arm.tool(cell.reference).shifted(step), seconds=STROKE_STEP_S)
            if _rolled(cell, obj, heading):
                break
    finally:
        move_tool(cell, cell.arm.tool(cell.reference).shifted(up), seconds=RISE_DURATION_S)


def _rolled(cell: Workcell, obj: str, heading: np.ndarray) -> bool:
    """Return whether a round object lies and the fingertips are farther ahead of its crest than `MAX_ROLL_M`."""
    pose = cell.observe(obj)
    off = _lowest_point(cell, cell.arm.tool(cell.angles)) - pose.position
    axis = pose.rotation[:, 2]
    across = (off - (off @ axis) * axis)[:2]
    return _lies_round(pose) and np.hypot(*across) > MAX_ROLL_M and across @ heading[:2] > 0


def _feel(cell: Workcell) -> None:
    """Raise _FeltError if the force on a pad exceeds `PRESS_FORCE_N`."""
    if cell.contacts.pad_forces.max() > PRESS_FORCE_N:
        raise _FeltError


def _pressing(cell: Workcell, obj: str, pose: ObjectPose, shift: np.ndarray) -> tuple[ToolPose, ToolPose]:
    """Return a pre-grasp pose, and the tool's pose at which the closed fingertips are just above an object.

    From there, the hand moves down until a pad is pressed, by at most `fingertip_m`. Collisions are checked at the
    lowest pose, before and after the (3,) shift, m. If no pose is suitable, raise the last error.
    """
    refused = SimulationError(f"{obj} is out of reach")
    give = np.array([0.0, 0.0, cell.scene.robot.gripper.fingertip_m])
    for tilt, (offset, yaw) in itertools.product(TILTS_RAD, _presses(pose, shift)):
        if _tips(pose, offset, shift, _weight(cell, obj)):
            continue
        turned = ToolPose.down(pose.position + [*offset, pose.above], yaw).leaning(tilt, shift)
        goal = turned.shifted(turned.position - _lowest_point(cell, turned) - give)
        try:
            before, lowest = free_pose(cell, [goal], CLOSED, obj, near=cell.reference)
            free_pose(cell, [lowest.shifted(shift)], CLOSED, obj, near=cell.reference)
        except SimulationError as error:
            refused = error
            continue
        return before, lowest.shifted(give)
    raise refused


def _lowest_point(cell: Workcell, tool: ToolPose) -> np.ndarray:
    """Return the (3,) middle of the fingertips, m, or of their lowest edge if the hand is tilted."""
    side = tool.rotation[:, 0]
    edge = 0.0 if tool.points_down else -np.sign(side[2]) * TIP_HALF_M
    return tool.ahead(cell.scene.robot.gripper.fingertip_m) + edge * side


def _presses(pose: ObjectPose, shift: np.ndarray) -> Iterator[tuple[np.ndarray, float]]:
    """Yield where to press an object, (2,) m from its middle, and the heading of the closing direction, rad.

    Positions at the rear come first, where pressing tips the object least. A round object that lies is pressed on its
    crest or a little behind it, with the closing direction along its axis.
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


def _weight(cell: Workcell, obj: str) -> float:
    """Return the weight of an object, N."""
    return cell.scene.shapes[obj].mass * GRAVITY_M_S2


def _tips(pose: ObjectPose, offset: np.ndarray, shift: np.ndarray, weight: float) -> bool:
    """Return whether an object, of a weight in N, tips over rather than slides or rolls along a (3,) shift, m.

    It is pressed at an offset, (2,) m, from its middle. It tips where the centre of pressure, which friction moves
    forward, would leave its underside.
    """
    if _lies_round(pose):
        return False
    sides = pose.footprint
    lever = TIPPING_SHARE * SLIDING * (pose.above + pose.below) * shift[:2] / np.linalg.norm(shift)
    centre = sides.axes @ (HOLD_DOWN_N / (HOLD_DOWN_N + weight) * offset + lever)
    beyond = np.hypot(*centre) if pose.shape.is_round else np.abs(centre)
    return bool((beyond > sides.half).any())


def _lies_round(pose: ObjectPose) -> bool:
    """Return whether an object is round and does not stand upright: it may roll."""
    return pose.shape.is_round and not pose.is_upright


def _shifts(cell: Workcell, obj: str, pose: ObjectPose) -> Iterator[np.ndarray]:
    """Yield collision-free (3,) shifts of an object to try, m: short ones first, of each length the most central ones.

    The most central headings are nearest to the mean of all free ones. A round object that lies is rolled, or dragged
    along its axis.
    """
    headings = SIDEWAYS
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
        yield from (distance * heading for heading in most_central(free)[:MAX_DIRECTIONS])
