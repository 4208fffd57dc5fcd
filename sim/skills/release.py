"""Release: put the held object down."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial

import numpy as np

from prefplan.models.manipulation.operators import Release
from prefplan.models.manipulation.symbolic import Action
from sim.errors import BlockedError, SimulationError
from sim.motion.trajectory import ToolPose
from sim.simulation.workcell import Workcell
from sim.skills.grasp_choice import choose_placement_of_held
from sim.skills.hand import (
    BLEND_M,
    LIFT_DURATION_S,
    LIFT_M,
    OPEN_DURATION_S,
    check_held,
    free_pose,
    held_grasp,
    move_tool,
    pregrasps,
    straight_move,
)
from sim.skills.placing import check_free, free_slot, resting_centre
from sim.skills.skill import Skill
from sim.skills.transfer import leave, travel
from sim.world.grasps import openings
from sim.world.places import Slot
from sim.world.shapes import about_z

GLOW_DURATION_S = 1.5
"""How long a location that marks objects glows after a release, s; the hand takes at least as long to rise."""

LOWER_DURATION_S = 0.7
"""Least duration of lowering an object, s: near the base, it overshoots by less than `DROP_HEIGHT_M`."""

DROP_HEIGHT_M = 0.001
"""Height from which an object is released, so that the hand does not press it onto the surface below."""

TILTED_DURATIONS_S = 0.8, 0.8
"""Duration of opening a tilted hand, and time from the start of opening until the hand is raised, s: an object that
touches down presses the hand aside, and the hand must not spring back."""

LET_GO_DURATION_S = 0.15
"""Time from when the hand begins to open until it is raised: by then the pads have left the object."""


class ReleaseSkill(Release, Skill):
    """Measure the object in the hand, lower it into the free slot, let go and raise the hand.

    The object drifts in the hand while it is carried, so its pose in the tool frame is measured above the slot and
    corrected for. There the slot is checked again, too.
    """

    def perform(self, cell: Workcell, action: Action, ahead: Sequence[Action] = ()) -> None:
        """See `Skill.perform`."""
        obj, location = action.obj, action.location
        slot = free_slot(cell, obj, location)
        check_held(cell, obj)  # after free_slot: during its wait for observations, the object may slip
        cell.attach(obj)
        pose, _ = _placing_pose(cell, obj, slot)
        before = _preplace(cell, pose)
        move_tool(cell, before, within=BLEND_M)
        check_free(cell, obj, slot)
        pose, width = _placing_pose(cell, obj, slot)
        check_held(cell, obj)
        cell.detach()
        width, watch = width or _free_opening(cell, obj, pose), partial(_check, cell, obj, slot)
        try:
            lower(cell, obj, pose, watch=watch)
        except BlockedError as blocked:
            if blocked.at_goal:  # something has come there meanwhile
                raise
            pose, before, width = _go_to_another(cell, obj, slot)
            lower(cell, obj, pose, watch=watch)
        cell.unload()
        opening, rising = (OPEN_DURATION_S, LET_GO_DURATION_S) if pose.points_down else TILTED_DURATIONS_S
        cell.set_width(width, opening)
        cell.wait(rising)
        marks = cell.scene.model.location(location).marks
        if marks:
            cell.glow(location, GLOW_DURATION_S)
        leave(cell, before, seconds=GLOW_DURATION_S if marks else 0.0)
        cell.touch(None)
        error = float(np.hypot(*(cell.measure(obj).position - slot.position)[:2]))
        cell.log_event("placed", object=obj, location=location, error_mm=round(error * 1000, 2))


def lower(cell: Workcell, obj: str, pose: ToolPose, *, watch: Callable[[], None]) -> None:
    """Lower an object to the tool's pose in which it is released; if it touches down before, it does so gently.

    This happens if its pose in the hand is not known exactly: a heavy object, or a mesh held away from its middle,
    creeps down in the hand, and sensors are noisy. Its last millimetres then take as long as the first ones of lifting
    a heavy object. For `watch`, see `move_tool`.
    """
    shape, above = cell.scene.shapes[obj], cell.arm.tool(cell.reference).position - pose.position
    if shape.pairs or shape.seats or shape.is_heavy or cell.sensor.error:
        near = pose.shifted(above * LIFT_M / max(above[2], LIFT_M))
        move_tool(cell, near, seconds=LOWER_DURATION_S, watch=watch)
        move_tool(cell, pose, seconds=LIFT_DURATION_S, watch=watch)
    else:
        move_tool(cell, pose, seconds=_lower_duration(cell, obj, pose), watch=watch)


def _lower_duration(cell: Workcell, obj: str, pose: ToolPose) -> float:
    """Return the least duration of lowering an object without touching down too early, s.

    As the arm brakes, it lags behind its references, by more the farther it is stretched out. Its accelerations
    decrease with the square of the duration.
    """
    references = straight_move(cell, pose, seconds=LOWER_DURATION_S).references
    lag = cell.arm.lag(cell.reference, references, load=cell.scene.shapes[obj].mass)
    lowest = min(float(cell.arm.tool(q).position[2]) for q in references - lag)
    return LOWER_DURATION_S * np.sqrt(max(1.0, (pose.position[2] - lowest) / DROP_HEIGHT_M))


def _go_to_another(cell: Workcell, obj: str, slot: Slot) -> tuple[ToolPose, ToolPose, float]:
    """Move to the pre-grasp pose of another placement; return the placement, this pose, and the width to open to, m.

    The placement is chosen for the object's current pose in the hand: beside a wall, a millimetre decides.

    Raises:
        BlockedError: no placement is free of collisions.
        SimulationError: the arm reaches no placement.
    """
    cell.attach(obj)
    pose, width = _placing_pose(cell, obj, slot, chosen=True)
    before = _preplace(cell, pose)
    travel(cell, [before], height=float(before.position[2]), onward=pose)
    cell.settle()
    cell.detach()
    assert width is not None
    return pose, before, width


def _placing_pose(cell: Workcell, obj: str, slot: Slot, *, chosen: bool = False) -> tuple[ToolPose, float | None]:
    """Return the tool's pose that sets the held object, as it is in the hand, upright into a slot, and a width, m.

    The hand can open to this width there; None if it has not been determined. The object's lowest point sets the
    height. If the sensor needs several observations or the hand is tilted, wait until the arm is at rest.
    """
    if cell.sensor.samples > 1 or not cell.arm.tool(cell.reference).points_down:
        cell.settle()
    held, tool, shape = cell.measure(obj), cell.arm.tool(cell.angles), cell.scene.shapes[obj]
    if held.is_upright and not (shape.pairs or shape.seats or chosen):
        turn, width = about_z(slot.yaw - shape.yaw_near(held.yaw, slot.yaw)), None
    else:
        # A leaning object, or a mesh held away from its middle, leaves less space for the hand.
        grasp, _, placing = choose_placement_of_held(cell, obj, slot)
        width = grasp.opening
        turn = placing.rotation @ tool.rotation.T
    lowest = shape.depth(turn @ held.rotation) - shape.half[2] + DROP_HEIGHT_M
    position = resting_centre(cell, obj, slot) + [0.0, 0.0, lowest] - turn @ (held.position - tool.position)
    return ToolPose(position, turn @ tool.rotation), width


def _free_opening(cell: Workcell, obj: str, pose: ToolPose) -> float:
    """Return how wide the hand can open where it lets go of an object, m; the least opening if none is free."""
    options = openings(held_grasp(cell, obj))
    for option in options:
        with suppress(SimulationError):
            free_pose(cell, [pose], option, obj, near=cell.reference)
            return option.opening
    return options[-1].opening


def _preplace(cell: Workcell, pose: ToolPose) -> ToolPose:
    """Return the pre-grasp pose of a placement to which transport has brought the hand: the nearest one."""
    now = cell.arm.tool(cell.angles).position
    return min(pregrasps(pose), key=lambda option: float(np.linalg.norm(option.position - now)))


def _check(cell: Workcell, obj: str, slot: Slot) -> None:
    """Raise SkillError unless the hand still holds an object and the object fits into a slot."""
    check_held(cell, obj)
    check_free(cell, obj, slot)
