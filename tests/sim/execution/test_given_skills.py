"""Skills that are passed in are those that are used: in executions, checks before a run and measurements of costs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from prefplan.models.manipulation.operators import Outcomes
from prefplan.models.manipulation.symbolic import Action, ManipulationState
from sim.capability.feasibility import Feasibility
from sim.capability.place_check import PlaceCheck
from sim.execution.cost_measurement import Trial, simulate
from sim.execution.executor import Execution
from sim.simulation.workcell import Workcell
from sim.skills.catalogue import SKILLS
from sim.skills.skill import Skill
from sim.world.scene import build_scene, initial_state


class Counted(Skill):
    """A skill that counts its calls."""

    def __init__(self, skill: Skill, calls: Counter[str]) -> None:
        self.kind, self.travels, self._skill, self._calls = skill.kind, skill.travels, skill, calls

    def outcomes(self, model: ManipulationModel, state: ManipulationState) -> Outcomes:
        return self._skill.outcomes(model, state)

    def effect(self, action: Action) -> frozenset[str]:
        return self._skill.effect(action)

    def perform(self, cell: Workcell, action: Action, ahead: Sequence[Action] = ()) -> None:
        self._calls[action.kind] += 1
        self._skill.perform(cell, action, ahead)


def counted() -> tuple[dict[str, Skill], Counter[str]]:
    calls = Counter[str]()
    return {kind: Counted(skill, calls) for kind, skill in SKILLS.items()}, calls


def model() -> ManipulationModel:
    costs = dict.fromkeys(SKILLS, 1)
    return ManipulationModel(
        "here", costs, (Location("here", at=(0.45, 0.0)), Location("there", at=(0.45, 0.2))), (Object("cup", "here"),)
    )


def test_an_execution_moves_to_its_start_by_the_skill_given() -> None:
    scene, (skills, calls) = build_scene(model()), counted()
    run = Execution(scene, initial_state(scene), skills=skills)
    assert calls == {"transit": 1}
    assert run.step("grasp cup")
    assert calls == {"transit": 1, "grasp": 1}


def test_a_check_tries_the_skills_given() -> None:
    scene, (skills, calls) = build_scene(model()), counted()
    arm = Feasibility(scene, skills)
    assert arm.check_start() is None
    assert calls == {"transit": 1}
    assert arm.check("cup", "there") == PlaceCheck("cup", "there")
    assert calls == {"transit": 2, "grasp": 2, "transport": 1, "release": 1}


def test_a_cost_is_measured_by_the_skills_given() -> None:
    scene, (skills, calls) = build_scene(model()), counted()
    simulate(scene, Trial(scene.model.initial_state, "grasp cup"), skills)
    assert calls == {"transit": 1, "grasp": 1}
