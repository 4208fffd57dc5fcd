"""Preference functions (Definition 5): values, against reference definitions, and refused input."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import judge
import pytest

from prefplan import (
    Plan,
    WeightedSum,
    cheapest_plan,
)
from prefplan.preferences.expression import Variable, is_rounded, parse, scaled
from prefplan.preferences.objective import Measure
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
    """The planner and the judge agree with values computed by hand for costs 6, 5 and 2."""
    names, costs = ("x", "y", "z"), (Fraction(6), Fraction(5), Fraction(2))
    assert plan_of(names, costs, preference).preference == expected
    assert judge.reference(preference, names)(costs, (0, 0, 0)) == expected


def test_values_of_an_expression_that_divides_by_numbers_only_are_whole_multiples_of_a_factor() -> None:
    tree = parse("x * y / 3 + z / 4", {name: Variable(i) for i, name in enumerate("xyz")})
    whole, factor = scaled(tree, Fraction(1), Fraction(1))
    assert (is_rounded(whole), factor) == (False, Fraction(1, 12))


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


def test_a_sum_over_violation_costs_is_about_them_whatever_its_weights() -> None:
    terms = WeightedSum({}, over="violation").terms(["a", "b"], ["kept"])
    assert Measure(terms, tasks=2, rules=1).weighs_violation
