"""Transport: carry the held object over a location."""

from collections.abc import Sequence

from prefplan.models.manipulation.operators import Transport
from prefplan.models.manipulation.symbolic import Action
from sim.simulation.workcell import Workcell
from sim.skills.grasp_choice import choose_placement_of_held
from sim.skills.hand import check_held, transfer_height
from sim.skills.placing import free_slot
from sim.skills.skill import Skill
from sim.skills.transfer import travel


class TransportSkill(Transport, Skill):
    """Carry the held object over the location's free slot."""

    def perform(self, cell: Workcell, action: Action, ahead: Sequence[Action] = ()) -> None:
        """See `Skill.perform`."""
        obj = action.obj
        slot = free_slot(cell, obj, action.location)
        check_held(cell, obj)  # after free_slot: during its wait for observations, the object may slip
        _, before, pose = choose_placement_of_held(cell, obj, slot)
        cell.attach(obj)
        height = transfer_height(cell, cell.shapes, held=obj)
        travel(cell, [before], height=height, onward=pose)
        check_held(cell, obj)
