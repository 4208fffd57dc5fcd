"""The max-min heuristic (equation 4): Lemma 1, consistency, and the compiled tables of single tasks."""

from __future__ import annotations

import math
from itertools import pairwise

import networkx
import pytest
from judge.random_problems import random_errands, random_problem

from prefplan.heuristics.backward import Backward
from prefplan.heuristics.cost_to_go import max_min, task_distances
from prefplan.models.kernels import UNREACHABLE
from prefplan.product.product_automaton import Product
from prefplan.scenario.decode import from_dict

State = tuple[int, ...]


def random_product(seed: int, *, relaxed: bool = False) -> Product:
    drawn = random_errands(seed, "order") if seed % 3 == 0 else random_problem(seed, relaxed=relaxed)
    if relaxed:
        drawn = random_problem(seed, kind="weighted-sum", relaxed=True)
    return Product(from_dict(drawn.scenario()).problem())


def steps_of(product: Product) -> networkx.DiGraph:
    """Return the reachable product states and the cost of each step (Definition 7), without relaxations."""
    steps, waiting = networkx.DiGraph(), [(product.graph.start, *start.automata) for start in product.starts]
    while waiting:
        state = waiting.pop()
        if state in steps and steps.nodes[state]:
            continue
        steps.add_node(state, expanded=True)
        for edge in product.problem.system.edges(state[0]):
            target = int(product.graph.targets[edge])
            label = product.graph.classes[target]
            after = (target, *(int(product.tables.delta[i, q, label]) for i, q in enumerate(state[1:])))
            known = steps.get_edge_data(state, after, {"cost": math.inf})["cost"]
            steps.add_edge(state, after, cost=min(known, int(product.graph.costs[edge])))
            waiting.append(after)
    return steps


@pytest.mark.parametrize("seed", range(30))
def test_it_is_admissible_and_consistent(seed: int) -> None:
    product = random_product(seed)
    distances, steps = task_distances(product, product.graph.costs.tolist()), steps_of(product)
    h = {state: max_min(distances, state) for state in steps}
    accepting = [dfa.automaton.accepting for dfa in product.automata]
    goals = {state for state in steps if list(state[1:]) == accepting}
    cost_to_go = {}
    if goals:
        cost_to_go = networkx.multi_source_dijkstra_path_length(steps.reverse(), goals, weight="cost")
    assert all(h[state] <= cost_to_go.get(state, math.inf) for state in steps)
    assert all(h[before] <= cost + h[after] for before, after, cost in steps.edges(data="cost"))
    assert all(h[goal] == 0 for goal in goals)


def test_a_plan_for_one_task_costs_what_it_says() -> None:
    product = random_product(3)
    distances, steps = task_distances(product, product.graph.costs.tolist()), steps_of(product)
    accepting = product.automata[0].automaton.accepting
    start = (product.graph.start, *product.starts[0].automata)
    costs, paths = networkx.single_source_dijkstra(steps, start, weight="cost")
    goal = min((state for state in costs if state[1] == accepting), key=costs.__getitem__)
    left = [distances[0][state[0], state[1]] for state in paths[goal]]
    assert left[0] == costs[goal] > 0 and left[-1] == 0
    paid = [steps.edges[pair]["cost"] for pair in pairwise(paths[goal])]
    assert [before - after for before, after in pairwise(left)] == paid


@pytest.mark.parametrize("seed", range(40))
def test_compiled_tables_of_single_tasks_are_the_same(seed: int) -> None:
    product = random_product(seed, relaxed=seed % 2 == 0)
    backward = Backward(product, product.graph)
    for task, distances in enumerate(task_distances(product, product.graph.costs.tolist())):
        table = backward.cost_to_go([task])
        cells = [(s, q) for q in range(product.sizes[task]) for s in range(product.graph.size)]
        assert table.tolist() == [distances.get(cell, UNREACHABLE) for cell in cells]
