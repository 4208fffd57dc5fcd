"""Scenarios of the benchmark of large models: small ones of the same making have the fronts of whole models."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from experiments.benchmark.large_models import MEASURED, SIZES, Size, scenario, write_measurements
from prefplan import pareto_front
from prefplan.models.manipulation.system import ManipulationSystem
from prefplan.scenario.decode import load, loads


def test_large_scenarios_can_be_read_and_small_ones_solved_state_by_state() -> None:
    for size in SIZES.values():
        assert len(loads(scenario(size)).model.objects) == size.objects  # type: ignore[union-attr]
    small = loads(scenario(Size(3, ((0, 2), (1,)))))
    listed = [(plan.cost, plan.preference) for plan in pareto_front(small.problem())]
    again = replace(small, model=replace(small.model, listed_states=0)).problem()  # type: ignore[call-arg]
    assert isinstance(again.system, ManipulationSystem)
    assert [(plan.cost, plan.preference) for plan in pareto_front(again)] == listed


def test_measurements_are_made_up_for_every_action(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    path.write_text(scenario(next(iter(MEASURED.values()))))
    write_measurements(path)
    system = load(path).problem().system
    names = (system.action_names[action] for action in system.actions)
    costs = {float(system.cost(edge)) for edge, name in enumerate(names) if name == "transport o0 crate"}
    # From four places and two slots, to two slots: 0.2 m to 0.4 m away, from the tray 1 m, each off by up to a fifth.
    assert system.size == 19201 and len(costs) == 12
    assert all(0.8 * 3 <= cost <= 1.2 * 5 or 0.8 * 11 <= cost <= 1.2 * 11 for cost in costs)


def test_measured_costs_of_more_objects_are_planned_with_before_all_states_are_listed(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    path.write_text(scenario(MEASURED["8 objects, 10 locations, 2 tasks about 3 objects, time"]))
    write_measurements(path)
    front = pareto_front(load(path).problem())
    assert front.complete and front.stats.states < 20_000
