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
from sim.skills.transfer import leave
from sim.world.grasps import openings
from sim.world.places import Slot

GLOW_DURATION_S = 1.5
"""How long the lamp of a location that marks objects glows after a release; the hand rises as slowly as that."""

LOWER_DURATION_S = 0.7
"""Least duration of lowering an object: even with the heaviest, the arm overshoots by less than `DROP_HEIGHT_M`."""

GENTLE_DURATION_S = 1.4
"""The same for objects heavier than any of default mass, and for meshes, which are held away from their middle.

They creep down in the hand by more than the drop height and touch down before they are released: when lowered in 0.7 s,
a mug of 0.13 kg made the torque rates of the arm reach 102 % of their limit."""

DROP_HEIGHT_M = 0.001
"""Height from which an object is released, so that the hand does not press it onto the surface below."""

TILTED_DURATIONS_S = 0.8, 0.8
"""Duration of opening a tilted hand, and time from its beginning until the hand is raised: an object that touches down
presses the hand aside, and when it was let go in 0.25 s, torque rates of the arm reached 118 % of their limit."""

LET_GO_DURATION_S = 0.15
"""Time from when the hand begins to open until it is raised: by then the pads have left the object."""


class ReleaseSkill(Release, Skill):
    """Measure the object in the hand, lower it into the free slot, let go and raise the hand.

    The object drifts in the hand while it is carried, so its pose in the tool frame is measured above the slot and
    corrected for. There the slot is checked again, too.
    """

    def perform(self, cell: Workcell, action: Action) -> None:
        """See `Skill.perform`."""
        obj, location = action.obj, action.location
        slot = free_slot(cell, obj, location)
        check_held(cell, obj)  # after free_slot: while that waits for observations, it may slip
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
        leave(cell, before, seconds=GLOW_DURATION_S if marks else 0.0)
        cell.contacts.handle(None)
        error = float(np.hypot(*(cell.measure(obj).position - slot.position)[:2]))
        cell.log_event("placed", object=obj, location=location, error_mm=round(error * 1000, 2))


def lower_duration(cell: Workcell, obj: str) -> float:
    """Return the least duration of lowering an object, s: longer for heavy objects and meshes."""
    shape = cell.scene.shapes[obj]
    gentle = shape.pairs or shape.seats or shape.is_heavy
    return GENTLE_DURATION_S if gentle else LOWER_DURATION_S


def _placing_pose(cell: Workcell, obj: str, slot: Slot) -> tuple[ToolPose, float | None]:
    """Return the tool's pose that sets the held object, as it is in the hand, upright into a slot, and a width, m.

    The hand can open to this width there; it is None if it has not been determined. The object's lowest point sets the
    height, since a tilted one touches down with an edge. The arm may be moving if the sensor needs one observation;
    otherwise this waits until it rests.
    """
    if cell.sensor.samples > 1:
        cell.settle()
    held, tool, shape = cell.measure(obj), cell.arm.tool(cell.angles), cell.scene.shapes[obj]
    if held.posture == Posture.UPRIGHT and not (shape.pairs or shape.seats):
        frame = frame_of(held, slot.yaw)
        turn, width = shape.standing_near(frame, slot.yaw) @ frame.T, None
    else:
        # A leaning object, or a mesh held away from its middle, leaves less space for the hand.
        _, placing, width = choose_placement_of_held(cell, obj, slot)
        turn = placing.rotation @ tool.rotation.T
    lowest = shape.depth(turn @ held.rotation) - shape.half[2] + DROP_HEIGHT_M
    position = resting_centre(cell, obj, slot) + [0.0, 0.0, lowest] - turn @ (held.position - tool.position)
    return ToolPose(position, turn @ tool.rotation), width


def _free_opening(cell: Workcell, obj: str, pose: ToolPose) -> float:
    """Return how wide the hand can open where it lets go of an object, m; the least opening if none is free."""
    options = openings(held_grasp(cell, obj))
    for option in options:
        with suppress(SimulationError):
            free_pose(cell, [pose], option, near=cell.reference)
            return option.opening
    return options[-1].opening


def _preplace(cell: Workcell, pose: ToolPose) -> ToolPose:
    """Return the pre-grasp pose of a placement that is nearest to the hand, where transport has brought it."""
    now = cell.arm.tool(cell.angles).position
    return min(pregrasps(pose), key=lambda option: float(np.linalg.norm(option.position - now)))


def _check(cell: Workcell, obj: str, slot: Slot) -> None:
    """Raise SkillError unless the hand still holds an object and the object fits into a slot."""
    check_held(cell, obj)
    check_free(cell, obj, slot)
