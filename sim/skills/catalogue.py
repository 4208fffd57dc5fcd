"""The skills of the arm, by the kind of action."""

from collections.abc import Mapping, Sequence

from prefplan.models.manipulation.symbolic import Action
from sim.simulation.workcell import Workcell
from sim.skills.grasp import GraspSkill
from sim.skills.release import ReleaseSkill
from sim.skills.skill import Skill
from sim.skills.transit import TransitSkill
from sim.skills.transport import TransportSkill

SKILLS: dict[str, Skill] = {
    skill.kind: skill for skill in (TransitSkill(), GraspSkill(), TransportSkill(), ReleaseSkill())
}


def perform(
    cell: Workcell, action: Action | str, skills: Mapping[str, Skill] = SKILLS, *, ahead: Sequence[Action | str] = ()
) -> None:
    """Carry out one action, as a value or as text such as `transport blue san`; return when the arm is at rest.

    `skills` are by kind of action; `ahead` are the actions planned after this one. Raises what `Skill.perform` raises.
    """
    first, *rest = (cell.scene.model.action(each) if isinstance(each, str) else each for each in (action, *ahead))
    skills[first.kind].perform(cell, first, rest)
    cell.settle()
