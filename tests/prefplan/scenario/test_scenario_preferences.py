"""Scenario files whose preferences or relaxations cannot be used: the message names the file and the key."""

from __future__ import annotations

import re
from typing import Any

import pytest

from prefplan import ScenarioError
from prefplan.preferences.objective import TASK_LIMIT
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
        (scenario({"kind": "weighted-sum", "weights": {"wash": 1}}), "preference.weights: every task needs one; "),
        (scenario({"kind": "max", "weights": {"wsh": 1}}), "preference.weights: unknown task 'wsh' (did you mean "),
        (scenario({"kind": "max", "weights": {"wash": -1}}), "preference.weights.wash: must not be negative"),
        (scenario({"kind": "max", "weights": {"wash": "1"}}), "preference.weights.wash: must be a number, not '1'"),
        (scenario({"kind": "max", "over": "time"}), "preference.over: 'time' is unknown (valid: cost, violation)"),
        (scenario({"kind": "order", "over": "violation"}), "preference.over: unknown key"),
        (scenario({"kind": "deadline"}), "preference.deadlines: missing"),
        (scenario({"kind": "deadline", "deadlines": {"wash": {}}}), "preference.deadlines.wash.by: missing"),
        (scenario({"kind": "deadline", "deadlines": {"wsh": {"by": 3}}}), "preference.deadlines: unknown task 'wsh'"),
        (scenario({"kind": "expression"}), "preference.expression: missing"),
        (scenario({"kind": "expression", "expression": "wash / cook"}), "preference.expression: divides by 'cook'"),
        (scenario({"kind": "expression", "expression": "wash - cook"}), "preference.expression: must not be negative"),
        (
            scenario({"kind": "expression", "expression": "wash * cook", "contract": "convex"}),
            "preference.contract: not convex: mu grows from ",
        ),
        (scenario({"kind": "sum", "terms": []}), "preference.terms: a sum needs at least one"),
        (scenario({"kind": "sum", "terms": [{"kind": "sum"}]}), "preference.terms[0].kind: unknown kind 'sum'"),
        (
            scenario({"kind": "sum", "terms": [{"kind": "order"}, {"kind": "max", "weights": {"x": 1}}]}),
            "preference.terms[1].weights: unknown task 'x' (valid: wash, cook)",
        ),
        (scenario({"kind": "sum", "terms": [{"kind": "order", "weight": -1}]}), "preference.terms[0].weight: must not"),
        (scenario(WEIGHED, **relax("wet", "clean", 1)), "tasks[0].relax[0].assume: unknown proposition 'wet'"),
        (scenario(WEIGHED, **relax("warm", "X clean", 1)), "tasks[0].relax[0].when: 'X clean' has a temporal operator"),
        (scenario(WEIGHED, **relax("warm", "clean", -1)), "tasks[0].relax[0].cost: negative cost -1"),
        (scenario(WEIGHED, **relax("warm", "clean", "1")), "tasks[0].relax[0].cost: must be a number, not '1'"),
        (scenario(WEIGHED, skip=-3), "tasks[0].skip: negative cost -3"),
        (scenario({"kind": "order"}, skip=3), "tasks[0].skip: nothing in the preference weighs what it costs"),
        (scenario({"kind": "order"}) | {"tasks": []}, "tasks: a problem needs at least one task"),
    ],
)
def test_a_scenario_file_is_refused_by_file_and_key(data: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match="^" + re.escape(f"kitchen: {message}")):
        from_dict(data, name="kitchen").problem()


def test_a_scenario_file_may_hold_no_more_tasks_than_the_limit() -> None:
    tasks = [{"name": f"t{k}", "formula": "F clean"} for k in range(TASK_LIMIT + 1)]
    with pytest.raises(ScenarioError, match=f"kitchen: tasks: {TASK_LIMIT + 1} are more than the {TASK_LIMIT} "):
        from_dict(scenario({"kind": "order"}) | {"tasks": tasks}, name="kitchen").problem()
