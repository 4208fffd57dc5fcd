"""Bounds from projections of a manipulation model, against exact costs-to-go in all its states."""

from __future__ import annotations

import random
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from random_manipulation import random_problem

from prefplan import Options
from prefplan.heuristics import pattern_database, projection
from prefplan.heuristics.backward import Backward
from prefplan.heuristics.prepare import Prepared
from prefplan.models.kernels import INFINITE, UNREACHABLE, kernel
from prefplan.product.product_automaton import Product
from prefplan.product.reduction import GeneratedProduct, product_of


@kernel
def _bound_of(tables: pattern_database.Tables, code: np.int64, states: np.ndarray) -> Any:
    projection.observe(tables.projections, code)
    return pattern_database.bound_of(tables, code, states, np.int64(0))


@pytest.mark.parametrize(("seed", "measured"), [(seed, seed >= 24) for seed in (*range(12), *range(24, 30))])
def test_bounds_are_consistent_and_no_more_than_costs_to_go(
    seed: int, measured: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = random_problem(random.Random(seed), measured=measured, large=True)
    searched = product_of(problem)
    if not isinstance(searched, GeneratedProduct):
        assert any(task.relax for task in problem.tasks)
        return
    # Of measured costs, locations are merged or not.
    monkeypatch.setattr(projection, "APART_ENTRIES", seed % 2 * projection.APART_ENTRIES)
    bounds = Prepared(searched, Options()).bounds
    system = replace(searched.model.listed, propositions=problem.system.propositions)
    listed = Product(problem.over(system))
    tasks = np.arange(len(problem.tasks))
    table = Backward(listed, listed.graph).cost_to_go(tasks.tolist(), np.ones(2 ** len(tasks), dtype=np.int64))
    exact = np.where(table < UNREACHABLE, table.astype(np.int64), INFINITE)
    space = searched.model.space
    codes = np.array([space.encode(state, where="state") for state in system.states])  # type: ignore[arg-type]

    def cost_bound(code: np.int64, states: np.ndarray) -> int:
        return int(_bound_of(bounds.tables, code, states))

    found = np.empty_like(exact)
    for k, automata in enumerate(product(*(range(size) for size in searched.sizes[::-1]))):
        states = np.array(automata[::-1], dtype=np.int64)
        for s in range(system.size):
            bound = cost_bound(codes[s], states)
            found[s + k * system.size] = bound
            for edge in system.edges(s):
                target = int(system.targets[edge])
                after = listed.tables.delta[tasks, states, listed.graph.classes[target]].astype(np.int64)
                step = cost_bound(codes[target], after)
                cost = int(listed.graph.costs[edge]) >> listed.graph.shift
                assert bound <= min(cost + step, INFINITE)
    assert (found <= exact).all()
    assert found[exact < INFINITE].any() or not exact[exact < INFINITE].any()
