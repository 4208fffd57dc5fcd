"""Scenarios of the benchmark of large models: small ones of the same making have the fronts of whole models."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments.benchmark.large_models import MEASURED, SIZES, Size, scenario, write_measurements
from prefplan import pareto_front
from prefplan.models.manipulation import system
from prefplan.scenario.decode import load, loads


def test_large_scenarios_can_be_read_and_small_ones_solved_state_by_state(monkeypatch: pytest.MonkeyPatch) -> None:
    for size in SIZES.values():
        assert len(loads(scenario(size)).model.objects) == size.objects  # type: ignore[union-attr]
    small = loads(scenario(Size(3, 3, ((0, 2), (1,)))))
    listed = [(plan.cost, plan.preference) for plan in pareto_front(small.problem())]
    monkeypatch.setattr(system, "LISTED_STATES", 0)
    again = loads(small.text).problem()
    assert again.system.is_large  # type: ignore[attr-defined]
    assert [(plan.cost, plan.preference) for plan in pareto_front(again)] == listed


def test_measurements_are_made_up_for_every_action(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    path.write_text(scenario(next(iter(MEASURED.values()))))
    write_measurements(path)
    system = load(path).problem().system
    names = (system.action_names[action] for action in system.actions)
    costs = {
        int(cost) * system.unit for name, cost in zip(names, system.costs, strict=True) if name == "transport o0 crate"
    }
    # From p0 to p2, 0.2 m to 0.3 m away, and from the tray, 1 m away.
    assert system.size == 1921 and costs == {3, 4, 11}
