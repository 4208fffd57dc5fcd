"""Release: put the held object down."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from prefplan.models.manipulation.action import Action
from prefplan.models.manipulation.operators import Release
from sim.errors import SimulationError
from sim.motion.trajectory import ToolPose
from sim.perception.sensors import Posture
from sim.simulation.workcell import Workcell
from sim.skills.grasp_choice import choose_placement_of_held
from sim.skills.hand import BLEND_M, OPEN_DURATION_S, check_held, frame_of, free_pose, held_grasp, move_tool, pregrasps
from sim.skills.placing import check_free, free_slot, resting_centre
from sim.skills.skill import Skill
from sim.world.grasps import openings
from sim.world.places import Slot

GLOW_DURATION_S = 1.5
"""How long a marking location works on an object released there; meanwhile the hand rises."""

LOWER_DURATION_S = 0.7
"""Least duration of lowering an object: the heaviest makes the arm overshoot by less than it is dropped by."""

GENTLE_DURATION_S = 1.4
"""The same for what is heavier than any object without a given mass, and for meshes, which are held off their middle.

They come lower than they are dropped from, having crept down in the hand: after 0.7 s the torque rates of the arm
reached 102 % of their limit with a mug of 0.13 kg."""

DROP_HEIGHT_M = 0.001
"""Height from which an object is released, so that the hand does not press it onto the surface below."""

TILTED_DURATIONS_S = 0.8, 0.8
"""The duration of opening a tilted hand and the time to raising it: an object that touches down presses it aside; let
go in 0.25 s the torque rates of the arm reached 118 % of their limit."""

LET_GO_DURATION_S = 0.15
"""Time from the beginning of opening the hand to that of raising it: by then the pads have left the object."""


class ReleaseSkill(Release, Skill):
    """Measure the object in the hand, lower it into the free slot, let go and raise the hand.

    Above the slot the object's pose in the tool frame is measured and corrected for, since it drifts while it is
    carried; and the slot is checked once more to be free.
    """

    def perform(self, cell: Workcell, action: Action) -> None:
        """See `Skill.perform`."""
        obj, location = action.obj, action.location
        slot = free_slot(cell, obj, location)
        check_held(cell, obj)  # last: until then nothing may have been observed
        cell.contacts.handle(obj, aloft=True)
        pose, _ = _placing_pose(cell, obj, slot)
        before = _preplace(cell, pose)
        move_tool(cell, [before], within=BLEND_M)
        check_free(cell, obj, slot)
        pose, width = _placing_pose(cell, obj, slot)
        check_held(cell, obj)
        cell.contacts.handle(obj)
        width = width or _free_opening(cell, obj, pose)
        move_tool(cell, [pose], seconds=lower_duration(cell, obj), watch=lambda: _check(cell, obj, slot))
        cell.unload()
        opening, rising = (OPEN_DURATION_S, LET_GO_DURATION_S) if pose.points_down else TILTED_DURATIONS_S
        cell.set_width(width, opening)
        cell.wait(rising)
        marks = cell.scene.model.location(location).marks
        if marks:
            cell.glow(location, GLOW_DURATION_S)
        move_tool(cell, [before], within=BLEND_M, seconds=GLOW_DURATION_S if marks else 0.0)
        cell.contacts.handle(None)
        error = float(np.hypot(*(cell.measure(obj).position - slot.position)[:2]))
        cell.log_event("placed", object=obj, location=location, error_mm=round(error * 1000, 2))


def lower_duration(cell: Workcell, obj: str) -> float:
    """Return the least duration of lowering an object, s."""
    shape = cell.scene.shapes[obj]
    gentle = shape.pairs or shape.seats or shape.is_heavy
    return GENTLE_DURATION_S if gentle else LOWER_DURATION_S


def _placing_pose(cell: Workcell, obj: str, slot: Slot) -> tuple[ToolPose, float | None]:
    """Return the tool's pose that sets the held object, as it lies in the hand, upright into a slot, and a width, m.

    To that width the hand can open there; None if that is not known. A tilted object would touch down with an edge and
    tip, so that its lowest point sets the height. The arm may be moving, unless the sensor needs several observations.
    """
    if cell.sensor.samples > 1:
        cell.settle()
    held, tool, shape = cell.measure(obj), cell.arm.tool(cell.angles), cell.scene.shapes[obj]
    if held.posture == Posture.UPRIGHT and not (shape.pairs or shape.seats):
        frame = frame_of(held, slot.yaw)
        turn, width = shape.standing_near(frame, slot.yaw) @ frame.T, None
    else:
        # It may lean, or a mesh be held off its middle, so that there is less space for the hand.
        _, placing, width = choose_placement_of_held(cell, obj, slot)
        turn = placing.rotation @ tool.rotation.T
    lowest = shape.depth(turn @ held.rotation) - shape.half[2] + DROP_HEIGHT_M
    position = resting_centre(cell, obj, slot) + [0.0, 0.0, lowest] - turn @ (held.position - tool.position)
    return ToolPose(position, turn @ tool.rotation), width


def _free_opening(cell: Workcell, obj: str, pose: ToolPose) -> float:
    """Return how wide the hand can open where it lets go of an object, m: less than usual beside others."""
    options = openings(held_grasp(cell, obj))
    for option in options:
        with suppress(SimulationError):
            free_pose(cell, [pose], option, near=cell.reference)
            return option.opening
    return options[-1].opening


def _preplace(cell: Workcell, pose: ToolPose) -> ToolPose:
    """Return, of the poses from which the hand comes straight to a pose, the one where it has come by transport."""
    now = cell.arm.tool(cell.angles).position
    return min(pregrasps(pose), key=lambda option: float(np.linalg.norm(option.position - now)))


def _check(cell: Workcell, obj: str, slot: Slot) -> None:
    """Raise SkillError unless the hand still holds an object, and it fits into a slot."""
    check_held(cell, obj)
    check_free(cell, obj, slot)
