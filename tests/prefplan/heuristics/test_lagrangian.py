"""Bounds of cost and mu together: against exact weighted sums, and fronts that are found with them."""

from __future__ import annotations

import random
from itertools import product

import judge
import numpy as np
import pytest
from judge.verdict import verdict

from prefplan import Options, Planner
from prefplan.heuristics import preprocessing
from prefplan.heuristics.cost_to_go import Backward
from prefplan.heuristics.lagrangian import Weights, lagrangian_bound, weights_along, with_table, without_tables
from prefplan.product.contraction import contract
from prefplan.product.kernels import INFINITE
from prefplan.product.product_automaton import Product
from prefplan.product.product_view import view
from prefplan.scenario.decode import from_dict
from prefplan.search import bi_objective_search

AT_ONCE = Options(drafted_tasks=1, table_effort=0, pops=1)
"""Tables are filled as soon as may be."""


@pytest.mark.parametrize("unit", [1, 3])
def test_bounds_are_those_of_the_least_weighted_sums_or_less(unit: int) -> None:
    looked_up = tight = 0
    for seed in range(30):
        rng = random.Random(seed)
        problem = judge.random_problem(seed, kind="order", tasks=2 + seed % 2, decimals=seed % 3 == 0)
        whole = Product(from_dict(problem.scenario()).problem())
        graph = contract(whole)
        assert graph is not None
        back, weights = Backward(whole, view(whole, graph)), Weights(rng.randint(1, 5), rng.randint(1, 5), unit)
        if back.stages is None:
            continue
        tables = with_table(without_tables(back.stages), back.stages, whole.rates, whole.shift, weights)
        tasks = np.arange(len(whole.sizes))
        least = back.cost_to_go(tasks, weights.cost + weights.mu * whole.rates, shift=whole.shift)
        for k, states in enumerate(product(*(range(size) for size in reversed(whole.sizes)))):
            automata = np.array(states[::-1])
            for node in range(graph.size):
                after = np.array([whole.delta[i, q, graph.classes[node]] for i, q in enumerate(automata)])
                if (after != automata).any():
                    # A search may come here, so that there is an entry.
                    assert (tables.place[node, tasks, after] >= 0).all()
                bound, total = lagrangian_bound(tables, node, automata, 0), least[node + graph.size * k]
                growth = rng.randrange(20)
                within = lagrangian_bound(tables, node, automata, growth)
                assert within <= max(0, bound - growth * weights.mu // weights.cost)
                assert weights.cost * (bound - 1) < total
                if 0 < total < INFINITE and (tables.place[node, tasks, automata] >= 0).all():
                    looked_up += 1
                    tight += weights.cost * bound >= total
    assert looked_up > 200
    assert tight > looked_up * (0.9 if unit == 1 else 0.1)


def test_weights_are_the_same_for_both_ends() -> None:
    for begin, end in [((60, 22), (83, 0)), ((10, 9000), (13, 2)), ((10, 9), (70000, 2))]:
        weights = weights_along(begin, end)
        assert weights is not None
        dearer, better = weights.cost * (end[0] - begin[0]), weights.mu * (begin[1] - end[1])
        assert dearer == pytest.approx(better, rel=0.1)
        assert weights.cost * end[0] + weights.mu * begin[1] < 2 * 30_000 * weights.unit
    assert weights_along((5, 5), (7, 5)) is None


@pytest.fixture
def tabulated(monkeypatch: pytest.MonkeyPatch) -> list[Weights]:
    """Tables that are filled for any weights."""
    found: list[Weights] = []
    weigh = preprocessing.Prepared.weigh

    def noted(self: preprocessing.Prepared, weights: Weights) -> None:
        weigh(self, weights)
        found.append(weights)

    rng = random.Random(0)
    monkeypatch.setattr(preprocessing.Prepared, "weigh", noted)
    monkeypatch.setattr(
        bi_objective_search,
        "weights_along",
        lambda begin, end: Weights(rng.randint(1, 5), rng.randint(1, 5), rng.randint(1, 2)),
    )
    return found


@pytest.mark.parametrize("kind", ["order", "weighted-sum", "sum"])
def test_fronts_found_with_tables_lose_nothing(kind: str, tabulated: list[Weights]) -> None:
    for seed in range(12):
        problem = judge.random_problem(seed, kind=kind, tasks=3, decimals=seed % 3 == 0)
        assert verdict(problem, [AT_ONCE]) is None, seed
    assert len(tabulated) > 6


def test_fronts_within_some_percent_that_are_found_with_tables_leave_nothing_out(tabulated: list[Weights]) -> None:
    for seed in range(8):
        problem = judge.random_problem(seed, kind="order", tasks=3)
        planned = from_dict(problem.scenario()).problem()
        for plan in Planner(planned, options=AT_ONCE).front():
            near = Planner(planned, options=AT_ONCE).front(within=5)
            assert any(a.cost <= 1.05 * plan.cost and a.preference <= 1.05 * plan.preference for a in near), seed
    assert tabulated
