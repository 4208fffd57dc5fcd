"""Tables of the cost-to-go, against shortest paths in an explicit T x A_K."""

from __future__ import annotations

import random
from itertools import combinations, product

import networkx
import numpy as np
import pytest
from judge.random_problems import random_problem

from prefplan import Order, Problem, Task, TransitionSystem
from prefplan.heuristics.backward import Backward
from prefplan.models.kernels import NO_EDGE, UNREACHABLE
from prefplan.product.contraction import Graph, contract
from prefplan.product.product_automaton import Product
from prefplan.scenario.decode import from_dict


def random_product(seed: int, *, sweep: bool = True) -> tuple[Product, Graph, Backward]:
    """Return a random product over a contracted graph, and its backward tables."""
    whole = Product(from_dict(random_problem(seed).scenario()).problem())
    graph = contract(whole)
    assert graph is not None
    return whole, graph, Backward(whole, graph, sweep=sweep)


def never_loses(whole: Product) -> bool:
    """Return whether reading a label never leads an automaton to a state that is worse than the one before.

    A state is no worse than another if it is an end whenever the other is, and every label leads from it to a state no
    worse than from the other (the greatest simulation).
    """
    for i, size in enumerate(whole.sizes.tolist()):
        after = whole.tables.delta[i, :size]
        ends = np.isin(np.arange(size), whole.tables.ends[i])
        no_worse, before = ends[:, None] >= ends[None, :], None
        while before is None or (no_worse < before).any():
            before = no_worse.copy()
            for label in after.T:
                no_worse &= before[label[:, None], label[None, :]]
        if not no_worse[after, np.arange(size)[:, None]].all():
            return False
    return True


def shortest(
    whole: Product, graph: Graph, tasks: tuple[int, ...], factors: np.ndarray, *, shift: int = 0
) -> np.ndarray:
    """Return the table that `cost_to_go` should give, by Dijkstra over all states of T x A_K."""
    done = [{*whole.tables.ends[i].tolist()} - {-1} for i in tasks]
    steps = networkx.DiGraph()
    steps.add_node("goal")
    for automata in product(*(range(whole.sizes[i]) for i in tasks)):
        satisfied = sum(1 << j for j, i in enumerate(tasks) if automata[j] == whole.tables.ends[i, 0])
        for state in range(len(whole.graph.classes)):
            if all(q in ends for q, ends in zip(automata, done, strict=True)):
                steps.add_edge("goal", (state, automata), weight=0)
            for edge in range(whole.graph.offsets[state], whole.graph.offsets[state + 1]):
                label = whole.graph.classes[whole.graph.targets[edge]]
                after = tuple(int(whole.tables.delta[i, q, label]) for i, q in zip(tasks, automata, strict=True))
                cost = int(factors[satisfied]) * (int(whole.graph.costs[edge]) >> shift)
                there, here = (int(whole.graph.targets[edge]), after), (state, automata)
                least = min(cost, steps.get_edge_data(there, here, {"weight": cost})["weight"])
                steps.add_edge(there, here, weight=least)
    lengths = networkx.single_source_dijkstra_path_length(steps, "goal")
    # In the table the node is what changes fastest, then the first task's automaton.
    return np.array(
        [
            lengths.get((int(state), automata[::-1]), UNREACHABLE)
            for automata in product(*(range(whole.sizes[i]) for i in reversed(tasks)))
            for state in graph.states
        ]
    )


@pytest.mark.parametrize("seed", range(40))
def test_costs_and_growths_to_go_are_least(seed: int) -> None:
    rng = random.Random(seed)
    whole, graph, back = random_product(seed, sweep=False)
    for k in range(1, min(3, len(whole.sizes)) + 1):
        for tasks in combinations(range(len(whole.sizes)), k):
            ones = np.ones(2**k, dtype=np.int64)
            assert (back.cost_to_go(tasks) == shortest(whole, graph, tasks, ones)).all()
            rates = np.array([rng.randrange(4) for _ in range(2**k)], dtype=np.int64)
            expected = shortest(whole, graph, tasks, rates, shift=whole.graph.shift)
            assert (back.cost_to_go(tasks, rates) == expected).all()


