from __future__ import annotations

import tomllib
from decimal import Decimal
from typing import Any

import pytest

from experiments import scenarios
from experiments.runs.carry_out import carry_out, scene_of
from prefplan import Front, Scenario, pareto_front
from prefplan.errors import ScenarioError
from prefplan.scenario.decode import from_dict


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return scenarios.find("kitchen")


@pytest.fixture(scope="module")
def front(scenario: Scenario) -> Front:
    return pareto_front(scenario.problem())


@pytest.fixture
def contents(scenario: Scenario) -> dict[str, Any]:
    return tomllib.loads(scenario.path.read_text(), parse_float=Decimal)


def test_serving_in_the_customers_order_costs_more_the_better_it_is_kept(front: Front) -> None:
    points = [(plan.cost, plan.preference) for plan in front]
    assert points == [(58, 65), (61, 51), (64, 44), (65, 34), (68, 17), (78, 14), (81, 0)]


def test_the_preferred_plan_serves_ada_ben_and_cleo_in_turn_and_tidies_up_last(front: Front) -> None:
    costs = front[-1].task_costs
    assert costs == {"ada": 34, "ben": 54, "cleo": 71, "tidy": 81}
    assert front[0].task_costs == {"tidy": 10, "cleo": 24, "ben": 41, "ada": 58}


def test_the_preferred_plan_is_carried_out_to_the_end(scenario: Scenario, front: Front) -> None:
    outcome = carry_out(scenario, scene_of(scenario), front[-1], seed=1)
    rollout = outcome.rollout
    assert rollout.completed, rollout.reason
    assert [step.action for step in rollout.steps] == list(front[-1].actions)
    final = rollout.steps[-1].observed
    assert final.place == {"soup": "plate1", "pie": "plate2", "fish": "plate3", "mug": "counter"}
    assert final.marks >= {("soup", "cooked"), ("pie", "cooked"), ("fish", "cooked")}
    assert rollout.placement_error < 0.002
    assert [event for event in rollout.events if event.kind == "contact"] == []


@pytest.mark.parametrize(
    ("obj", "key", "value", "message"),
    [
        ("mug", "kind", "cup", r"kitchen\.toml: model\.objects\.mug\.kind: unknown kind 'cup'"),
        (
            "mug",
            "size",
            Decimal("0.05"),
            r"kitchen\.toml: model\.objects\.mug\.size: a cylinder has diameter, height",
        ),
        (
            "mug",
            "size",
            [Decimal("0.08"), Decimal("0.05")],
            r"model\.objects\.mug\.size: 0\.08 m wide, but the hand",
        ),
        ("fish", "size", "large", r"kitchen\.toml: model\.objects\.fish\.size: must be a number, not 'large'"),
        ("fish", "size", [1, "x", 1], r"kitchen\.toml: model\.objects\.fish\.size\[1\]: must be a number, not 'x'"),
        ("fish", "sise", 1, r"kitchen\.toml: model\.objects\.fish\.sise: unknown key \(did you mean 'size'\?\)"),
    ],
)
def test_what_an_object_cannot_be_is_refused_by_file_and_key(
    scenario: Scenario, contents: dict[str, Any], obj: str, key: str, value: Any, message: str
) -> None:
    contents["model"]["objects"][obj][key] = value
    with pytest.raises(ScenarioError, match=message):
        scene_of(from_dict(contents, name="kitchen", path=scenario.path))


def test_a_location_of_an_unknown_kind_is_refused_by_file_and_key(scenario: Scenario, contents: dict[str, Any]) -> None:
    contents["model"]["locations"]["stove"]["kind"] = "stive"
    with pytest.raises(
        ScenarioError, match=r"model\.locations\.stove\.kind: unknown kind 'stive' \(did you mean 'stove'"
    ):
        scene_of(from_dict(contents, name="kitchen", path=scenario.path))
