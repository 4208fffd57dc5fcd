"""Transport: carry the held object over a location."""

from __future__ import annotations

from prefplan.models.manipulation.action import Action
from prefplan.models.manipulation.operators import Transport
from sim.simulation.workcell import Workcell
from sim.skills.hand import HOVER_HEIGHT_M, check_held, free_closing_line, passage_height
from sim.skills.placing import closing_lines, free_slot, resting_centre
from sim.skills.skill import Skill
from sim.skills.transfer import travel


class TransportSkill(Transport, Skill):
    """Carry the held object over the location's free slot."""

    def perform(self, cell: Workcell, action: Action) -> None:
        """See `Skill.perform`."""
        obj = action.obj
        check_held(cell, obj)
        slot = free_slot(cell, obj, action.location)
        centre = resting_centre(cell, obj, slot)
        cell.contacts.handle(obj)
        line, _ = free_closing_line(cell, centre, closing_lines(cell, obj, slot))
        cell.contacts.handle(obj, aloft=True)
        check_held(cell, obj)  # again: nothing may have been seen until now
        travel(cell, centre + [0.0, 0.0, HOVER_HEIGHT_M], line, height=passage_height(cell, cell.shapes, held=obj))
        check_held(cell, obj)
