"""Scenarios of the benchmark of large models: small ones of the same making have the fronts of whole models."""

from __future__ import annotations

import pytest

from experiments.benchmark.large_models import SIZES, Size, scenario
from prefplan import pareto_front
from prefplan.models.manipulation import system
from prefplan.scenario.decode import loads


def test_large_scenarios_can_be_read_and_small_ones_solved_state_by_state(monkeypatch: pytest.MonkeyPatch) -> None:
    for size in SIZES.values():
        assert len(loads(scenario(size)).model.objects) == size.objects  # type: ignore[union-attr]
    small = loads(scenario(Size(3, 3, ((0, 2), (1,)))))
    listed = [(plan.cost, plan.preference) for plan in pareto_front(small.problem())]
    monkeypatch.setattr(system, "LISTED_STATES", 0)
    again = loads(small.text).problem()
    assert again.system.is_large  # type: ignore[attr-defined]
    assert [(plan.cost, plan.preference) for plan in pareto_front(again)] == listed
