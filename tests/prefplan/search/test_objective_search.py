"""Fronts of several costs and preferences against an exhaustive search that prunes nothing by contract."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import pytest
from judge.enumerate import TooManyError
from judge.planners import PlannerOf, ReferencePlanner
from judge.several import COST_NAMES, SeveralProblem, bounds_of, random_several, replayed, several_front
from judge.verdict import printed, relaxations

from prefplan import (
    Expression,
    NoPlanError,
    Options,
    Planner,
    Problem,
    Task,
    TransitionSystem,
    UnfinishedError,
    load,
    pareto_front,
)
from prefplan.heuristics.prepare import Prepared
from prefplan.limits import Limits
from prefplan.product.product_automaton import Product
from prefplan.scenario.decode import from_dict
from prefplan.search.driver import LabelSearch

BLOCKS = [range(16), range(21, 36), range(36, 50), (17, 18, 19, 61, 65, 100, 111, 116, 120, 191, 192, 212, 237, 3872)]
"""Seeds of problems, which reach every step from line to line, kernels included, that the first 250 do."""

PLANNERS: tuple[PlannerOf, ...] = (
    Planner,
    partial(Planner, options=Options(heuristic=0, preference_bound=False, contraction=False)),
    partial(Planner, options=Options(heuristic=2, contraction=False)),
    ReferencePlanner,
)


def wrong(problem: SeveralProblem, planners: tuple[PlannerOf, ...]) -> str | None:
    """Return what is wrong with the planner's answers, or None."""
    bounds = bounds_of(problem)
    planned = from_dict(problem.scenario(), name="problem").problem()
    if bounds is None:
        reason = Planner(planned).front(at_most=dict.fromkeys(planned.cost_names, 50)).reason
        return None if reason is not None and reason.kind in ("task", "conflict") else f"{reason} where no plan exists"
    try:
        expected = several_front(problem, bounds)
    except TooManyError:
        return None
    points = [tuple(map(printed, point)) for point in expected]
    for chosen in planners:
        planner = chosen(planned)
        front = planner.front(at_most=bounds)
        if [tuple(plan.objectives.values()) for plan in front] != points:
            return f"{chosen}: {[plan.objectives for plan in front]}, expected {points}"
        for plan in front:
            told = tuple(map(printed, replayed(problem, plan.actions, relaxations(plan))))
            if told != tuple(plan.objectives.values()):
                return f"{chosen}: {plan} is worth {told}"
        for k, name in enumerate(problem.names):
            try:
                best = tuple(planner.best(name, at_most=bounds).objectives.values())
            except NoPlanError:
                best = None
            if best != min(points, key=lambda point: (point[k], *point), default=None):
                return f"{chosen}: best in {name} is {best}, not of {points}"
    return None


@pytest.mark.slow
@pytest.mark.parametrize("seeds", BLOCKS, ids=lambda seeds: str(seeds[0]))
def test_fronts_are_those_of_the_judge(seeds: Sequence[int]) -> None:
    found = {seed: wrong(random_several(seed), PLANNERS[:1] if seed % 4 else PLANNERS) for seed in seeds}
    assert {seed: what for seed, what in found.items() if what} == {}


@pytest.fixture(scope="module")
def grid() -> Problem:
    """Two errands on a grid of random ground with three costs."""
    rng = random.Random(3)
    cells = [(x, y) for x in range(12) for y in range(12)]
    steps = [((x, y), (x + dx, y + dy)) for x, y in cells for dx, dy in ((0, 1), (1, 0), (0, -1), (-1, 0))]
    edges = [(a, str(b), b, {name: rng.randint(1, 9) for name in COST_NAMES}) for a, b in steps if b in cells]
    system = TransitionSystem.from_transitions(edges, start=(0, 0), labels={(11, 5): ["a"], (4, 11): ["b"]})
    return Problem(system, [Task("x", "F a"), Task("y", "F b")], [])


def test_one_objective_is_found_by_expanding_no_state_twice(grid: Problem) -> None:
    whole = [tuple(plan.objectives.values()) for plan in Planner(grid).front()]
    for k, name in enumerate(grid.objective_names):
        planner = Planner(grid)
        best = tuple(planner.best(name).objectives.values())
        assert best == min(whole, key=lambda point: (point[k], *point))
        assert planner.stats.expanded <= planner.stats.states
        assert [tuple(plan.objectives.values()) for plan in planner.front(over=[name])] == [best]


def test_a_search_that_a_limit_stops_has_every_point_below_some_cost(
    grid: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = [tuple(plan.objectives.values()) for plan in Planner(grid).front()]
    assert len(whole) > 50 and whole == sorted(whole)
    search = LabelSearch(Prepared(Product(grid), Options()), bounds={})
    most = Planner(grid).front().stats.expanded // 2
    monkeypatch.setattr(Limits, "out_of_time", property(lambda limits: search.work.expanded > most))
    with Limits():
        result = search.run()
    points = [goal.objectives for goal in result.goals]
    assert result.ended == "time" and 0 < len(points) < len(whole)
    below = result.complete_below * grid.cost_units[0]
    assert [point for point in points if point[0] < below] == [point for point in whole if point[0] < below]


@pytest.mark.parametrize(("limit", "ended"), [({"max_seconds": 0}, "time"), ({"max_memory": 1}, "memory")])
def test_limits_hold_from_the_first_line_on(grid: Problem, limit: dict[str, Any], ended: str) -> None:
    front = Planner(grid).front(**limit)
    assert (front.ended, front.complete) == (ended, False)
    with pytest.raises(UnfinishedError, match=f"stopped by the {ended} limit"):
        Planner(grid).best("energy", **limit)


def test_fronts_of_some_objectives_are_those_without_the_others(grid: Problem) -> None:
    system = replace(grid.system, costs=grid.system.costs[:2])
    two = [tuple(plan.objectives.values()) for plan in Planner(Problem(system, grid.tasks, [])).front()]
    projected = Planner(grid).front().over(["time", "energy"])
    assert [tuple(plan.objectives.values())[:2] for plan in projected] == two
    table = projected._repr_html_()
    assert "<th>time</th><th>energy</th><th>noise</th>" in table


@pytest.mark.parametrize(("name", "key"), [("cost", "max_cost"), ("preference", "max_preference")])
def test_of_two_bounds_of_one_objective_the_lower_holds(name: str, key: str) -> None:
    points = pareto_front("example").points
    values = sorted(point[("cost", "preference").index(name)] for point in points)
    assert len(values) > 1
    for one, other in ((values[0], values[-1]), (values[-1], values[0])):
        front = pareto_front("example", **{key: one, "at_most": {name: other}})  # type: ignore[arg-type]
        assert [plan.objectives[name] for plan in front] == [values[0]]


@pytest.mark.parametrize("expression", ["{0} + 2 * {1}", "{0} + {1} / 7", "max({0}, 2 * {1})"])
def test_a_constant_moves_bounds_of_a_preference_and_no_label_is_expanded_for_it(expression: str) -> None:
    example = load("case_study_1").problem()
    plain, moved = (
        Problem(example.system, example.tasks, Expression(expression.format(*example.names) + constant))
        for constant in ("", " + 61")
    )
    for plan, same in zip(pareto_front(plain), pareto_front(moved), strict=True):
        front, more = (
            pareto_front(plain, max_preference=plan.preference),
            pareto_front(moved, max_preference=same.preference),
        )
        assert more.points == [(cost, pytest.approx(preference + 61)) for cost, preference in front.points]
        assert more.points[0] == (same.cost, same.preference) and more.stats.expanded == front.stats.expanded
