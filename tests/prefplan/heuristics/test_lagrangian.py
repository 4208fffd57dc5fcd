"""Bounds of cost and mu together: against exact weighted sums, and fronts that are found with them."""

from __future__ import annotations

import math
import random
from itertools import product
from typing import Any

import judge
import numpy as np
import pytest
from judge.planners import PLANNERS
from judge.verdict import verdict

from prefplan.heuristics import lagrangian, prepare
from prefplan.heuristics.backward import Backward
from prefplan.heuristics.lagrangian import (
    LARGEST,
    Lagrangian,
    Weights,
    lagrangian_table,
    sparse_layout,
    weights_for,
)
from prefplan.models.kernels import INFINITE, UNREACHABLE, kernel
from prefplan.product.contraction import contract
from prefplan.product.product_automaton import Product
from prefplan.scenario.decode import from_dict


@kernel
def _bound_of(table: Lagrangian, node: int, automata: np.ndarray, growth: int) -> Any:
    return lagrangian.lagrangian_bound(table, node, automata, growth)


@pytest.mark.parametrize("unit", [1, 3])
def test_bounds_are_those_of_the_least_weighted_sums_or_less(unit: int) -> None:
    looked_up = tight = 0
    for seed in range(30):
        rng = random.Random(seed)
        problem = judge.random_problem(seed, kind="order", tasks=2 + seed % 2, decimals=seed % 3 == 0)
        whole = Product(from_dict(problem.scenario()).problem())
        graph = contract(whole)
        assert graph is not None
        back, weights = Backward(whole, graph), Weights(rng.randint(1, 5), rng.randint(1, 5), unit)
        if back.stages is None:
            continue
        rates = whole.problem.measure.rates(whole.problem.measure.rate_terms)
        tables = lagrangian_table(back.stages, sparse_layout(back.stages), rates, weights)
        tasks, factors = np.arange(len(whole.sizes)), weights.cost + weights.mu * rates
        least = Backward(whole, graph, sweep=False).cost_to_go(tasks.tolist(), factors)
        for k, states in enumerate(product(*(range(size) for size in reversed(whole.sizes)))):
            automata = np.array(states[::-1])
            for node in range(graph.size):
                after = np.array([whole.tables.delta[i, q, graph.classes[node]] for i, q in enumerate(automata)])
                if (after != automata).any():
                    # A search may come here, so that there is an entry.
                    assert (tables.layout.place[node, tasks, after] >= 0).all()
                bound, total = _bound_of(tables, node, automata, 0), least[node + graph.size * k]
                growth = rng.randrange(20)
                within = _bound_of(tables, node, automata, growth)
                assert within <= max(0, bound - growth * weights.mu // weights.cost)
                assert weights.cost * (bound - 1) < total
                if 0 < total < UNREACHABLE and (tables.layout.place[node, tasks, automata] >= 0).all():
                    looked_up += 1
                    tight += weights.cost * bound >= total
    assert looked_up > 200
    assert tight > looked_up * (0.9 if unit == 1 else 0.1)


def test_weights_do_not_depend_on_the_units_of_cost_and_mu() -> None:
    rates = np.array([0, 3, 1, 4])
    weights = weights_for(rates, cost=100)
    assert weights == (1, 1, 1)
    assert weights_for(rates, cost=10**7) == (1, 1, 3 * 10**7 // LARGEST + 1)
    assert weights_for(1000 * rates, cost=100) == (1000, 1, 300_000 // LARGEST + 1)
    assert weights_for(np.zeros(4, dtype=np.int64), cost=100) is None
    assert weights_for(rates, cost=INFINITE) is None


@pytest.fixture
def tabulated(monkeypatch: pytest.MonkeyPatch) -> list[Weights]:
    """Tables that are filled at once, for any weights."""
    found: list[Weights] = []
    rng = random.Random(0)

    def drawn(rates: np.ndarray, cost: int) -> Weights:
        found.append(Weights(rng.randint(1, 5), rng.randint(1, 5), rng.randint(1, 2)))
        return found[-1]

    monkeypatch.setattr(prepare, "weights_for", drawn)
    monkeypatch.setattr(prepare, "COMBINATIONS_EACH", math.inf)
    return found


@pytest.mark.parametrize("kind", ["order", "weighted-sum", "sum"])
def test_fronts_found_with_tables_lose_nothing(kind: str, tabulated: list[Weights]) -> None:
    for seed in range(24):
        problem = judge.random_problem(seed, kind=kind, tasks=3, decimals=seed % 3 == 0)
        assert verdict(problem, PLANNERS[:1]) is None, seed
    assert len(tabulated) > 6
