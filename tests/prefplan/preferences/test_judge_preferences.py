"""The judge of preferences against hand-computed values."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import pytest
from judge import EXPRESSIONS, reference


@pytest.mark.parametrize(
    ("preference", "costs", "violations", "value"),
    [
        ({"kind": "order"}, (6, 5, 2), (0, 0, 0), 4),
        ({"kind": "order", "order": ["t3", "t2", "t1"]}, (6, 5, 2), (0, 0, 0), 0),
        ({"kind": "order", "order": [["t1", "t3"], "t2"]}, (6, 5, 2), (0, 0, 0), 1),
        ({"kind": "order", "order": [["t1", "t2", "t3"]]}, (6, 5, 2), (0, 0, 0), 0),
        ({"kind": "weighted-sum", "weights": {"t1": 1, "t2": 0, "t3": 2.5}}, (6, 5, 2), (0, 0, 0), 11),
        (
            {"kind": "weighted-sum", "weights": {"t1": 1, "t2": 1, "t3": 2}, "over": "violation"},
            (6, 5, 2),
            (1, 0, 3),
            7,
        ),
        ({"kind": "max"}, (6, 5, 2), (0, 0, 0), 6),
        ({"kind": "max", "weights": {"t3": 4}}, (6, 5, 2), (0, 0, 0), 8),
        ({"kind": "deadline", "deadlines": {"t1": {"by": 4}, "t3": {"by": 1.5, "weight": 2}}}, (6, 5, 2), (0, 0, 0), 3),
        ({"kind": "expression", "expression": "t1 * t2 - 3"}, (6, 5, 2), (0, 0, 0), 27),
        ({"kind": "expression", "expression": "(t1 - t2) / 3 + 0.5 * t3"}, (6, 5, 2), (0, 0, 0), Fraction(4, 3)),
        (
            {
                "kind": "sum",
                "terms": [{"kind": "order", "weight": 3}, {"kind": "max", "weight": 1, "over": "violation"}],
            },
            (6, 5, 2),
            (0, 9, 1),
            21,
        ),
    ],
)
def test_preferences_have_the_values_of_their_definitions(
    preference: dict[str, Any], costs: tuple[int, ...], violations: tuple[int, ...], value: int
) -> None:
    assert reference(preference, ("t1", "t2", "t3"))(costs, violations) == value


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_listed_expressions_never_fall_along_a_trajectory(expression: str, rng: random.Random) -> None:
    value = reference({"kind": "expression", "expression": expression}, ("x", "y", "z"))
    for _ in range(300):
        ends = [rng.choice((rng.randrange(12), 99)) for _ in range(3)]
        along = [value(tuple(min(end, g) for end in ends), (0, 0, 0)) for g in range(20)]
        assert along == sorted(along) and along[0] >= 0
