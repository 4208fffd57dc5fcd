"""Exact costs: rationals as whole multiples of a unit, so that equal sums are equal points."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from prefplan import (
    Deadline,
    Due,
    Expression,
    Ledger,
    ModelError,
    NoPlanError,
    Order,
    Problem,
    Task,
    TransitionSystem,
    WeightedSum,
    pareto_front,
    preferred_plan,
)
from prefplan.exact_costs import exact, in_common_unit, inclusive, to_number
from prefplan.preferences.kinds import Preference


@pytest.mark.parametrize(
    ("value", "meant"),
    [
        (0.1, Fraction(1, 10)),
        (3, Fraction(3)),
        (1e-3, Fraction(1, 1000)),
        (Decimal("0.30"), Fraction(3, 10)),
        (1e3, Fraction(1000)),
        (0.1 + 0.2, Fraction(3, 10)),
        (1 / 3, Fraction(333333333333333, 10**15)),
        (Decimal("0.3333333333333333"), Fraction(3333333333333333, 10**16)),
        (Fraction(1, 3), Fraction(1, 3)),
        (np.float32(0.1), Fraction(1, 10)),
        (2.0**80, Fraction(2**80)),
        (5e-324, Fraction(5, 10**324)),
    ],
)
def test_a_number_stands_for_what_a_person_means(value: float, meant: Fraction) -> None:
    assert exact(value) == meant


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf"), Decimal("NaN"), "three", None, True])
def test_what_is_not_a_finite_number_is_refused(value: object) -> None:
    with pytest.raises(ModelError, match="must be a (finite )?number"):
        exact(value)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "value", [Decimal("1e9999999"), Decimal("1e-999999999"), Decimal("0." + "9" * 5000), 10**4000, -(10**4000)]
)
def test_numbers_beyond_reason_are_refused_at_once(value: object) -> None:
    with pytest.raises(ModelError, match="between .*1e400") as caught:
        exact(value, "cost")  # type: ignore[arg-type]
    assert str(caught.value).startswith("cost: must") and len(str(caught.value)) < 150


@pytest.mark.parametrize(
    "values", [[], [0, 0], [6, 4], [Fraction(1, 2), Fraction(1, 3)], [Fraction(5, 4), 0, 10**30], [Fraction(1, 10**40)]]
)
def test_values_are_whole_multiples_of_their_common_unit(values: list) -> None:
    counts, unit = in_common_unit([Fraction(v) for v in values])
    assert [count * unit for count in counts.tolist()] == values
    assert counts.dtype == (object if max(counts.tolist(), default=0) >= 2**62 else np.int64)
    assert math.gcd(*counts.tolist()) <= 1


def test_whole_numbers_are_printed_as_integers() -> None:
    assert [repr(to_number(Fraction(n, 10))) for n in (30, 35)] == ["3", "3.5"]
    assert to_number(Fraction(10**400, 3)) == 10**400 // 3


@given(st.fractions(min_value=0, max_value=10**6, max_denominator=10**20))
@example(1 + Fraction(1, 2**53))  # midway between two floats, of which 1.0 is printed
def test_a_bound_admits_just_what_is_printed_as_no_more(value: Fraction) -> None:
    number = to_number(value)
    for bound in (number, Decimal(str(number)), np.float64(number)):
        assert inclusive(bound) >= value
    if isinstance(number, float):
        below = math.nextafter(number, 0)
        assert inclusive(below) < value
        assert to_number(inclusive(number)) == number


@pytest.mark.parametrize("bound", [2.6666666666666665, Fraction(8, 3), Decimal("2.6666666666666665")])
def test_the_printed_penalty_of_the_preferred_plan_may_be_used_as_its_bound(bound: float) -> None:
    system = TransitionSystem.from_transitions([("s", "go", "t", 8)], start="s", labels={"t": ["a"]})
    problem = Problem(system, [Task("go", "F a")], Expression("go / 3"))
    assert preferred_plan(problem).preference == 2.6666666666666665
    assert preferred_plan(problem, max_preference=bound).actions == ("go",)
    with pytest.raises(NoPlanError):
        preferred_plan(problem, max_preference=2.666666666666666)


@pytest.fixture
def dimes() -> TransitionSystem:
    """Two ways to b: 0.1 + 0.2, and 0.3 at once; in doubles they differ. On the second, a comes first."""
    return TransitionSystem.from_transitions(
        [
            ("s", "x", "m", 0.1),
            ("m", "y", "end", 0.2),
            ("s", "z", "end", 0.3),
            ("s", "w", "n", 0.2),
            ("n", "v", "end", 0.1),
        ],
        start="s",
        labels={"m": ["a"], "end": ["b"], "n": ["a"]},
    )


@pytest.mark.parametrize(
    "preference", [Order(), WeightedSum({"one": 0.1, "two": 0.2}), Deadline({"one": Due(0.05, 0.3), "two": Due(0.25)})]
)
def test_two_ways_of_adding_the_same_costs_make_one_point(dimes: TransitionSystem, preference: Preference) -> None:
    tasks = [Task("one", "F (a | b)"), Task("two", "F b")]
    front = pareto_front(Problem(dimes, tasks, preference))
    assert [plan.cost for plan in front] == [0.3]
    assert front[0].actions == (("z",) if isinstance(preference, Order) else ("x", "y"))
    assert front[0].task_costs == {"one": 0.3 if isinstance(preference, Order) else 0.1, "two": 0.3}


def test_a_bound_written_as_a_whole_number_is_exact() -> None:
    """Of two whole values with the same nearest float, the lesser one as a bound leaves out the greater one."""
    lesser, greater = 12 * 10**45 + 2 * 10**30, 12 * 10**45 + 3 * 10**30
    assert float(lesser) == float(greater)
    assert inclusive(Decimal(str(lesser))) == lesser
    assert inclusive(Decimal(str(float(lesser)))) >= greater


@pytest.mark.parametrize(("bound", "found"), [(0.3, True), (Decimal("0.3"), True), (0.29, False), (1, True)])
def test_a_bound_on_cost_is_inclusive_and_exact(dimes: TransitionSystem, bound: float, found: bool) -> None:
    front = pareto_front(Problem(dimes, [Task("one", "F a"), Task("two", "F b")], Order()), max_cost=bound)
    assert bool(front) == found
    if not found:
        assert front.reason is not None
        assert (front.reason.kind, front.reason.smallest) == ("bound", 0.3)


@given(st.lists(st.fractions(min_value=0, max_denominator=60), max_size=6))
def test_what_is_spent_are_the_sums_of_the_first_so_many(costs: list[Fraction]) -> None:
    system = TransitionSystem.from_transitions([("s", "go", "s", 1)], start="s", labels={"s": ["a"]})
    problem = Problem(system, [Task("one", "F a")], Order())
    ledger = Ledger.of(problem, ["go"] * len(costs), costs, [frozenset({"a"})] * (len(costs) + 1))
    assert ledger.spent == tuple(sum(costs[:k], Fraction(0)) for k in range(len(costs) + 1))
