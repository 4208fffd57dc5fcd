"""Ledgers and captions of runs, on made-up observations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

import numpy as np
import pytest
from scenario_texts import RELAXED_CUP

from experiments.runs.captions import captions
from experiments.runs.formula_words import goal_words
from experiments.runs.outcome import Outcome
from prefplan import Front, ManipulationModel, ManipulationState, Plan, Scenario, Task, pareto_front
from prefplan.scenario.decode import load, loads
from sim.evidence.log import ARRAYS, MORE_ARRAYS
from sim.robots.arms.panda import PANDA
from sim.simulation.run import Event, Run, Step, ledger_of
from sim.world.scene import Scene


def outcome_of(scenario: Scenario, plan: Plan, states: Sequence[ManipulationState] | None = None) -> Outcome:
    """Return the outcome of a plan with one action per second, as predicted or with the given observations."""
    expected = cast(tuple[ManipulationState, ...], plan.states)
    together = enumerate(zip(plan.actions, expected[1:], (states or expected)[1:], strict=True))
    costs = cast(ManipulationModel, scenario.model).costs
    steps = tuple(
        Step(action, k, k + 1, predicted, seen, costs[action.split()[0]]) for k, (action, predicted, seen) in together
    )
    rollout = Run(
        **dict.fromkeys([*ARRAYS, *MORE_ARRAYS, "pad_forces"], np.zeros(0)),
        loads=dict.fromkeys(PANDA.load_limits, np.zeros(0)),
        reason=None,
        steps=steps,
        events=(),
        sim_seconds=float(len(steps)),
        wall_seconds=1.0,
        placement_error=0.0,
        robot=PANDA,
    )
    return Outcome(scenario, cast(Scene, None), plan, rollout, ledger_of(scenario.problem(), plan, steps))


def test_what_is_observed_has_the_labels_of_the_model(arch: Scenario) -> None:
    system = arch.problem().system.listed
    for state in range(0, system.size, 7):
        assert cast(ManipulationState, system.states[state]).label == system.label(state)


@pytest.mark.parametrize("scenario", [load("case_study_3"), loads(RELAXED_CUP)], ids=["arch", "relaxed"])
def test_a_plan_that_goes_well_costs_what_was_planned(scenario: Scenario) -> None:
    for plan in pareto_front(scenario.problem()):
        end = outcome_of(scenario, plan).ledger.final
        assert (end.cost, end.preference) == (plan.cost, plan.preference)
        assert (end.task_costs, end.violation_costs) == (plan.task_costs, plan.violation_costs)


def test_relaxations_apply_to_what_is_observed() -> None:
    relaxed = loads(RELAXED_CUP)
    plan = pareto_front(relaxed.problem())[0]
    ledger = outcome_of(relaxed, plan).ledger
    assert ledger.final.satisfied == {"serve"}
    assert [entry.cost for entry in ledger.entries] == [0, 0.5, 0.6, 1.3, 1.5]


def test_a_task_counts_only_when_it_is_observed_to_be_done(arch: Scenario, arch_front: Front) -> None:
    plan = arch_front[0]
    states = [replace(cast(ManipulationState, state), marks=frozenset()) for state in plan.states]
    end = outcome_of(arch, plan, states).ledger.final
    assert end.satisfied == frozenset() and end.task_costs == {"phi1": plan.cost, "phi2": plan.cost}


def test_captions_show_the_costs_before_each_action_and_at_the_end(arch: Scenario, arch_front: Front) -> None:
    plan = arch_front[1]
    outcome = outcome_of(arch, plan)
    texts = captions(outcome)
    assert [text.action for text in texts] == [*map(plan.display.action, plan.actions), "done"]
    assert texts[6].action == "transport blue sanitizer"
    assert [text.start for text in texts] == list(range(18))
    assert (texts[0].cost, texts[1].cost, texts[-1].cost, texts[-1].total) == (0, 3, 41, 41)
    assert (texts[0].preference, texts[-1].preference, texts[-1].preference_total) == (0, 0, 0)
    told = [(task.name, task.text) for task in texts[0].tasks]
    assert told == [("blue", "sanitized and in bin 1"), ("pink", "sanitized and in bin 1")]
    states = [tuple(task.state for task in text.tasks) for text in texts]
    assert states[0] == ("open", "open") and states[-1] == ("satisfied", "satisfied")
    assert ("satisfied", "open") in states and ("open", "satisfied") not in states


def test_a_caption_tells_that_the_hand_moves_to_the_start(arch: Scenario, arch_front: Front) -> None:
    outcome = outcome_of(arch, arch_front[0])
    late = tuple(replace(step, start=step.start + 1, end=step.end + 1) for step in outcome.run.steps)
    rollout = replace(outcome.run, steps=late, sim_seconds=outcome.run.sim_seconds + 1)
    first, second, *_ = captions(replace(outcome, run=rollout))
    assert (first.start, first.action, first.cost) == (0, "to the start", 0)
    assert (second.start, second.action, second.tasks) == (1, arch_front[0].actions[0], first.tasks)


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("!green_top U (blue_sanitized & blue_bin1)", "blue: sanitized and in bin 1"),
        ("F (blue_sanitized & F blue_table)", "blue: sanitized, then on table"),
        ("F ((blue_bin1 | pink_bin1) & !green_top)", "(blue in bin 1 or pink in bin 1) and not green on top"),
        ("F holding_pink", "pink: in the hand"),
        ("X lamp", "one action later lamp"),
    ],
)
def test_a_task_is_told_by_what_it_wants_in_the_end(arch: Scenario, formula: str, words: str) -> None:
    assert goal_words(Task("phi1", formula), arch.model) == words


def test_captions_tell_of_new_plans_and_attempts(arch: Scenario, arch_front: Front) -> None:
    plan = arch_front[1]
    outcome = outcome_of(arch, plan)
    events = (Event(2.0, "replan", {}), Event(4.5, "retry", {}), Event(4.6, "placed", {}))
    surprised = replace(outcome, run=replace(outcome.run, events=events))
    told = [text.action for text in captions(surprised)]
    actions = [*map(plan.display.action, plan.actions)]
    assert told[2] == f"planned again: {actions[2]}" and told[5] == f"once more: {actions[5]}"
    assert [*told[:2], *told[3:5], *told[6:]] == [*actions[:2], *actions[3:5], *actions[6:], "done"]
    stopped = replace(outcome, run=replace(outcome.run, reason="a surprise"))
    assert captions(stopped)[-1].action == "stopped"
