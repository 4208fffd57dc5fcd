"""The judge of fronts against hand-computed cases and plain listing of all plans."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

import pytest
from judge import (
    Edge,
    GraphProblem,
    JudgedTask,
    Relaxation,
    cheapest_cost,
    exact_front,
    exact_plans,
    grid_problem,
    parse,
    random_problem,
    replay,
)
from judge.examples import TRAPS, graph, tasks
from judge.preferences import named
from judge.semantics import holds_now
from small_models import MEADOW


@pytest.mark.parametrize("name", TRAPS)
def test_points_that_pruning_by_cost_and_mu_would_lose_are_found(name: str) -> None:
    problem, front = TRAPS[name]
    assert exact_front(problem, max_cost=60) == front


@pytest.fixture
def example() -> GraphProblem:
    """The paper's Examples 1-3."""
    formulas = tasks("F charge", "F (plant & F rock)", "!plant U dirt")
    return grid_problem((3, 3), (0, 0), MEADOW, formulas, {"kind": "order"})


def test_the_papers_example_has_its_plan_and_its_front(example: GraphProblem) -> None:
    outcome = replay(example, ["E", "E", "W", "N", "N", "E"])
    assert (outcome.cost, outcome.task_costs, outcome.mu, outcome.ends) == (6, (6, 5, 2), 4, True)
    assert exact_front(example, max_cost=20) == [(6, 4), (9, 3)]


def test_the_papers_example_misses_charge_with_the_action_it_prints(example: GraphProblem) -> None:
    outcome = replay(example, ["E", "E", "W", "N", "N", "W"])
    assert outcome.satisfied == (False, True, True)
    assert outcome.task_costs[0] == outcome.cost == 6
    assert not outcome.ends


@pytest.mark.parametrize(
    ("first", "second", "front"),
    [
        (((5, 8), (0, 7), (9, 9)), ((6, 1), (9, 9), (9, 8)), [(31, 10), (32, 0)]),
        (((9, 4), (0, 1), (6, 5)), ((4, 2), (8, 3), (7, 3)), [(27, 16), (29, 9), (36, 0)]),
    ],
)
def test_grid_instances_have_the_fronts_of_an_independent_solver(
    first: tuple[tuple[int, int], ...], second: tuple[tuple[int, int], ...], front: list[tuple[int, int]]
) -> None:
    regions = {f"x{x}y{y}": (x, y, x, y) for x, y in (*first, *second)}
    visits = [[f"x{x}y{y}" for x, y in cells] for cells in (first, second)]
    formulas = tasks(*(f"F({a} & F({b}) & F({c}))" for a, b, c in visits))
    problem = grid_problem((10, 10), (0, 0), regions, formulas, {"kind": "order"})
    assert exact_front(problem, max_cost=front[-1][0]) == front


def test_zero_cost_loops_end_and_cost_nothing() -> None:
    edges = [("s", 0, "t"), ("t", 0, "s"), ("t", 0, "t"), ("s", 3, "u")]
    problem = graph(edges, {"t": "a", "u": "b"}, ["F(b & F b)", "F a"], {"kind": "order"})
    assert exact_front(problem, max_cost=9) == [(3, 3)]


def listed_front(problem: GraphProblem, max_cost: int) -> list[tuple[Any, Any]]:
    """Find the front by listing every plan and every way of relaxing it, judged by `replay`."""
    points = set()
    for actions in _all_actions(problem, problem.start, max_cost):
        states = replay(problem, actions).states
        ways = [list(_all_relaxations(problem, task, states)) for task in problem.tasks]
        for chosen in product(*ways):
            try:
                outcome = replay(problem, actions, [entry for way in chosen for entry in way])
            except ValueError:
                continue
            if outcome.ends:
                points.add((outcome.cost, outcome.mu))
    return [
        (cost, mu)
        for cost, mu in sorted(points)
        if not any(c <= cost and m <= mu and (c, m) != (cost, mu) for c, m in points)
    ]


def _all_actions(problem: GraphProblem, state: str, budget: Any) -> Iterator[list[str]]:
    yield []
    for edge in problem.outgoing.get(state, []):
        if edge.cost <= budget:
            yield from ([edge.action, *rest] for rest in _all_actions(problem, edge.target, budget - edge.cost))


