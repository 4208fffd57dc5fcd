"""Bounds that only long searches call for, put to use from the first goal on: nothing may be lost by them."""

from __future__ import annotations

import judge
import pytest
from judge.verdict import verdict

from prefplan import Options
from prefplan.heuristics import preprocessing


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
        options = [
            Options(contraction=c, budget_after=-1, pause_after=1) for c in (True, False)
        ]  # from the first goal on
        assert verdict(problem, options) is None, seed
    assert len(budgets) > 40
