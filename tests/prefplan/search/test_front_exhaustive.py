"""Whole fronts of small problems, point by point, against an exhaustive search that prunes nothing by contract."""

from __future__ import annotations

import heapq
import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from itertools import combinations
from typing import Any

import judge
import pytest
from judge.enumerate import Product

from prefplan import Front, NoPlanError, Planner, Problem, cheapest_plan, pareto_front, preferred_plan
from prefplan.scenario.decode import from_dict

KINDS = ("order", "weighted-sum", "deadline")


def errands(seed: int, kind: str) -> judge.GraphProblem:
    """Draw errands on a narrow grid of uneven ground, where doing a task early is a long way round."""
    rng = random.Random(f"errands {seed} {kind}")
    size = (rng.randint(5, 8), rng.choice((2, 2, 3)))
    cells = [(x, y) for x in range(size[0]) for y in range(size[1])]
    regions = {name: (x, y, x, y) for name, (x, y) in zip("abcde", rng.sample(cells, 5), strict=True)}

    def visit(*names: str) -> judge.Formula:
        first, *rest = (("ap", name) for name in names)
        return ("F", ("and", first, _all([("F", name) for name in rest])))

    def task() -> judge.Formula:
        p, q, r = rng.sample("abcde", 3)
        if rng.random() < 0.1:
            return ("and", ("U", ("not", ("ap", p)), ("ap", q)), visit(q, r))
        return rng.choice((visit(p, q), visit(p, q, r)))

    tasks = [judge.JudgedTask(f"phi{k + 1}", task()) for k in range(3)]
    preference = judge.random_preference(rng, [task.name for task in tasks], kind)
    grid = judge.grid_problem(size, rng.choice(cells), regions, tasks, preference)
    ground = rng.choice(((1,), (0, 1, 1, 2), (1, 1, 2, 5)))
    return replace(grid, edges=tuple(replace(edge, cost=rng.choice(ground)) for edge in grid.edges))


def _all(formulas: list[judge.Formula]) -> judge.Formula:
    first, *rest = formulas
    return ("and", first, _all(rest)) if rest else first


def graphs(seed: int, kind: str) -> judge.GraphProblem:
    return judge.random_problem(seed, kind=kind)


def decimal_graphs(seed: int, kind: str) -> judge.GraphProblem:
    return judge.random_problem(seed, kind=kind, decimals=1 + seed % 2)


@dataclass(frozen=True)
class Case:
    """A problem as the judge and as the planner see it, the planner's front, and the judge's up to a cost."""

    name: str
    judged: judge.GraphProblem
    problem: Problem
    front: Front
    exact: list[tuple[judge.Number, judge.Number]]

    @property
    def points(self) -> list[tuple[judge.Number, judge.Number]]:
        return [(judge.exact(plan.cost), judge.exact(plan.preference)) for plan in self.front]


def number(value: judge.Number) -> int | Decimal:
    """Return an exact number of the judge's as one the planner takes."""
    return value if isinstance(value, int) else Decimal(value.numerator) / Decimal(value.denominator)


def planner_problem(judged: judge.GraphProblem) -> Problem:
    return from_dict(judged.scenario()).problem()


def solved(draw: Callable[[int, str], judge.GraphProblem], kind: str, seed: int) -> Case:
    judged = draw(seed, kind)
    problem = planner_problem(judged)
    front = pareto_front(problem)
    cheapest = judge.cheapest_cost(judged)
    exact = []
    if cheapest is not None:
        limit = max(cheapest + 6, judge.exact(front[-1].cost) + 2 if front else 0)
        exact = judge.exact_front(judged, max_cost=limit)
    return Case(f"{draw.__name__}({seed}, {kind!r})", judged, problem, front, exact)


BLOCK = 10
"""Problems that one test looks at; more random graphs are judged in `test_contracts_exhaustive`."""


@pytest.fixture(
    scope="module",
    params=[
        pytest.param((draw, kind, first), id=f"{draw.__name__}-{kind}-{first}")
        for draw, seeds in ((graphs, 40), (decimal_graphs, 20), (errands, 100))
        for kind in KINDS
        for first in range(0, seeds, BLOCK)
    ],
)
def cases(request: pytest.FixtureRequest) -> list[Case]:
    draw, kind, first = request.param
    return [solved(draw, kind, seed) for seed in range(first, first + BLOCK)]


def test_the_front_has_exactly_the_points_of_the_exhaustive_search(cases: list[Case]) -> None:
    for case in cases:
        assert case.points == case.exact, case.name
        assert case.front.complete, case.name


def test_every_plan_is_worth_what_it_says(cases: list[Case]) -> None:
    for case in cases:
        for plan in case.front:
            verdict = judge.replay(case.judged, plan.actions)
            assert all(verdict.satisfied) and verdict.ends, case.name
            assert (verdict.cost, verdict.mu) == (judge.exact(plan.cost), judge.exact(plan.preference)), case.name
            assert dict(zip(case.judged.names, verdict.task_costs, strict=True)) == {
                task: judge.exact(cost) for task, cost in plan.task_costs.items()
            }, case.name
            assert verdict.states == plan.states, case.name


