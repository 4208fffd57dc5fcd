"""Scenario files whose preferences or relaxations cannot be used: the message names the file and the key."""

from __future__ import annotations

import re
from typing import Any

import pytest

from prefplan import ScenarioError
from prefplan.scenario.decode import from_dict


def scenario(preference: dict[str, Any], **task: Any) -> dict[str, Any]:
    """Return a file's content with two tasks, the first as given."""
    model = {
        "kind": "graph",
        "start": "s",
        "transitions": [{"from": "s", "to": "t", "cost": 1}],
        "labels": {"t": ["clean"]},
        "propositions": ["warm"],
    }
    tasks = [{"name": "wash", "formula": "F clean"} | task, {"name": "cook", "formula": "F clean"}]
    return {"model": model, "tasks": tasks, "preference": preference}


WEIGHED = {"kind": "weighted-sum", "weights": {"wash": 1, "cook": 1}, "over": "violation"}


def relax(assume: str, when: str, cost: Any) -> dict[str, Any]:
    return {"relax": [{"assume": assume, "when": when, "cost": cost}]}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (scenario({}), "preference.kind: missing (valid: order, weighted-sum, "),
        (scenario({"kind": "weighted-sum"}), "preference.weights: missing"),
        (scenario({"kind": "max", "weights": {"wash": "1"}}), "preference.weights.wash: must be a number, not '1'"),
        (scenario({"kind": "order", "over": "violation"}), "preference.over: unknown key"),
        (scenario({"kind": "deadline"}), "preference.deadlines: missing"),
        (scenario({"kind": "deadline", "deadlines": {"wash": {}}}), "preference.deadlines.wash.by: missing"),
        (scenario({"kind": "expression"}), "preference.expression: missing"),
        (
            scenario({"kind": "expression", "expression": "wash * cook", "contract": "convex"}),
            "preference.contract: not convex: mu grows from ",
        ),
        (scenario({"kind": "sum", "terms": [{"kind": "sum"}]}), "preference.terms[0].kind: unknown kind 'sum'"),
        (
            scenario({"kind": "sum", "terms": [{"kind": "order"}, {"kind": "max", "weights": {"x": 1}}]}),
            "preference.terms[1].weights: unknown task 'x' (valid: wash, cook)",
        ),
        (scenario(WEIGHED, **relax("wet", "clean", 1)), "tasks[0].relax[0].assume: unknown proposition 'wet'"),
        (scenario(WEIGHED, **relax("warm", "clean", "1")), "tasks[0].relax[0].cost: must be a number, not '1'"),
    ],
)
def test_a_scenario_file_is_refused_by_file_and_key(data: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match="^" + re.escape(f"kitchen: {message}")):
        from_dict(data, name="kitchen").problem()
