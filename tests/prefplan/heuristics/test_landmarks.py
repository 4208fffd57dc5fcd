"""Landmark bounds, against exact costs-to-go of all tasks together."""

from __future__ import annotations

import random
from itertools import product
from typing import Any

import judge
import numpy as np
import pytest
from judge.problems import GraphProblem

from prefplan import Order, Planner, Problem, Task, TransitionSystem
from prefplan.heuristics import landmarks as heuristic
from prefplan.heuristics.backward import Backward
from prefplan.heuristics.landmarks import Landmarks, landmarks
from prefplan.models.kernels import INFINITE, UNREACHABLE, kernel
from prefplan.product.contraction import contract
from prefplan.product.product_automaton import Product
from prefplan.scenario.decode import from_dict


@kernel
def _bound_of(marks: Landmarks | None, node: int, automata: np.ndarray) -> Any:
    return heuristic.landmark_bound(marks, node, automata)


def repriced(marks: Landmarks, rng: random.Random) -> Landmarks:
    """Return the same landmarks with other multipliers."""
    price = np.array([rng.randrange(-60, 60) for _ in marks.price], dtype=np.int64)
    node_price = np.array([rng.randrange(-60, 60) for _ in marks.node_price], dtype=np.int64)
    between = marks.between - marks.price - marks.price[:, None] + price + price[:, None]
    ahead = marks.ahead - marks.price - marks.node_price[:, None] + price + node_price[:, None]
    return marks._replace(between=between, ahead=ahead, price=price, node_price=node_price)


def bounds_and_costs(problem: GraphProblem, seed: int) -> list[tuple[int, int]]:
    """Return for product states the landmarks' bound and what all tasks cost from there, with several multipliers."""
    whole = Product(from_dict(problem.scenario(), name="problem").problem())
    graph = contract(whole)
    assert graph is not None
    table = Backward(whole, graph).cost_to_go(range(len(whole.sizes)))
    table = np.where(table < UNREACHABLE, table.astype(np.int64), INFINITE)
    marks = landmarks(whole, graph)
    found = []
    for each in (marks, repriced(marks, random.Random(seed))):
        states = product(*(range(size) for size in reversed(whole.sizes)))
        for k, automata in enumerate(states):
            for node in range(graph.size):
                reached = np.array(automata[::-1], dtype=np.int64)
                found.append((int(_bound_of(each, node, reached)), int(table[node + graph.size * k])))
    return found


@pytest.mark.parametrize("seed", range(40))
def test_no_state_costs_less_than_its_bound(seed: int) -> None:
    relaxed = seed % 3 == 0
    problem = judge.random_problem(seed, kind="max" if relaxed else "order", tasks=2 + seed % 2, relaxed=relaxed)
    assert all(bound <= cost for bound, cost in bounds_and_costs(problem, seed))


@pytest.mark.parametrize("seed", range(4))
def test_no_state_of_errands_costs_less_than_its_bound_and_many_cost_no_more(seed: int) -> None:
    found = [pair for pair in bounds_and_costs(judge.random_errands(seed, "order"), seed) if pair[1] < INFINITE]
    assert all(bound <= cost for bound, cost in found)
    assert sum(bound == cost > 0 for bound, cost in found) > len(found) / 20


def test_places_on_a_line_are_bounded_exactly() -> None:
    """From the middle of a line to both ends: the bound of single tasks is half that of landmarks."""
    edges = [(i, f"{i} {j}", j, 2) for i in range(9) for j in (i - 1, i + 1) if 0 <= j < 9]
    system = TransitionSystem.from_transitions(edges, start=4, labels={0: ["a"], 8: ["b"], 2: ["c"]})
    problem = Problem(system, [Task("x", "F a"), Task("y", "F (b | (b & c))"), Task("z", "!a U c")], Order())
    whole = Product(problem)
    graph = contract(whole)
    assert graph is not None
    marks = landmarks(whole, graph)
    automata = whole.starts[0].automata
    bound = int(_bound_of(marks, graph.start, np.array(automata))) >> whole.graph.shift
    assert bound * whole.problem.cost_units[0] == Planner(problem).cheapest().cost == 24


def test_a_task_may_name_nothing() -> None:
    system = TransitionSystem.from_transitions([(0, "on", 1, 1)], start=0, labels={1: ["a"]})
    assert Planner(Problem(system, [Task("x", "true"), Task("y", "F a")], Order())).cheapest().cost == 1
