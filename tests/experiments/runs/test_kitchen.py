from __future__ import annotations

import tomllib
from decimal import Decimal
from typing import Any

import pytest
from scenario_texts import shipped, shipped_front

from experiments.runs.carry_out import scene_of
from prefplan.errors import ScenarioError
from prefplan.scenario.decode import from_dict


def test_serving_in_the_customers_order_costs_more_the_better_it_is_kept() -> None:
    front = shipped_front("kitchen")
    points = [(plan.cost, plan.preference) for plan in front]
    assert points == [(58, 65), (61, 51), (64, 44), (65, 34), (68, 17), (78, 14), (81, 0)]
    assert front[0].task_costs == {"tidy": 10, "cleo": 24, "ben": 41, "ada": 58}
    assert front[-1].task_costs == {"ada": 34, "ben": 54, "cleo": 71, "tidy": 81}


@pytest.mark.parametrize(
    ("table", "key", "value", "message"),
    [
        ("objects.mug", "kind", "cup", r"unknown kind 'cup'"),
        ("objects.mug", "size", [Decimal("0.08"), Decimal("0.05")], r"0\.08 m wide, but the hand"),
        ("objects.fish", "size", "large", "must be a number, not 'large'"),
        ("objects.fish", "sise", 1, r"unknown key \(did you mean 'size'\?\)"),
        ("locations.stove", "kind", "stive", r"unknown kind 'stive' \(did you mean 'stove'"),
    ],
)
def test_what_an_object_or_a_location_cannot_be_is_refused_by_file_and_key(
    table: str, key: str, value: Any, message: str
) -> None:
    path = shipped("kitchen").path
    contents = tomllib.loads(path.read_text(), parse_float=Decimal)
    group, name = table.split(".")
    contents["model"][group][name][key] = value
    with pytest.raises(ScenarioError, match=rf"kitchen\.toml: model\.{table}\.{key}: {message}"):
        scene_of(from_dict(contents, name="kitchen", path=path))