@pytest.mark.parametrize("seed", range(60))
def test_swept_costs_are_exact_and_swept_growths_consistent_bounds(seed: int) -> None:
    """Growths are exact where satisfying tasks never makes mu grow faster; both are bounds where labels do harm."""
    rng = random.Random(seed)
    whole, graph, back = random_product(seed)
    _, _, exact = random_product(seed, sweep=False)
    for k in range(1, min(3, len(whole.sizes)) + 1 if back.is_swept else 1):
        for tasks in combinations(range(len(whole.sizes)), k):
            falling = np.array([k - s.bit_count() for s in range(2**k)], dtype=np.int64)
            for factors in (np.ones(2**k, dtype=np.int64), falling):
                costs, least = back.cost_to_go(tasks, factors), exact.cost_to_go(tasks, factors)
                assert (costs == least).all() if never_loses(whole) else (costs <= least).all()
            rates = np.array([rng.randrange(4) for _ in range(2**k)], dtype=np.int64)
            growths = back.cost_to_go(tasks, rates)
            assert (growths <= exact.cost_to_go(tasks, rates)).all()
            assert is_consistent(whole, graph, tasks, rates, growths)


def is_consistent(whole: Product, graph: Graph, tasks: tuple[int, ...], factors: np.ndarray, table: np.ndarray) -> bool:
    """Return whether entries fall along no edge of a contracted graph by more than its weighted cost."""
    sizes = [int(whole.sizes[i]) for i in tasks]
    known = table.reshape(*reversed(sizes), graph.size)
    for automata in product(*map(range, sizes)):
        satisfied = sum(1 << j for j, i in enumerate(tasks) if automata[j] == whole.tables.ends[i, 0])
        for node, target in product(range(graph.size), repeat=2):
            if graph.near[node, target] == NO_EDGE:
                continue
            label = graph.classes[target]
            after = tuple(int(whole.tables.delta[i, q, label]) for i, q in zip(tasks, automata, strict=True))
            cost = int(factors[satisfied]) * (int(graph.near[node, target]) >> whole.graph.shift)
            if known[(*automata[::-1], node)] > cost + known[(*after[::-1], target)]:
                return False
    return True


@pytest.mark.parametrize("seed", range(60))
def test_tables_hold_the_least_costs_in_32_bits(seed: int) -> None:
    _, _, back = random_product(seed)
    for k in range(1, len(back.sizes) + 1):
        for tasks in combinations(range(len(back.sizes)), k):
            costs, factor = back.cost_to_go(tasks, np.ones(2**k, dtype=np.int64)).astype(np.int64), 2**27
            table = back.cost_to_go(tasks, np.full(2**k, factor))
            assert table.dtype == np.int32
            assert (
                table == np.where(costs < UNREACHABLE, np.minimum(costs * factor, UNREACHABLE - 1), UNREACHABLE)
            ).all()


def test_random_products_have_automata_of_either_kind() -> None:
    products = [random_product(seed)[2] for seed in range(60)]
    assert sum(back.stages is None for back in products) >= 3
    assert sum(back.stages is not None and not back.is_swept for back in products) >= 10
    assert sum(back.is_swept for back in products) >= 10


@pytest.mark.parametrize(
    ("formula", "swept"),
    [
        ("F (a & F b)", True),
        ("F a & F b", True),
        ("(!b U a) | F (b & F (a & X true))", True),
        ("!b U a", False),
        ("(!b U a) | F (b & F c)", False),
        ("F (a & X b)", False),
    ],
)
def test_tables_are_swept_where_no_label_makes_it_impossible_to_satisfy_a_task(formula: str, swept: bool) -> None:
    edges = [("s", "on", "t", 1), ("t", "on", "s", 1)]
    system = TransitionSystem.from_transitions(edges, start="s", labels={"s": ["a"], "t": ["b"]}, propositions=["c"])
    whole = Product(Problem(system, [Task("x", formula)], Order()))
    graph = contract(whole)
    assert graph is not None and Backward(whole, graph).is_swept is swept
