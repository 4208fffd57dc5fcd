"""Whole fronts of many small problems against an exhaustive search that prunes nothing by contract."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import judge
import pytest
from judge.enumerate import explored
from judge.examples import TRAPS
from judge.fuzz import AGREES, draw, judged
from judge.planners import PLANNERS
from judge.verdict import misjudged, verdict

from prefplan import pareto_front
from prefplan.scenario.decode import from_dict

DEARER_STEPS = 5813372, 5813458
"""Numbers of problems in which a plan is not the cheapest one between two waypoints."""

BLOCKS = [range(50), range(50, 100), (125, 250, 277, 309, 336, 620, 678, 775, 823, 843, 981, 999, *DEARER_STEPS)]
"""Numbers of problems, which reach every step from line to line, kernels included, that the first 1,000 do.

`python -m judge.fuzz` judges as many as there is time for.
"""

ERRANDS = (*range(8), 11, 22)
"""Seeds of problems with long plans, of each of three kinds of preference, which reach what the first 25 do."""


@pytest.mark.slow
@pytest.mark.parametrize("numbers", BLOCKS, ids=lambda numbers: str(numbers[0]))
def test_fronts_bounds_and_plans_are_those_of_the_judges(numbers: Sequence[int]) -> None:
    """Every kind of preference, over costs and over violations, and every style of numbers."""
    outcomes = list(judged(iter(numbers)))
    assert [(number, name, wrong) for number, name, outcome, wrong in outcomes if outcome != AGREES] == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["order", "weighted-sum", "deadline"])
def test_fronts_of_errands_are_those_of_the_judges(kind: str) -> None:
    """Long plans, and many trade-offs."""
    outcomes = {seed: verdict(judge.random_errands(seed, kind), PLANNERS[:1]) for seed in ERRANDS}
    assert {seed: wrong for seed, wrong in outcomes.items() if wrong} == {}


def front_of(problem: judge.GraphProblem) -> list[Any]:
    return list(pareto_front(from_dict(problem.scenario()).problem(), max_cost=100))


def test_the_problems_drawn_have_plans_trade_offs_and_relaxations() -> None:
    """Otherwise the tests above show little."""
    fronts = [front_of(judge.random_errands(seed, "order")) for seed in range(20)]
    assert sum(len(front) >= 2 for front in fronts) >= 6
    relaxed = [draw(number) for number in range(100)]
    fronts = [front_of(problem) for name, problem in relaxed if "over violation" in name]
    assert sum(len(front) > 1 for front in fronts) >= 5
    bought = [purchase for front in fronts for plan in front for purchase in plan.relaxations]
    assert sum(purchase.assume is None for purchase in bought) >= 5
    assert sum(purchase.assume is not None and purchase.step > 0 for purchase in bought) >= 5


@pytest.mark.parametrize("seed", range(20))
def test_plans_have_as_few_actions_as_possible_and_are_the_same_every_time(seed: int) -> None:
    problem = judge.random_errands(seed, "order")
    front = front_of(problem)
    points = [(judge.exact(plan.cost), judge.exact(plan.preference)) for plan in front]
    assert [len(plan.actions) for plan in front] == fewest_actions(problem, points)
    assert front_of(problem) == front


def fewest_actions(problem: judge.GraphProblem, points: list[tuple[judge.Number, judge.Number]]) -> list[int]:
    """Return the least number of actions of a plan with each (cost, mu), by cost and then by number of actions."""
    space, mu = explored(problem), problem.mu()
    [(_, first)] = space.starts
    tasks = range(len(problem.tasks))
    heap: list[Any] = [(0, 0, 0, first.node, tuple(0 if first.node[1][k] < 0 else None for k in tasks))]
    seen, found, ticket = set(), {}, itertools.count(1)
    while heap:
        g, length, _, node, frozen = heapq.heappop(heap)
        if (g, node, frozen) in seen:
            continue
        seen.add((g, node, frozen))
        if space.finished(node):
            found.setdefault((g, mu(frozen, (0,) * len(tasks))), length)
            continue
        for move in space.moves[node]:
            cost = g + move.cost
            if move.node in space.distance and cost + space.distance[move.node] <= points[-1][0]:
                ended = tuple(cost if frozen[k] is None and move.node[1][k] < 0 else frozen[k] for k in tasks)
                heapq.heappush(heap, (cost, length + 1, next(ticket), move.node, ended))
    return [found[point] for point in points]


@pytest.mark.parametrize("seed", range(10))
def test_a_bound_below_the_cheapest_cost_leaves_no_plan(seed: int) -> None:
    drawn = (judge.random_errands(number, "order") for number in itertools.count(seed, 10))
    problem, least = next((one, cost) for one in drawn if (cost := judge.cheapest_cost(one)))
    front = pareto_front(from_dict(problem.scenario()).problem(), max_cost=least * Fraction(1, 2))
    assert not front.plans and front.reason is not None
    assert (front.reason.kind, front.reason.smallest) == ("bound", least)


@pytest.mark.parametrize("name", TRAPS)
def test_points_that_pruning_by_another_key_would_lose_are_found(name: str) -> None:
    problem, contract, points = TRAPS[name]
    assert judge.exact_front(problem, max_cost=100) == points
    planned = from_dict(problem.scenario()).problem()
    assert planned.measure.contract == contract
    for planner in PLANNERS:
        front = planner(planned).front()
        assert [(plan.cost, plan.preference) for plan in front] == points
        assert not [wrong for plan in front if (wrong := misjudged(problem, plan))]
