"""Bounds that only long searches call for, put to use from the first goal on: nothing may be lost by them."""

from __future__ import annotations

import judge
import pytest
from judge.enumerate import cheapest_cost, exact_front
from judge.verdict import misjudged, verdict

from prefplan import Options, cheapest_plan
from prefplan.heuristics import preprocessing
from prefplan.scenario.decode import from_dict


@pytest.fixture
def budgets(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The values to improve on for which costs-to-go are tabulated."""
    tabulated: list[int] = []
    bound_growth = preprocessing.Prepared.bound_growth

    def noted(self: preprocessing.Prepared, mu: int) -> None:
        bound_growth(self, mu)
        if len(self.budgeted.budgets) > 1:
            tabulated.append(mu)

    monkeypatch.setattr(preprocessing.Prepared, "bound_growth", noted)
    return tabulated


@pytest.mark.parametrize("kind", ["order", "weighted-sum", "sum"])
def test_bounds_under_budgets_lose_nothing(kind: str, budgets: list[int]) -> None:
    for seed in range(60):
        problem = judge.random_problem(seed, kind=kind, tasks=3, decimals=seed % 3 == 0)
        ways = [Options(contraction=c, budget_after=-1, pause_after=1) for c in (True, False)]  # from the first goal on
        assert verdict(problem, ways) is None, seed
    assert len(budgets) > 40


def test_bounds_that_are_deepened_lose_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    deepened: list[int] = []
    deepen = preprocessing.Prepared.deepen

    def noted(self: preprocessing.Prepared) -> None:
        deepen(self)
        deepened.append(self.patterns.tasks.shape[1])

    monkeypatch.setattr(preprocessing.Prepared, "deepen", noted)
    at_once = Options(heuristic=1, deepen_after=0)
    for seed in range(60):
        problem = judge.random_problem(seed, tasks=3)
        least = cheapest_cost(problem)
        if least is not None:
            plan = cheapest_plan(from_dict(problem.scenario()).problem(), options=at_once)
            assert (plan.cost, plan.preference) == exact_front(problem, max_cost=least)[0], seed
            assert misjudged(problem, plan) is None, seed
    assert set(deepened) == {2, 3}
