"""Exact costs: decimals as integers, so that equal sums are equal points."""

from __future__ import annotations

from decimal import Decimal

import pytest

from prefplan import (
    Deadline,
    Due,
    ModelError,
    Order,
    Problem,
    Task,
    TransitionSystem,
    WeightedSum,
    cheapest_plan,
    pareto_front,
)
from prefplan.preference import Preference
from prefplan.quanta import decimals_of, exact, from_quanta, to_quanta


@pytest.mark.parametrize(
    ("value", "written"),
    [(0.1, "0.1"), (3, "3"), (1e-3, "0.001"), (2.50, "2.5"), (Decimal("0.30"), "0.3"), (1e3, "1000")],
)
def test_a_number_is_the_decimal_a_person_would_write(value: float, written: str) -> None:
    assert exact(value) == Decimal(written)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf"), Decimal("NaN"), "three", None])
def test_what_is_not_a_finite_number_is_refused(value: object) -> None:
    with pytest.raises(ModelError, match="must be a (finite )?number"):
        exact(value)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("values", "decimals"),
    [([], 0), ([3, 4], 0), ([0.5], 1), ([0.25, 1e-3], 3), ([100, 1e20], 0), ([Decimal("0.10")], 1)],
)
def test_as_many_decimals_as_it_takes(values: list, decimals: int) -> None:
    assert decimals_of(values) == decimals


@pytest.mark.parametrize("values", [[1, 2, 3], [0.1, 0.2, 0.3], [0, 1.25, 1e-6], [2**53 + 1], [Decimal("4.000001")]])
def test_quanta_convert_back_to_what_they_were(values: list) -> None:
    quanta, decimals = to_quanta(values)
    assert all(isinstance(q, int) for q in quanta)
    assert [from_quanta(q, decimals) for q in quanta] == pytest.approx([float(v) for v in values], rel=0, abs=0)


def test_whole_numbers_come_back_as_integers() -> None:
    assert [repr(from_quanta(q, 1)) for q in (30, 35)] == ["3", "3.5"]


@pytest.mark.parametrize("values", [[2**62], [10**16, 0.001], [1e30]])
def test_what_does_not_fit_is_refused_rather_than_wrapped(values: list) -> None:
    with pytest.raises(ModelError, match="too large to be held exactly"):
        to_quanta(values)


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


@pytest.mark.parametrize(
    ("preference", "mu"),
    [
        (WeightedSum({"one": 0.1, "two": 0.2}), 0.07),
        (WeightedSum({"one": 3, "two": 0}), 0.3),
        (Deadline({"one": Due(0.05, 0.3), "two": Due(0.25)}), 0.065),
        (Deadline({"two": Due(Decimal("0.299"))}), 0.001),
    ],
)
def test_mu_is_exact_in_the_users_units(dimes: TransitionSystem, preference: Preference, mu: float) -> None:
    plan = cheapest_plan(Problem(dimes, [Task("one", "F a"), Task("two", "F b")], preference))
    assert (plan.cost, plan.preference) == (0.3, mu)


@pytest.mark.parametrize(("bound", "found"), [(0.3, True), (Decimal("0.3"), True), (0.29, False), (1, True)])
def test_a_bound_on_cost_is_inclusive_and_exact(dimes: TransitionSystem, bound: float, found: bool) -> None:
    front = pareto_front(Problem(dimes, [Task("one", "F a"), Task("two", "F b")], Order()), max_cost=bound)
    assert bool(front) == found
    if not found:
        assert front.reason is not None
        assert (front.reason.kind, front.reason.smallest) == ("bound", 0.3)


def test_a_bound_on_mu_is_inclusive_and_exact(dimes: TransitionSystem) -> None:
    problem = Problem(dimes, [Task("one", "F a"), Task("two", "F b")], WeightedSum({"one": 0.1, "two": 0.2}))
    assert cheapest_plan(problem, max_preference=0.07).preference == 0.07


def test_ten_dimes_are_one() -> None:
    steps = [(k, "on", k + 1, 0.1) for k in range(10)]
    system = TransitionSystem.from_transitions(steps, start=0, labels={10: ["end"]})
    plan = cheapest_plan(Problem(system, [Task("one", "F end")], WeightedSum({"one": 0.1})))
    assert (repr(plan.cost), repr(plan.preference)) == ("1", "0.1")
