"""Preference functions (Definition 5): values, against reference definitions, and what is refused."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import judge
import pytest

from prefplan import (
    Deadline,
    Due,
    Order,
    Plan,
    Problem,
    Task,
    TransitionSystem,
    WeightedSum,
    cheapest_plan,
)
from prefplan.preferences.kinds import Preference
from prefplan.preferences.objective import Measure
from prefplan.scenario.decode import from_dict


def chain(costs: Mapping[str, Fraction]) -> dict[str, Any]:
    """Return a `[model]` in which the only plan satisfies task `t`, that is `F at_t`, at the cost given for it."""
    stops = sorted({Fraction(0), *costs.values()})
    steps = [
        {"from": f"s{k}", "to": f"s{k + 1}", "cost": float(stops[k + 1] - stops[k])} for k in range(len(stops) - 1)
    ]
    labels = {f"s{k}": [f"at_{task}" for task in costs if costs[task] == stop] for k, stop in enumerate(stops)}
    return {"kind": "graph", "start": "s0", "transitions": steps, "labels": labels}


def only_plan(costs: Mapping[str, Fraction], preference: Mapping[str, Any]) -> Plan:
    tasks = [{"name": task, "formula": f"F at_{task}"} for task in costs]
    return cheapest_plan(from_dict({"model": chain(costs), "tasks": tasks, "preference": preference}).problem())


def mu(preference: Preference, **costs: int) -> float:
    """Return mu of tasks satisfied at these costs."""
    stops = sorted({0, *costs.values()})
    system = TransitionSystem.from_transitions(
        [(stops[k], "on", stops[k + 1], stops[k + 1] - stops[k]) for k in range(len(stops) - 1)],
        start=0,
        labels={stop: [f"at_{task}" for task in costs if costs[task] == stop] for stop in stops},
    )
    return cheapest_plan(Problem(system, [Task(task, f"F at_{task}") for task in costs], preference)).preference


@pytest.mark.parametrize(
    ("preference", "costs", "expected"),
    [
        (Order(), {"x": 20, "y": 5, "z": 10}, 15),
        (Order(), {"x": 6, "y": 5, "z": 2}, 4),
        (Order(("x", "y", "z")), {"x": 6, "y": 5, "z": 2}, 4),
        (Order(("z", "y", "x")), {"x": 6, "y": 5, "z": 2}, 0),
        (Order(("x", "z", "y")), {"x": 6, "y": 5, "z": 2}, 4),
        (Order(("y", "z", "x")), {"x": 6, "y": 5, "z": 2}, 3),
        (Order((("x", "z"), "y")), {"x": 6, "y": 5, "z": 2}, 1),
        (Order((("x", "y"), "z")), {"x": 6, "y": 5, "z": 2}, 4),
        (Order((("x", "y", "z"),)), {"x": 6, "y": 5, "z": 2}, 0),
        (Order(), {"x": 4, "y": 4, "z": 4}, 0),
        (Order(), {"x": 3, "y": 3, "z": 0}, 3),
        (WeightedSum({"x": 1, "y": 2, "z": 0}), {"x": 6, "y": 5, "z": 2}, 16),
        (WeightedSum({"x": 0, "y": 0, "z": 0}), {"x": 6, "y": 5, "z": 2}, 0),
        (Deadline({"x": Due(4)}), {"x": 6, "y": 5, "z": 2}, 2),
        (Deadline({"x": Due(4, 3), "y": Due(5), "z": Due(0, 2)}), {"x": 6, "y": 5, "z": 2}, 10),
        (Deadline({}), {"x": 6, "y": 5}, 0),
    ],
)
def test_values_by_hand(preference: Preference, costs: dict[str, int], expected: int) -> None:
    assert mu(preference, **costs) == expected


def random_table(rng: random.Random, names: Sequence[str]) -> dict[str, Any]:
    """Draw a `[preference]` table whose numbers have up to two decimals."""

    def number() -> float:
        return rng.choice((0, 1, rng.randrange(10), rng.randrange(100) / 10, rng.randrange(500) / 100))

    kind = rng.choice(("order", "weighted-sum", "deadline"))
    if kind == "order":
        return judge.random_preference(rng, names, kind)
    if kind == "weighted-sum":
        return {"kind": kind, "weights": {name: number() for name in names}}
    late = [name for name in names if rng.random() < 0.7]
    rows = {name: {"by": number()} | ({"weight": number()} if rng.random() < 0.6 else {}) for name in late}
    return {"kind": kind, "deadlines": rows}


def test_random_preferences_agree_with_their_definitions() -> None:
    for seed in range(300):
        rng = random.Random(seed)
        names = rng.sample(["t1", "t2", "t3", "t4"], rng.randint(1, 4))
        unit = rng.choice((1, 10, 100))
        costs = {name: Fraction(rng.choice((0, 2, 5, rng.randrange(12 * unit))), unit) for name in names}
        table = random_table(rng, names)
        plan = only_plan(costs, table)
        expected = judge.reference(table, names)(tuple(costs.values()), (0,) * len(names))
        assert plan.task_costs == {name: float(cost) for name, cost in costs.items()}, seed
        assert judge.exact(plan.preference) == expected, (seed, table)


def test_a_group_of_an_order_is_interchangeable() -> None:
    rng = random.Random(4)
    for _ in range(20):
        costs = {name: rng.randrange(10) for name in "abcd"}
        best = min(mu(Order(order), **costs) for order in (("a", "b", "c", "d"), ("a", "c", "b", "d")))
        assert mu(Order(("a", ("b", "c"), "d")), **costs) == best


def test_an_order_left_out_is_that_of_the_tasks() -> None:
    assert mu(Order(), y=1, x=2) == mu(Order(("y", "x")), y=1, x=2) == 0
    assert mu(Order(), x=2, y=1) == mu(Order(("x", "y")), y=1, x=2) == 1


@pytest.mark.parametrize(
    ("preference", "contract"),
    [(Order(), "additive"), (WeightedSum({"x": 1}), "additive"), (Deadline({"x": Due(3)}), "convex")],
)
def test_each_preference_tells_its_contract(preference: Preference, contract: str) -> None:
    assert Measure.of(preference.terms(["x"]), 1).contract == contract
