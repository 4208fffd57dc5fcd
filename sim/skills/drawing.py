"""Drawing free: an object beside which the fingers have no room is pressed from above and drawn away from the walls."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from sim.errors import SimulationError
from sim.geometry.mjcf import solid_geoms
from sim.geometry.rectangle import overlap
from sim.motion.trajectory import ToolPose
from sim.perception.grounding import footprint, half_height
from sim.perception.sensors import ObjectPose, Posture
from sim.robots.gripper import SuctionGripper
from sim.simulation.workcell import Workcell
from sim.skills.grasp_choice import choose_grasp
from sim.skills.hand import OPEN_DURATION_S, free_pose, move_tool
from sim.skills.skill import SkillError
from sim.world.grasps import GraspPose

DISTANCES_M = (0.03, 0.06)
"""How far to draw an object, to try in turn, m."""

STEP_M = 0.01
"""Distance between the places at which it must be free on the way, m."""

OVER_SUPPORT_M = 0.003
"""How much higher than it rests an object is checked for fixtures: it must not meet what carries it, m."""

STROKE_M, MAX_STROKES = 0.03, 8
"""How far the fingers move while they press an object, m, and how often."""

SHARE_DRAWN = 0.8
"""Share of the distance after which an object counts as drawn free."""

MAX_DIRECTIONS = 3
"""Number of directions to try for each distance: where none of them frees it, the others hardly do."""

DIRECTIONS_RAD = np.radians(np.arange(0, 360, 22.5))
"""Headings in which to draw it."""

PRESS_DURATION_S = 1.5
"""Least duration of the last part of the way down, which ends when the fingertips feel the object."""

PRESS_FORCE_N = 2.0
"""Force on a pad at which the way down ends."""

STROKE_STEP_M, STROKE_STEP_S = 0.003, 0.15
"""Length and least duration of the steps of a stroke; between them the hand gives way to the object or follows it."""

HOLD_DOWN_N, COMPLIANCE_M_N, MAX_GIVE_M = 5.5, 0.0001, 0.001
"""Force with which the object is pressed in a stroke, how far the hand rises for each N more, and at most in a step."""

OFF_CENTRE = 0.4
"""How far from the middle of an object's top it may be pressed, as a share of half a side."""

OFFSETS = np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [1, -1], [-1, 1], [-1, -1]])
"""(K, 2) directions from the middle, to try in turn."""

CLOSED = GraspPose(np.zeros(3), np.eye(3), width=0.004, clearance=0.0)
"""The hand as it presses: nearly closed, so that its pads do not press each other."""


@dataclass(frozen=True)
class Draw:
    """How an object is drawn free.

    Attributes:
        before: from where the closed hand comes down to it.
        over: where its fingertips are just above it.
        shift: (3,) by which it is drawn, m.
    """

    before: ToolPose
    over: ToolPose
    shift: np.ndarray


class _FeltError(SimulationError):
    """The fingertips press the object hard enough."""


def find_draw(cell: Workcell, obj: str, pose: ObjectPose) -> Draw | None:
    """Return how to draw an object to where it can be taken; None if that is not found.

    What lies on a round side is not drawn: it would roll.
    """
    rolls = cell.scene.shapes[obj].is_round and pose.posture != Posture.UPRIGHT
    if rolls or isinstance(cell.scene.robot.gripper, SuctionGripper):
        return None
    for shift in _shifts(cell, obj, pose):
        try:
            choose_grasp(cell, obj, replace(pose, position=pose.position + shift), pose.yaw)
        except SimulationError:
            continue
        pressing = _pressing(cell, obj, pose, shift)
        if pressing is not None:
            return Draw(*pressing, shift)
    return None


def draw_free(cell: Workcell, obj: str, draw: Draw) -> None:
    """Press an object from above with closed fingers and draw it aside, in several strokes, since it slips.

    Raises:
        SkillError: it did not come along.
        BlockedError: bodies are in the way.
    """
    start = cell.measure(obj).position
    cell.set_width(CLOSED.width, OPEN_DURATION_S)
    for _ in range(MAX_STROKES):
        came = (cell.measure(obj).position - start) * [1.0, 1.0, 0.0]
        left = draw.shift - came
        if came @ draw.shift >= SHARE_DRAWN * draw.shift @ draw.shift:
            cell.log_event("drawn free", object=obj, distance_mm=round(1000 * float(np.hypot(*came[:2])), 1))
            return
        _stroke(cell, draw, came, left / np.linalg.norm(left))
    raise SkillError(f"{obj} could not be drawn free: it slips under the fingers")


