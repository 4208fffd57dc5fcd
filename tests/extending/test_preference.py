"""A preference of one's own, from outside: the first tasks of the list matter most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import prefplan as pp
from prefplan.preferences.terms import Term, WeightedRate


@dataclass(frozen=True)
class EarlyBird:
    """mu = sum_i c_i / i: the first tasks of the list matter most."""

    def terms(self, tasks: Sequence[str]) -> list[Term | Fraction]:
        """Return the one additive term."""
        return [WeightedRate(tuple(Fraction(1, k) for k in range(1, len(tasks) + 1)))]


def test_a_preference_from_outside_is_planned_with_exactly() -> None:
    system = pp.TransitionSystem.from_transitions(
        [("s", "left", "a", 1), ("a", "on", "b", 5), ("s", "right", "b", 3), ("b", "on", "a", 4)],
        start="s",
        labels={"a": ["a"], "b": ["b"]},
    )
    tasks = [pp.Task("second", "F b"), pp.Task("first", "F a")]
    front = pp.pareto_front(pp.Problem(system, tasks, EarlyBird()))
    assert [(plan.cost, plan.preference) for plan in front] == [(6, 6.5)]
    assert pp.pareto_front(pp.Problem(system, tasks[::-1], EarlyBird()))[0].preference == 4
