"""Tables of larger sets, which only long searches for one plan call for: nothing may be lost by them."""

from __future__ import annotations

import math

import judge
import pytest
from judge.enumerate import cheapest_cost, exact_front
from judge.verdict import misjudged

from prefplan import cheapest_plan
from prefplan.heuristics import preprocessing
from prefplan.scenario.decode import from_dict
from prefplan.search import driver


def test_tables_deepened_in_mid_search_lose_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    deepened: list[int] = []
    deepen = preprocessing.Prepared.deepen

    def noted(self: preprocessing.Prepared) -> None:
        deepen(self)
        deepened.append(self.bounds.patterns.sets.tasks.shape[1])

    monkeypatch.setattr(preprocessing.Prepared, "deepen", noted)
    monkeypatch.setattr(preprocessing, "pattern_size", lambda backward, wanted, *, single, max_entries: 1)
    monkeypatch.setattr(preprocessing, "EXPANSION", math.inf)
    monkeypatch.setattr(driver.Search, "pops", 1)
    for seed in range(60):
        problem = judge.random_problem(seed, tasks=3)
        least = cheapest_cost(problem)
        if least is not None:
            plan = cheapest_plan(from_dict(problem.scenario()).problem())
            assert (plan.cost, plan.preference) == exact_front(problem, max_cost=least)[0], seed
            assert misjudged(problem, plan) is None, seed
    assert set(deepened) == {2, 3}
