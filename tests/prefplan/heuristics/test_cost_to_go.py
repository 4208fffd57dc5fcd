"""Tables of the cost-to-go, against shortest paths in T x A_K written out."""

from __future__ import annotations

import random
from itertools import combinations, product

import networkx
import numpy as np
import pytest
from judge.random_problems import random_problem

from prefplan.heuristics.cost_to_go import Backward, cost_to_go, growth_to_go
from prefplan.heuristics.preprocessing import Options, Prepared
from prefplan.product.contraction import Graph, contract, view
from prefplan.product.product_automaton import Product
from prefplan.product.successors import INFINITE
from prefplan.scenario.decode import from_dict


def random_product(seed: int) -> tuple[Product, Graph, Backward]:
    """Return a random product over a contracted graph, and what it looks like backward."""
    some = Product(from_dict(random_problem(seed).scenario()).problem())
    graph = contract(some)
    assert graph is not None
    return some, graph, Backward(some, view(some, graph))


def shortest(some: Product, graph: Graph, tasks: tuple[int, ...], factors: np.ndarray, *, shift: int = 0) -> np.ndarray:
    """Return the table that `cost_to_go` should give, by Dijkstra over all states of T x A_K."""
    done = [{int(some.accepting[i]), int(some.skipped[i])} - {-1} for i in tasks]
    steps = networkx.DiGraph()
    steps.add_node("goal")
    for automata in product(*(range(some.sizes[i]) for i in tasks)):
        satisfied = sum(1 << j for j, i in enumerate(tasks) if automata[j] == some.accepting[i])
        for state in range(len(some.classes)):
            if all(q in ends for q, ends in zip(automata, done, strict=True)):
                steps.add_edge("goal", (state, automata), weight=0)
            for edge in range(some.offsets[state], some.offsets[state + 1]):
                label = some.classes[some.targets[edge]]
                after = tuple(int(some.delta[i, q, label]) for i, q in zip(tasks, automata, strict=True))
                cost = int(factors[satisfied]) * (int(some.costs[edge]) >> shift)
                there, here = (int(some.targets[edge]), after), (state, automata)
                least = min(cost, steps.get_edge_data(there, here, {"weight": cost})["weight"])
                steps.add_edge(there, here, weight=least)
    lengths = networkx.single_source_dijkstra_path_length(steps, "goal")
    # In the table the node is what changes fastest, then the first task's automaton.
    return np.array(
        [
            lengths.get((int(state), automata[::-1]), INFINITE[np.int32])
            for automata in product(*(range(some.sizes[i]) for i in reversed(tasks)))
            for state in graph.states
        ]
    )


@pytest.mark.parametrize("seed", range(40))
def test_costs_and_growths_to_go_are_least(seed: int) -> None:
    rng = random.Random(seed)
    some, graph, back = random_product(seed)
    for k in range(1, min(3, len(some.sizes)) + 1):
        for tasks in combinations(range(len(some.sizes)), k):
            members = np.array(tasks, dtype=np.int64)
            ones = np.ones(2**k, dtype=np.int64)
            assert (cost_to_go(back, members, np.int32)[0] == shortest(some, graph, tasks, ones)).all()
            rates = np.array([rng.randrange(4) for _ in range(2**k)], dtype=np.int64)
            expected = shortest(some, graph, tasks, rates, shift=some.shift)
            assert (growth_to_go(back, members, np.int32, rates) == expected).all()


def test_random_products_have_automata_of_either_kind() -> None:
    kinds = [random_product(seed)[2].stages is not None for seed in range(40)]
    assert kinds.count(True) >= 10
    assert kinds.count(False) >= 3


def test_wide_tables_say_what_narrow_ones_do() -> None:
    unreachable = 0
    for seed in range(10):
        narrow = Prepared(Product(from_dict(random_problem(seed).scenario()).problem()), Options(), single=False)
        tables = narrow.patterns.table, narrow.blocks.table
        assert narrow.dtype is np.int32
        narrow.widen()
        for before, after in zip(tables, (narrow.patterns.table, narrow.blocks.table), strict=True):
            far = before == INFINITE[np.int32]
            unreachable += np.count_nonzero(far)
            assert (after[~far] == before[~far]).all()
            assert (after[far] == INFINITE[np.int64]).all()
    assert unreachable
