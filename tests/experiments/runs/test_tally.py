"""Books and captions of executions, on made-up observations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from scenario_texts import RELAXED_CUP

from experiments import scenarios
from experiments.runs.captions import captions
from experiments.runs.tally import Tally, tally
from prefplan import ManipulationModel, ManipulationState, Plan, Scenario, load, pareto_front
from sim.robots.panda import PANDA
from sim.simulation.rollout import Event, Rollout, Step


def steps_of(scenario: Scenario, plan: Plan, states: Sequence[ManipulationState]) -> tuple[Step, ...]:
    """Return a plan's actions, one a second, after which these states are observed."""
    expected = cast(tuple[ManipulationState, ...], plan.states)
    together = enumerate(zip(plan.actions, expected[1:], states[1:], strict=True))
    costs = cast(ManipulationModel, scenario.model).costs
    return tuple(
        Step(action, k, k + 1, predicted, seen, costs[action.split()[0]]) for k, (action, predicted, seen) in together
    )


def books_of(scenario: Scenario, plan: Plan, states: Sequence[ManipulationState] | None = None) -> Tally:
    """Return the tally of a plan that goes well, or as observed."""
    seen = states or cast(tuple[ManipulationState, ...], plan.states)
    return tally(scenario.problem(), plan, steps_of(scenario, plan, seen))


@pytest.fixture(scope="module")
def arch() -> Scenario:
    return scenarios.find("case_study_3")


@pytest.fixture(scope="module")
def front(arch: Scenario) -> list[Plan]:
    return list(pareto_front(arch.problem()))


@pytest.fixture
def relaxed(tmp_path: Path) -> Scenario:
    path = tmp_path / "relaxed.toml"
    path.write_text(RELAXED_CUP)
    return load(path)


def test_what_is_observed_has_the_labels_of_the_model(arch: Scenario) -> None:
    system = arch.problem().system
    for state in range(0, system.size, 7):
        assert cast(ManipulationState, system.states[state]).label == system.label(state)


def test_a_plan_that_goes_well_costs_what_was_planned(arch: Scenario, front: list[Plan]) -> None:
    for plan in front:
        books = books_of(arch, plan)
        assert books.cost == plan.cost
        assert {name: books.task_cost(name) for name in plan.task_costs} == plan.task_costs


def test_relaxations_are_granted_and_skipped_tasks_never_satisfied(relaxed: Scenario) -> None:
    front = pareto_front(relaxed.problem())
    assert [plan.preference for plan in front] == [9, 0]
    for plan in front:
        books = books_of(relaxed, plan)
        assert books.cost == plan.cost
        assert {name: books.task_cost(name) for name in plan.task_costs} == plan.task_costs
    skipped = books_of(relaxed, front[0])
    assert skipped.satisfied[-1] == {"serve"}


def test_decimal_costs_add_up_exactly(relaxed: Scenario) -> None:
    assert books_of(relaxed, pareto_front(relaxed.problem())[0]).costs == (0, 0.5, 0.6, 1.3, 1.5)


def test_a_task_counts_only_when_it_is_seen_to_be_done(arch: Scenario, front: list[Plan]) -> None:
    plan = front[0]
    states = [replace(cast(ManipulationState, state), marks=frozenset()) for state in plan.states]
    books = books_of(arch, plan, states)
    assert books.satisfied[-1] == frozenset()
    assert books.task_cost("phi1") == books.task_cost("phi2") == plan.cost


def test_captions_show_the_books_before_each_action_and_at_the_end(arch: Scenario, front: list[Plan]) -> None:
    plan = front[1]
    books = books_of(arch, plan)
    steps = steps_of(arch, plan, cast(tuple[ManipulationState, ...], plan.states))
    nothing = np.zeros(0)
    rollout = Rollout(True, None, steps, (), *[nothing] * 7, 17.0, 1.0, 0.0, PANDA)
    texts = captions(arch.tasks, rollout, books, plan=plan)
    assert [text.action for text in texts] == [*plan.actions, "done"]
    assert [text.start for text in texts] == list(range(18))
    assert (texts[0].cost, texts[1].cost, texts[-1].cost, texts[-1].total) == (0, 3, 41, 41)
    states = [tuple(task.state for task in text.tasks) for text in texts]
    assert states[0] == ("open", "open") and states[-1] == ("satisfied", "satisfied")
    assert ("satisfied", "open") in states and ("open", "satisfied") not in states
    surprised = replace(rollout, events=(Event(2.0, "replan", {}), Event(4.5, "retry", {}), Event(4.6, "placed", {})))
    told = [text.action for text in captions(arch.tasks, surprised, books, plan=plan)]
    assert told[2] == f"planned again: {plan.actions[2]}" and told[5] == f"once more: {plan.actions[5]}"
    assert [*told[:2], *told[3:5], *told[6:]] == [*plan.actions[:2], *plan.actions[3:5], *plan.actions[6:], "done"]
    stopped = replace(rollout, completed=False, reason="a surprise")
    assert captions(arch.tasks, stopped, books, plan=plan)[-1].action == "stopped"


def test_the_preference_rises_to_that_of_the_plan(arch: Scenario) -> None:
    for plan in pareto_front(arch.problem()):
        so_far = books_of(arch, plan).preferences
        assert len(so_far) == len(plan.actions) + 1
        assert list(so_far) == sorted(so_far)
        assert so_far[-1] == plan.preference


def test_what_is_paid_for_relaxations_is_preference_from_then_on(relaxed: Scenario) -> None:
    plan = pareto_front(relaxed.problem())[0]
    so_far = books_of(relaxed, plan).preferences
    steps = [bought.step for bought in plan.relaxations]
    assert so_far[-1] == plan.preference and steps
    for k, mu in enumerate(so_far):
        assert mu == sum(bought.cost for bought in plan.relaxations if bought.step <= k)
