"""Fronts within some percent approximate the exact front as claimed."""

from __future__ import annotations

from decimal import Decimal

import judge
import pytest
from judge.enumerate import TooManyError
from judge.fuzz import draw
from judge.verdict import OPTIONS, beyond, exact_limit, misjudged

from prefplan import Options, Planner, PrefplanError, Problem, pareto_front
from prefplan.scenario.decode import from_dict

PERCENT = (1, 5, 20, 50)

MAX_COST = 50
"""Expressions that may fall have plans of interest at any cost."""


def planned(problem: judge.GraphProblem) -> Problem:
    return from_dict(problem.scenario(), name="problem").problem()


@pytest.mark.parametrize("kind", ["order", "deadline", "max", "expression"])
def test_every_best_trade_off_of_errands_is_within_the_percentage(kind: str) -> None:
    fewer: set[int] = set()
    for seed in range(8):
        problem = judge.random_errands(seed, kind)
        planner = Planner(planned(problem))
        exact = planner.front(max_cost=MAX_COST)
        expected = [(judge.exact(plan.cost), judge.exact(plan.preference)) for plan in exact]
        for percent in PERCENT:
            front = planner.front(within=percent, max_cost=MAX_COST)
            assert front.complete and front.within == percent
            assert beyond(front, expected, percent) is None
            assert not [wrong for plan in front if (wrong := misjudged(problem, plan))]
            if len(front) < len(exact):
                fewer.add(percent)
    assert 50 in fewer


@pytest.mark.parametrize("options", [OPTIONS[0], OPTIONS[1], OPTIONS[-1]])
def test_every_best_trade_off_of_random_problems_is_within_the_percentage(options: Options) -> None:
    """Judged by enumeration: every kind of preference, relaxations, and every style of numbers."""
    judged = 0
    for number in range(25):
        _, problem = draw(number)
        limit = exact_limit(problem)
        if limit is None or planned(problem).resolution is not None:
            continue
        try:
            expected = judge.exact_front(problem, max_cost=limit)
        except TooManyError:
            continue
        planner = Planner(planned(problem), options=options)
        for percent in (0, *PERCENT):
            assert (number, beyond(planner.front(within=percent, max_cost=limit), expected, percent)) == (number, None)
            judged += 1
    assert judged > 50


def test_half_a_percent_and_thousands_are_percentages_too() -> None:
    problem = planned(judge.random_errands(3, "order"))
    exact = pareto_front(problem)
    assert pareto_front(problem, within=Decimal("0.5")).within == 0.5
    assert pareto_front(problem, within=10**6).plans
    assert [plan.cost for plan in pareto_front(problem, within=0)] == [plan.cost for plan in exact]
    with pytest.raises(PrefplanError, match="within: -1 is negative"):
        pareto_front(problem, within=-1)
