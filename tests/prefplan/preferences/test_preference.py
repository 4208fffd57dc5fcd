"""Preference functions (Definition 5): values, against reference definitions, and what is refused."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import judge
import pytest

from prefplan import (
    Plan,
    cheapest_plan,
)
from prefplan.scenario.decode import from_dict


def plan_of(names: Sequence[str], costs: Sequence[Fraction], preference: Mapping[str, Any]) -> Plan:
    """Return the only plan of tasks that are satisfied at these costs."""
    stops = sorted({Fraction(0), *costs})
    steps = [
        {"from": f"s{k}", "to": f"s{k + 1}", "cost": float(stops[k + 1] - stops[k])} for k in range(len(stops) - 1)
    ]
    done = dict(zip(names, costs, strict=True))
    labels = {f"s{k}": [f"at_{name}" for name in names if done[name] == stop] for k, stop in enumerate(stops)}
    model = {"kind": "graph", "start": "s0", "transitions": steps, "labels": labels}
    tasks = [{"name": name, "formula": f"F at_{name}"} for name in names]
    return cheapest_plan(from_dict({"model": model, "tasks": tasks, "preference": preference}).problem())


@pytest.mark.parametrize(
    ("preference", "expected"),
    [
        ({"kind": "order"}, 4),
        ({"kind": "order", "order": ["z", "y", "x"]}, 0),
        ({"kind": "order", "order": ["y", "z", "x"]}, 3),
        ({"kind": "order", "order": [["x", "z"], "y"]}, 1),
        ({"kind": "order", "order": [["x", "y", "z"]]}, 0),
        ({"kind": "weighted-sum", "weights": {"x": 1, "y": 2, "z": 0}}, 16),
        ({"kind": "max", "weights": {"z": 4}}, 8),
        ({"kind": "deadline", "deadlines": {"x": {"by": 4, "weight": 3}, "z": {"by": 1.5, "weight": 2}}}, 7),
        ({"kind": "expression", "expression": "x * y + 3 + z / 4"}, 33.5),
        ({"kind": "sum", "terms": [{"kind": "order", "weight": 3}, {"kind": "max"}]}, 18),
    ],
)
def test_values_by_hand(preference: dict[str, Any], expected: float) -> None:
    """The planner and the judge agree with what was worked out by hand for costs 6, 5 and 2."""
    names, costs = ("x", "y", "z"), (Fraction(6), Fraction(5), Fraction(2))
    assert plan_of(names, costs, preference).preference == expected
    assert judge.reference(preference, names)(costs, (0, 0, 0)) == expected


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
        plan = plan_of(names, list(costs.values()), table)
        expected = judge.reference(table, names)(tuple(costs.values()), (0,) * len(names))
        assert plan.task_costs == {name: float(cost) for name, cost in costs.items()}, seed
        assert judge.exact(plan.preference) == expected, (seed, table)


def test_a_preference_over_violations_reads_the_prices_paid() -> None:
    weights = {"kind": "weighted-sum", "weights": {"x": 1, "y": 1, "z": 2}, "over": "violation"}
    terms = [{"kind": "order", "weight": 3}, {"kind": "max", "over": "violation"}]
    names, costs, paid = ("x", "y", "z"), (6, 5, 2), (1, 0, 3)
    assert judge.reference(weights, names)(costs, paid) == 7
    assert judge.reference({"kind": "sum", "terms": terms}, names)(costs, paid) == 15


@pytest.mark.parametrize("expression", judge.EXPRESSIONS)
def test_listed_expressions_never_fall_along_a_trajectory(expression: str, rng: random.Random) -> None:
    value = judge.reference({"kind": "expression", "expression": expression}, ("x", "y", "z"))
    for _ in range(300):
        ends = [rng.choice((rng.randrange(12), 99)) for _ in range(3)]
        along = [value(tuple(min(end, g) for end in ends), (0, 0, 0)) for g in range(20)]
        assert along == sorted(along) and along[0] >= 0