def _all_relaxations(
    problem: GraphProblem, task: JudgedTask, states: tuple[str, ...]
) -> Iterator[list[dict[str, Any]]]:
    if task.skip is not None:
        yield [{"task": task.name, "step": 0, "skip": True, "cost": task.skip}]
    offers = []
    for step, state in enumerate(states):
        for entry in task.relax:
            if entry.assume not in problem.label(state) and holds_now(entry.when, problem.label(state)):
                offers.append({"task": task.name, "step": step, "assume": entry.assume, "cost": entry.cost})
    for taken in product((False, True), repeat=len(offers)):
        yield [offer for offer, take in zip(offers, taken, strict=True) if take]


@pytest.mark.parametrize("kind", ["order", "expression", "sum", "relaxed"])
def test_fronts_are_those_of_listing_every_plan(kind: str) -> None:
    compared = 0
    for seed in range(150):
        if kind == "relaxed":
            problem = random_problem(seed, kind="sum", tasks=2, relaxed=True)
        else:
            problem = random_problem(seed, kind=kind)
        if any(edge.cost == 0 for edge in problem.edges):
            continue
        cheapest = cheapest_cost(problem)
        bound = 3 if cheapest is None else cheapest + 3
        if bound <= (5 if kind == "relaxed" else 9):
            assert exact_front(problem, max_cost=bound) == listed_front(problem, bound)
            compared += 1
    assert compared >= 10


@pytest.mark.parametrize("relaxed", [False, True])
def test_every_point_comes_with_a_plan_that_replays_to_it(relaxed: bool) -> None:
    for seed in range(200):
        kind = ("sum", "max", "weighted-sum")[seed % 3] if relaxed else ("order", "expression", "deadline")[seed % 3]
        problem = random_problem(seed, kind=kind, relaxed=relaxed, decimals=seed % 4 // 3)
        cheapest = cheapest_cost(problem)
        plans = [] if cheapest is None else exact_plans(problem, max_cost=cheapest + 8)
        assert [plan.cost for plan in plans[:1]] == [cost for cost in [cheapest] if cost is not None]
        for plan in plans:
            outcome = replay(problem, plan.actions, plan.relaxations)
            assert (outcome.cost, outcome.mu, outcome.ends) == (plan.cost, plan.preference, True)


def test_random_problems_are_the_same_for_the_same_seed_and_often_have_a_choice() -> None:
    assert random_problem(3).scenario() == random_problem(3).scenario()
    fronts = []
    for seed in range(300):
        problem = random_problem(seed)
        problem = replace(
            problem,
            preference={"kind": "expression", "expression": named("max(x, y, z) - min(x, y, z)", problem.names)},
        )
        cheapest = cheapest_cost(problem)
        fronts.append([] if cheapest is None else exact_front(problem, max_cost=cheapest + 12))
    assert sum(len(front) > 1 for front in fronts) >= 5
    assert sum(bool(front) for front in fronts) >= 200


def test_a_scenario_names_all_that_its_file_needs() -> None:
    problem = graph([("s", 1, "t")], {"t": "a"}, ["F(a & F b)"], {"kind": "order"})
    edge = Edge("t", "back", Fraction(1, 2), "s")
    task = replace(problem.tasks[0], relax=(Relaxation("b", parse("!c"), 2),), skip=9)
    scenario = replace(problem, edges=(*problem.edges, edge), tasks=(task,)).scenario()
    assert scenario == {
        "model": {
            "kind": "graph",
            "start": "s",
            "propositions": ["b", "c"],
            "transitions": [
                {"from": "s", "to": "t", "cost": 1},
                {"from": "t", "to": "s", "action": "back", "cost": 0.5},
            ],
            "labels": {"t": ["a"]},
        },
        "tasks": [
            {
                "name": "phi1",
                "formula": "F ( a & F b )",
                "relax": [{"assume": "b", "when": "! c", "cost": 2}],
                "skip": 9,
            }
        ],
        "preference": {"kind": "order"},
    }