def test_one_plan_under_any_bound_is_the_first_point_within_it(cases: list[Case]) -> None:
    for case in cases:
        for k, (cost, mu) in enumerate(case.exact):
            worse = case.exact[k - 1][1] if k else mu + 2
            for bound in (mu, (mu + worse) * Fraction(1, 2)):
                plan = cheapest_plan(case.problem, max_preference=number(bound))
                assert (judge.exact(plan.cost), judge.exact(plan.preference)) == (cost, mu), (case.name, bound)


def test_below_the_smallest_mu_there_is_no_plan(cases: list[Case]) -> None:
    for case in cases:
        smallest = case.exact[-1][1] if case.exact else 0
        for choose in (cheapest_plan, preferred_plan) if smallest > 0 else ():
            with pytest.raises(NoPlanError) as caught:
                choose(case.problem, max_preference=number(smallest * Fraction(1, 2)))
            reason = caught.value.reason
            assert (reason.kind, judge.exact(reason.smallest)) == ("bound", smallest), case.name


def test_the_preferred_plan_is_the_last_point(cases: list[Case]) -> None:
    for case in cases:
        if case.exact:
            plan = preferred_plan(case.problem)
            assert (judge.exact(plan.cost), judge.exact(plan.preference)) == case.exact[-1], case.name
            assert preferred_plan(case.problem, max_preference=plan.preference) == plan, case.name


def test_a_bound_on_cost_keeps_the_points_within_it(cases: list[Case]) -> None:
    for case in cases:
        for k, plan in enumerate(case.front):
            assert pareto_front(case.problem, max_cost=plan.cost).plans == case.front.plans[: k + 1], case.name
        cheapest = case.exact[0][0] if case.exact else 0
        if cheapest > 0:
            front = pareto_front(case.problem, max_cost=number(cheapest * Fraction(1, 2)))
            assert not front.plans and front.reason is not None, case.name
            assert (front.reason.kind, judge.exact(front.reason.smallest)) == ("bound", cheapest), case.name


def test_the_same_problem_has_the_same_plans_every_time(cases: list[Case]) -> None:
    for case in cases:
        planner = Planner(planner_problem(case.judged))
        assert planner.front().plans == case.front.plans, case.name
        assert planner.front().plans == case.front.plans, case.name
        if case.front:
            assert cheapest_plan(case.problem) == planner.cheapest(), case.name
            assert preferred_plan(case.problem) == planner.preferred(), case.name


def test_a_plan_has_as_few_actions_as_its_point_allows(cases: list[Case]) -> None:
    for case in cases:
        if case.judged.preference["kind"] == "order" and case.front:
            fewest = fewest_actions(case.judged, case.exact)
            assert [len(plan.actions) for plan in case.front] == fewest, case.name


def fewest_actions(problem: judge.GraphProblem, points: list[tuple[judge.Number, judge.Number]]) -> list[int]:
    """Return the least number of actions of a plan with each (cost, mu), by cost and then by number of actions."""
    space, mu = Product(problem), problem.mu()
    [(_, first)] = space.starts
    tasks = range(len(problem.tasks))
    frozen = tuple(0 if first.node[1][k] < 0 else None for k in tasks)
    heap: list[Any] = [(0, 0, 0, first.node, frozen)]
    seen, found, ticket = set(), {}, 0
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
                ended = [cost if frozen[k] is None and move.node[1][k] < 0 else frozen[k] for k in tasks]
                ticket += 1
                heapq.heappush(heap, (cost, length + 1, ticket, move.node, tuple(ended)))
    return [found[point] for point in points]


def test_without_a_plan_the_front_blames_a_smallest_set_of_tasks(cases: list[Case]) -> None:
    for case in cases:
        reason = case.front.reason
        if case.exact:
            assert reason is None, case.name
            continue
        assert reason is not None and reason.kind == ("task" if len(reason.tasks) == 1 else "conflict"), case.name
        assert not is_feasible(case.judged, reason.tasks), case.name
        for size in range(1, len(reason.tasks)):
            assert all(is_feasible(case.judged, names) for names in combinations(case.judged.names, size)), case.name
        for choose in (cheapest_plan, preferred_plan):
            with pytest.raises(NoPlanError) as caught:
                choose(case.problem)
            assert caught.value.reason == reason, case.name


def is_feasible(problem: judge.GraphProblem, names: tuple[str, ...]) -> bool:
    """Say whether some plan satisfies these tasks together."""
    tasks = tuple(task for task in problem.tasks if task.name in names)
    return judge.cheapest_cost(replace(problem, tasks=tasks, preference={"kind": "order"})) is not None


def test_the_problems_show_something() -> None:
    """Most must have a plan, and many errands a trade-off, or the tests above are worth little."""
    for draw, plans, choices in ((graphs, 0.6, 0.05), (errands, 0.9, 0.3)):
        sizes = [len(pareto_front(planner_problem(draw(seed, "order")))) for seed in range(40)]
        assert sum(size >= 1 for size in sizes) >= plans * len(sizes)
        assert sum(size >= 2 for size in sizes) >= choices * len(sizes)