def _stroke(cell: Workcell, draw: Draw, came: np.ndarray, heading: np.ndarray) -> None:
    """Draw an object that came (3,) m so far once more, in a (3,) heading, and raise the hand."""
    over = draw.over.shifted(came)
    up = draw.before.position - draw.over.position
    move_tool(cell, [over.shifted(up)])
    move_tool(cell, [over])

    lowest = over.shifted([0.0, 0.0, -cell.scene.robot.gripper.fingertip_m])
    try:
        with suppress(_FeltError):
            move_tool(cell, [lowest], seconds=PRESS_DURATION_S, watch=lambda: _feel(cell, PRESS_FORCE_N))
        for _ in range(round(STROKE_M / STROKE_STEP_M)):
            give = COMPLIANCE_M_N * (float(cell.contacts.pad_forces.sum()) - HOLD_DOWN_N)
            step = STROKE_STEP_M * heading + [0.0, 0.0, np.clip(give, -MAX_GIVE_M, MAX_GIVE_M)]
            move_tool(cell, [cell.arm.tool(cell.reference).shifted(step)], seconds=STROKE_STEP_S)
    finally:
        move_tool(cell, [cell.arm.tool(cell.reference).shifted(up)])


def _feel(cell: Workcell, force: float) -> None:
    """Raise _FeltError if a pad is pressed with more than a force, N."""
    if cell.contacts.pad_forces.max() > force:
        raise _FeltError


def _pressing(cell: Workcell, obj: str, pose: ObjectPose, shift: np.ndarray) -> tuple[ToolPose, ToolPose] | None:
    """Return where the closed fingertips are just above an object, after from where they come; None if nowhere.

    Nothing may be in their way where they would be if it gave way by as much as they are above it then.
    """
    top = half_height(cell.scene, {obj: pose}, obj)
    sides = footprint(cell.scene, {obj: pose}, obj)
    offsets = (OFF_CENTRE * OFFSETS * sides.half) @ sides.axes
    # Drawn at its rear it tips the least.
    for offset in sorted(offsets, key=lambda offset: float(offset @ shift[:2])):
        pressed = pose.position + [*offset, top]
        for goal in (ToolPose.down(pressed, sides.yaw + turn) for turn in (0.0, np.pi / 2)):
            try:
                before, lowest = free_pose(cell, [goal], CLOSED, near=cell.reference)
                free_pose(cell, [lowest.shifted(shift)], CLOSED, near=cell.reference)
            except SimulationError:
                continue
            return before, lowest.shifted([0.0, 0.0, cell.scene.robot.gripper.fingertip_m])
    return None


def _shifts(cell: Workcell, obj: str, pose: ObjectPose) -> Iterator[np.ndarray]:
    """Yield (3,) shifts to try, m, by which an object meets nothing: short ones first, then the middle of the free."""
    headings = np.column_stack([np.cos(DIRECTIONS_RAD), np.sin(DIRECTIONS_RAD), np.zeros(len(DIRECTIONS_RAD))])
    meets = _obstacles(cell, obj, pose)
    for distance in DISTANCES_M:
        steps = np.arange(distance, 0, -STEP_M)
        free = [heading for heading in headings if not any(meets(step * heading) for step in steps)]
        middle = np.sum(free, axis=0) if free else np.zeros(3)
        yield from (
            distance * heading
            for heading in sorted(free, key=lambda heading: -float(heading @ middle))[:MAX_DIRECTIONS]
        )


def _obstacles(cell: Workcell, obj: str, pose: ObjectPose) -> Callable[[np.ndarray], bool]:
    """Return a function that tells whether an object meets another one or a fixture when it is shifted by (3,) m."""
    model, data = cell.scene.mujoco, mujoco.MjData(cell.scene.mujoco)
    data.qpos[:] = cell.data.qpos
    poses = {other: cell.observe(other) for other in cell.shapes if other != obj}
    taken = [footprint(cell.scene, poses, other) for other in poses]
    own = solid_geoms(model, obj)
    moving = (
        np.isin(model.geom_bodyid, [model.body(other).id for other in poses])
        | cell.scene.robot.bodies(model)[model.geom_bodyid]
    )

    def meets(shift: np.ndarray) -> bool:
        moved = replace(pose, position=pose.position + shift)
        if any(overlap(footprint(cell.scene, {obj: moved}, obj), other) for other in taken):
            return True
        data.joint(obj).qpos[:3] = moved.position + [0.0, 0.0, OVER_SUPPORT_M]
        mujoco.mju_mat2Quat(data.joint(obj).qpos[3:], pose.rotation.ravel())
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        pairs = data.contact.geom[: data.ncon]
        return bool((np.isin(pairs, own).any(axis=1) & ~moving[pairs].any(axis=1)).any())

    return meets
