"""Transit: bring the empty hand over a location."""

from __future__ import annotations

import numpy as np

from prefplan.models.manipulation.action import Action
from prefplan.models.manipulation.operators import Transit
from sim.simulation.workcell import Workcell
from sim.skills.hand import HOVER_HEIGHT_M, passage_height
from sim.skills.skill import Skill
from sim.skills.transfer import travel
from sim.world.shapes import extent

NEAR_M = 0.2
"""Distance within which the hand over a location passes over other objects, too: more than its own width."""


class TransitSkill(Transit, Skill):
    """Bring the empty hand over a location and whatever is piled up there."""

    def perform(self, cell: Workcell, action: Action) -> None:
        """See `Skill.perform`."""
        cell.contacts.handle(None)
        slots = cell.scene.slots[action.location]
        centre = np.mean([slot.position for slot in slots], axis=0)
        middle = extent(cell.scene.shapes.values()).high / 2
        reach = NEAR_M + float(np.hypot(*(slots[-1].position - centre)[:2]))
        piled = [obj for obj in cell.shapes if np.hypot(*(cell.observe(obj).position - centre)[:2]) < reach]
        height = max(centre[2] + middle + HOVER_HEIGHT_M, passage_height(cell, piled))
        travel(cell, np.array([*centre[:2], height]), slots[0].yaw, height=passage_height(cell, cell.shapes))
