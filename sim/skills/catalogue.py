"""The skills of the arm, by their kind."""

from __future__ import annotations

from prefplan.models.manipulation.action import Action
from sim.simulation.workcell import Workcell
from sim.skills.grasp import GraspSkill
from sim.skills.release import ReleaseSkill
from sim.skills.skill import Skill
from sim.skills.transit import TransitSkill
from sim.skills.transport import TransportSkill

SKILLS: dict[str, Skill] = {
    skill.kind: skill for skill in (TransitSkill(), GraspSkill(), TransportSkill(), ReleaseSkill())
}


def perform(cell: Workcell, action: Action | str) -> None:
    """Carry out one action of the standard skills, such as `transport blue san`, from rest to rest.

    It raises as `Skill.perform` does.
    """
    if isinstance(action, str):
        action = cell.scene.model.action(action)
    SKILLS[action.kind].perform(cell, action)
    cell.settle()
