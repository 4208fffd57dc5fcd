"""The benchmark's large models: small ones of the same making have the fronts of whole models."""

from __future__ import annotations

from dataclasses import replace

from experiments.benchmark.large_models import MEASURED, SIZES, Size, large_model, large_problem
from prefplan import Problem, pareto_front
from prefplan.models.manipulation.system import ManipulationSystem
from prefplan.preferences.kinds import Order


def test_large_models_can_be_made_and_small_ones_solved_state_by_state() -> None:
    for size in SIZES.values():
        assert len(large_model(size).objects) == size.objects
    size = Size(3, ((0, 2), (1,)))
    small = large_problem(size)
    listed = [(plan.cost, plan.preference) for plan in pareto_front(small)]
    again = Problem(replace(large_model(size), listed_states=0).transition_system(), small.tasks, Order())
    assert isinstance(again.system, ManipulationSystem)
    assert [(plan.cost, plan.preference) for plan in pareto_front(again)] == listed


def test_measurements_are_made_up_for_every_action() -> None:
    system = large_problem(next(iter(MEASURED.values()))).system.listed
    names = (system.action_names[action] for action in system.actions)
    costs = {float(system.cost(edge)) for edge, name in enumerate(names) if name == "transport o0 crate"}
    # From four places and two slots, to two slots: 0.2 m to 0.4 m away, from the tray 1 m, each off by up to a fifth.
    assert system.size == 19201 and len(costs) == 12
    assert all(0.8 * 3 <= cost <= 1.2 * 5 or 0.8 * 11 <= cost <= 1.2 * 11 for cost in costs)


def test_measured_costs_of_more_objects_are_planned_with_before_all_states_are_listed() -> None:
    front = pareto_front(large_problem(MEASURED["8 objects, 10 locations, 2 tasks about 3 objects, time"]))
    assert front.complete and front.stats.states < 20_000
