"""A preference of one's own, from outside: the first tasks of the list matter most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import pytest

import prefplan as pp
from prefplan.preferences.terms import Maximum, OrderRate, Tardiness, Term, WeightedRate


@dataclass(frozen=True)
class EarlyBird:
    """mu = sum_i c_i / i: the first tasks of the list matter most."""

    def terms(self, tasks: Sequence[str]) -> list[Term | Fraction]:
        """Return the one additive term."""
        return [WeightedRate(tuple(Fraction(1, k) for k in range(1, len(tasks) + 1)))]


@dataclass(frozen=True)
class Given:
    """Returns what it is given as terms."""

    value: object

    def terms(self, tasks: Sequence[str]) -> Any:
        """Return it."""
        return self.value


SYSTEM = pp.TransitionSystem.from_transitions(
    [("s", "left", "a", 1), ("a", "on", "b", 5), ("s", "right", "b", 3), ("b", "on", "a", 4)],
    start="s",
    labels={"a": ["a"], "b": ["b"]},
)

TASKS = [pp.Task("second", "F b"), pp.Task("first", "F a")]


def test_a_preference_from_outside_is_planned_with_exactly() -> None:
    front = pp.pareto_front(pp.Problem(SYSTEM, TASKS, EarlyBird()))
    assert [(plan.cost, plan.preference) for plan in front] == [(6, 6.5)]
    assert pp.pareto_front(pp.Problem(SYSTEM, TASKS[::-1], EarlyBird()))[0].preference == 4
    generated = Given(term for term in EarlyBird().terms(["second", "first"]))
    assert pp.Problem(SYSTEM, TASKS, generated).measure.largest_rate == 3


@pytest.mark.parametrize("in_sum", [False, True])
@pytest.mark.parametrize(
    ("value", "words"),
    [
        (None, "terms: must be a list of terms and Fractions, not None"),
        ([1], r"terms\[0\]: must be a Fraction or a term of prefplan.preferences.terms.*, not 1 \(int\)"),
        ([Fraction(1), pp.Order()], r"terms\[1\]: must be a Fraction or a term .*, not Order"),
        ([WeightedRate((Fraction(1),))], r"terms\[0\].weights: must be 2, one for each task and rule, not 1"),
        ([Maximum((Fraction(1), Fraction(-1)))], r"terms\[0\]: weights must be whole numbers or Fractions, at least 0"),
        ([WeightedRate((0.5, 1.0))], r"terms\[0\]: weights must be whole numbers or Fractions"),  # type: ignore[arg-type]
        ([OrderRate(((0,), (0,)))], r"terms\[0\]: tasks must be numbers below 2, each once, not \(0, 0\)"),
        ([Tardiness(7, Fraction(3), Fraction(1))], r"terms\[0\]: tasks must be numbers below 2, each once, not \(7,\)"),
    ],
)
def test_terms_that_no_search_knows_are_refused(value: object, words: str, in_sum: bool) -> None:
    given = Given(value)
    with pytest.raises(pp.PreferenceError, match=f"^preference.{r'terms.0..' * in_sum}{words}"):
        pp.Problem(SYSTEM, TASKS, pp.Sum([(given, 1)]) if in_sum else given)
