"""Which sets of tasks have tables: any two tasks share one, unless the tables would be too large."""

from __future__ import annotations

import math
from itertools import combinations

import judge
import numpy as np
import pytest
from judge.enumerate import cheapest_cost, exact_front
from judge.verdict import misjudged

from prefplan import GridModel, Options, Order, Problem, Task, cheapest_plan
from prefplan.heuristics import pattern_database, prepare
from prefplan.heuristics.backward import Backward
from prefplan.heuristics.pattern_database import joined_groups, sets_of_tasks
from prefplan.product.contraction import contract
from prefplan.product.product_automaton import Product
from prefplan.scenario.decode import from_dict

PAIRS, ALL = [*combinations(range(3), 2)], [(0, 1, 2)]


def test_any_two_tasks_are_in_one_of_the_sets_of_joined_groups() -> None:
    for tasks in range(2, 9):
        for groups in range(2, tasks + 1):
            sets = joined_groups(tasks, groups)
            assert all(any({i, j} <= {*one} for one in sets) for i in range(tasks) for j in range(tasks))
            assert len(sets) == math.comb(groups, 2)


@pytest.mark.parametrize("sweep", [True, False])
def test_tables_are_as_large_as_their_filling_allows(sweep: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten tasks of five states: three more in a set take 125 times as many entries."""
    cells = {f"c{k}": [(k % 10, k // 10) * 2] for k in range(30)}
    tasks = [Task(f"t{k}", f"F (c{3 * k} & F c{3 * k + 1} & F c{3 * k + 2})") for k in range(10)]
    product = Product(Problem(GridModel((10, 10), (9, 9), regions=cells).transition_system(), tasks, Order()))
    graph = contract(product)
    assert graph is not None
    backward = Backward(product, graph, sweep=sweep)
    assert backward.is_swept is sweep
    largest = max(map(len, sets_of_tasks(backward, None, math.inf)))
    assert largest == (6 if sweep else 4)
    assert max(map(len, sets_of_tasks(backward, None, math.inf, deep=True))) == (7 if sweep else 4)
    assert sets_of_tasks(backward, None, 20_000) == [(i,) for i in range(10)]
    assert sets_of_tasks(backward, 2, 0) == [*combinations(range(10), 2)]
    assert sets_of_tasks(backward, 0, math.inf) == []
    name = "SWEPT_ENTRIES" if sweep else "SEARCHED_ENTRIES"
    monkeypatch.setattr(pattern_database, name, graph.size * 5**3)
    sets = sets_of_tasks(backward, None, math.inf)
    assert {2, 3} == {len(one) for one in sets}
    assert all(any({*pair} <= {*one} for one in sets) for pair in combinations(range(10), 2))


@pytest.mark.parametrize(("first", "deeper"), [(PAIRS, ALL), ([(0,), (1,), (2,)], PAIRS)])
def test_tables_deepened_in_mid_search_lose_nothing(
    monkeypatch: pytest.MonkeyPatch, first: list[tuple[int, ...]], deeper: list[tuple[int, ...]]
) -> None:
    deepened: list[int] = []
    improve = prepare.Prepared.improve

    def noted(self: prepare.Prepared, lowest: int) -> None:
        improve(self, lowest)
        tables = self.bounds.tables
        deepened.append(int(np.count_nonzero(tables.strides[tables.objective == 0], axis=1).max()))

    monkeypatch.setattr(prepare.Prepared, "improve", noted)
    monkeypatch.setattr(prepare, "ENTRIES_EACH", math.inf)
    monkeypatch.setattr(prepare, "sets_of_tasks", lambda *given, deep=False: deeper if deep else first)
    for seed in range(60):
        problem = judge.random_problem(seed, tasks=3)
        least = cheapest_cost(problem)
        if least is not None:
            plan = cheapest_plan(from_dict(problem.scenario()).problem(), options=Options(landmarks=False))
            assert (plan.cost, plan.preference) == exact_front(problem, max_cost=least)[0], seed
            assert misjudged(problem, plan) is None, seed
    assert set(deepened) == {len(deeper[0])}
