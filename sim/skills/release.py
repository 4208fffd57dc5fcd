"""Release: put the held object down."""

from __future__ import annotations

import numpy as np

from prefplan.models.manipulation.action import Action
from prefplan.models.manipulation.operators import Release
from sim.simulation.workcell import Workcell
from sim.skills.hand import BLEND_M, HOVER_HEIGHT_M, OPEN_DURATION_S, check_held, held_grip, move_tool
from sim.skills.placing import check_free, free_slot, placing_pose
from sim.skills.skill import Skill
from sim.world.places import Slot

GLOW_DURATION_S = 1.5
"""How long a marking location works on an object released there; meanwhile the hand rises."""

LOWER_DURATION_S = 0.7
"""Least duration of lowering an object: the heaviest makes the arm overshoot by less than it is dropped by."""

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
        check_held(cell, obj)
        slot = free_slot(cell, obj, location)
        cell.contacts.handle(obj, aloft=True)
        position, yaw = placing_pose(cell, obj, slot)
        above = position + [0.0, 0.0, HOVER_HEIGHT_M]
        move_tool(cell, above, [yaw], within=BLEND_M)
        check_free(cell, obj, slot)
        position, yaw = placing_pose(cell, obj, slot)
        check_held(cell, obj)
        cell.contacts.handle(obj)
        move_tool(cell, position, [yaw], seconds=LOWER_DURATION_S, watch=lambda: _check(cell, obj, slot))
        cell.set_width(held_grip(cell, obj).opening, OPEN_DURATION_S)
        cell.wait(LET_GO_DURATION_S)
        marks = cell.scene.model.location(location).marks
        if marks:
            cell.glow(location, GLOW_DURATION_S)
        move_tool(cell, above, [yaw], within=BLEND_M, seconds=GLOW_DURATION_S if marks else 0.0)
        cell.contacts.handle(None)
        error = float(np.hypot(*(cell.measure(obj).position - slot.position)[:2]))
        cell.log_event("placed", object=obj, location=location, error_mm=round(error * 1000, 2))


def _check(cell: Workcell, obj: str, slot: Slot) -> None:
    """Raise SkillError unless the hand still holds an object, and it fits into a slot."""
    check_held(cell, obj)
    check_free(cell, obj, slot)
