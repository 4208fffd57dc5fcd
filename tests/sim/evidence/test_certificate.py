"""Certificates of genuine logs, and what the checker refuses and relies on."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from forged_logs import claiming, cut, log_of_run, telling
from scenario_texts import PLACES_NEARBY, RELAXED_CUP, cup_scenario

from prefplan import claims
from prefplan.scenario.decode import loads
from sim.errors import LogError
from sim.evidence import action_checks, certificate, motion_checks, replay
from sim.evidence.certificate import certify
from sim.evidence.log import Log
from sim.execution.faults.fault import read_fault


def test_a_true_log_is_confirmed(arch_log: Log) -> None:
    certificate = certify(arch_log)
    assert certificate.refuted == ()
    assert certificate.confirmed and certificate.agrees and certificate.completed
    assert certificate.task_costs == {"phi1": 34, "phi2": 17} and certificate.preference == 17
    names = [check.name for check in certificate.checks]
    assert names[:14] == [f"action {k}" for k in range(1, 15)]
    assert names[14:] == [
        "rest",
        "events",
        "total cost",
        "task cost phi1",
        "task cost phi2",
        "preference",
        "completed",
        "joint positions",
        "joint speeds",
        "joint accelerations",
        "joint jerks",
        "joint torques",
        "joint torque rates",
        "simulated again",
        "faults",
        "contacts",
    ]
    assert "% of the limit, joint" in certificate.check("joint speeds").words


def test_nothing_finer_than_a_tenth_of_a_micrometre_is_kept(arch_log: Log) -> None:
    for rows in (arch_log.qpos, arch_log.qvel):
        assert np.array_equal(rows, rows.round(7)) and not np.array_equal(rows, rows.round(6))


def test_the_robot_is_needed(arch_log: Log) -> None:
    """Without it its motors and their torques are unknown."""
    with pytest.raises(LogError, match="the log cannot be checked: unknown robot 'zeus'"):
        certify(telling(arch_log, robot="zeus"))


def test_relaxations_are_granted_where_they_are_offered(relaxed_log: Log) -> None:
    certificate = certify(relaxed_log)
    assert certificate.confirmed
    assert certificate.preference == 9 and certificate.task_costs == {"serve": 1.5, "wash": 1.5}
    assert certificate.check("relaxations").words == "2 used, as offered"
    assert certificate.check("completed").words == "serve satisfied; wash skipped"


def test_an_unfinished_run_is_confirmed_to_be_one(arch_log: Log) -> None:
    end = arch_log.about.actions[6].end
    told = tuple(event for event in arch_log.about.events if event.time <= end)
    stopped = telling(cut(arch_log, end), actions=arch_log.about.actions[:7], events=told)
    claims = {"completed": False, "cost": 17, "task_costs": {"phi1": 17, "phi2": 17}, "preference": None}
    certificate = certify(claiming(stopped, **claims))
    assert certificate.confirmed and not certificate.completed
    assert certificate.check("completed").words == "not claimed: phi1 not satisfied"


def test_a_run_in_which_a_stranger_was_cleared_away_is_certified() -> None:
    scenario = loads(cup_scenario(places=PLACES_NEARBY | {"rest": "{ at = [0.4, 0.32] }"}))
    log = log_of_run(scenario, seed=3, faults=[read_fault("foreign:tray@1", scenario.model)])  # type: ignore[arg-type]
    certificate = certify(log)
    assert certificate.confirmed and certificate.completed
    assert "release foreign1 rest" in [action.action for action in log.about.actions]


def test_what_is_not_of_the_scenario_does_not_matter(arch_log: Log) -> None:
    """A run may observe a place that is not in the scenario."""
    actions = tuple(replace(a, label=(*a.label, "foreign_table", "green_spot_1")) for a in arch_log.about.actions)
    assert certify(telling(arch_log, actions=actions)).confirmed


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"text": "not toml"}, "the scenario in the log cannot be used: .*not TOML"),
        ({"text": "[model]\nkind = 'grid'"}, "the scenario in the log cannot be used"),
        ({"setting": {"perturbation": "noise=1000"}}, "the setting in the log cannot be used: noise: 1000 is not"),
        ({"setting": {"perturbation": {"position": 50}}}, "the setting in the log cannot be used: perturbation {'pos"),
        (
            {"setting": {"seed": None, "perturbation": "position=5"}},
            "without a seed, nothing is perturbed",
        ),
        ({"setting": {"trusted": "by all"}}, "the setting in the log cannot be used: trusted 'by all'"),
        ({"joints": {}}, "its joints are not those of its scenario"),
        ({"joints": {f"joint{i}": 1000 for i in range(1, 8)}}, "its joints are not those of its scenario"),
        ({"controls": np.zeros((3, 6), int)}, "controls has 6 columns, its scenario 8"),
    ],
)
def test_a_log_that_cannot_be_checked_is_refused(arch_log: Log, change: dict[str, Any], words: str) -> None:
    log = replace(arch_log, **change) if "controls" in change else telling(arch_log, **change)
    with pytest.raises(LogError, match=words):
        certify(log)


def test_a_log_without_an_orientation_is_refuted_and_one_without_a_known_proposition_refused(arch_log: Log) -> None:
    qpos, first = arch_log.qpos.copy(), arch_log.about.joints["pink"]
    qpos[5, first + 3 : first + 7] = 0
    assert certify(replace(arch_log, qpos=qpos)).check("simulated again").words.startswith("pink is ")
    other = arch_log.about.text.replace('formula = "', 'formula = "F unheard & ', 1)
    with pytest.raises(LogError, match="the scenario in the log cannot be used: unknown proposition 'unheard'"):
        certify(telling(arch_log, text=other))


@pytest.mark.parametrize("module", [certificate, replay, motion_checks, action_checks, claims])
def test_the_checker_shares_nothing_with_what_it_judges(module: ModuleType) -> None:
    source = Path(str(module.__file__)).read_text(encoding="utf-8")
    imported = {node.module for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ImportFrom)}
    judged = {
        "sim.perception.grounding",
        "sim.perception.touch",
        "sim.perception.sensors",
        "sim.simulation.workcell",
        "sim.execution.executor",
        "prefplan.ledger",
        "prefplan.logic.dfa",
        "prefplan.logic.weighted_dfa",
        "prefplan.product.product_automaton",
        "prefplan.planner",
    }
    assert imported.isdisjoint(judged)


def test_an_empty_plan_needs_no_action() -> None:
    text = RELAXED_CUP.replace("F (cup_clean & cup_tray)", "F cup_desk").replace("F cup_clean", "F cup_desk")
    certificate = certify(log_of_run(loads(text)))
    assert certificate.confirmed and certificate.task_costs == {"serve": 0, "wash": 0}
