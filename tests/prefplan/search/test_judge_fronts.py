"""The judge of fronts against hand-computed cases and plain listing of all plans."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import pytest
from judge import (
    GraphProblem,
    JudgedTask,
    cheapest_cost,
    exact_front,
    exact_plans,
    random_problem,
    replay,
)
from judge.examples import graph
from judge.semantics import holds_now


def test_zero_cost_loops_end_and_cost_nothing() -> None:
    edges = [("s", 0, "t"), ("t", 0, "s"), ("t", 0, "t"), ("s", 3, "u")]
    problem = graph(edges, {"t": "a", "u": "b"}, ["F(b & F b)", "F a"], {"kind": "order"})
    assert exact_front(problem, max_cost=9) == [(3, 3)]


def listed_front(problem: GraphProblem, max_cost: int) -> list[tuple[Any, Any]]:
    """Find the front by listing every plan with all its relaxations, judged by `replay`."""
    points = set()
    for actions in _all_actions(problem, problem.start, max_cost):
        states = replay(problem, actions).states
        readings = [list(_all_relaxations(problem, task, states)) for task in problem.tasks]
        for chosen in product(*readings):
            try:
                outcome = replay(problem, actions, [entry for taken in chosen for entry in taken])
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
    for seed in range(60):
        kind = ("sum", "max", "weighted-sum")[seed % 3] if relaxed else ("order", "expression", "deadline")[seed % 3]
        problem = random_problem(seed, kind=kind, relaxed=relaxed, decimals=seed % 4 // 3)
        cheapest = cheapest_cost(problem)
        plans = [] if cheapest is None else exact_plans(problem, max_cost=cheapest + 8)
        assert [plan.cost for plan in plans[:1]] == [cost for cost in [cheapest] if cost is not None]
        for plan in plans:
            outcome = replay(problem, plan.actions, plan.relaxations)
            assert (outcome.cost, outcome.mu, outcome.ends) == (plan.cost, plan.preference, True)
