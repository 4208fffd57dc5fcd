"""Certificates of logs whose claims or events contradict the frames."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from forged_logs import claiming, log_of_run, refutations, telling
from scenario_texts import cup_scenario, shipped

from prefplan import Purchase
from prefplan.scenario.decode import loads
from sim.evidence.certificate import certify
from sim.evidence.log import Log
from sim.simulation.run import Event


@pytest.mark.usefixtures("claims_alone")
@pytest.mark.parametrize(
    ("claims", "name", "words"),
    [
        ({"cost": 33}, "total cost", "33 is claimed, but it is 34"),
        ({"task_costs": {"phi1": 34, "phi2": 16}}, "task cost phi2", "16 is claimed, but it is 17"),
        ({"task_costs": {"phi1": 34}}, "task cost phi2", "nothing is claimed; it is 17"),
        ({"preference": 0}, "preference", "0 is claimed, but it is 17"),
        ({"preference": None}, "preference", "nothing is claimed; it is 17"),
        ({"violation_costs": {"phi1": 2}}, "violation cost phi1", "2 is claimed, but it is 0"),
    ],
)
def test_a_forged_claim_is_refuted(arch_log: Log, claims: dict[str, Any], name: str, words: str) -> None:
    assert refutations(claiming(arch_log, **claims))[name] == words


@pytest.mark.usefixtures("claims_alone")
@pytest.mark.parametrize(
    ("purchases", "words"),
    [
        ([("serve", 4, "cup_clean", 3)], "cup_clean at step 4 of serve, for 3, is not offered"),
        ([("serve", 2, "cup_clean", 4)], "cup_clean at step 2 of serve, for 4, is not offered there"),
        ([("serve", 9, "cup_clean", 4)], "cup_clean at step 9 of serve, for 4, lies beyond the last action"),
        ([("wash", 1, None, 5)], "wash cannot be skipped for 5 at step 1"),
        ([("wash", 0, None, 1)], "wash cannot be skipped for 1 at step 0"),
        ([("dry", 0, None, 1)], "there is no task dry"),
    ],
)
def test_a_relaxation_that_nobody_offers_is_refuted(
    relaxed_log: Log, purchases: list[tuple[str, int, str | None, int]], words: str
) -> None:
    found = refutations(claiming(relaxed_log, relaxations=tuple(Purchase(*purchase) for purchase in purchases)))
    assert found["relaxations"].startswith(words)
    assert "completed" in found


@pytest.mark.usefixtures("claims_alone")
def test_without_its_relaxations_a_task_is_not_satisfied(relaxed_log: Log) -> None:
    skip = tuple(bought for bought in relaxed_log.about.claims.relaxations if bought.assume is None)
    found = refutations(claiming(relaxed_log, relaxations=skip))
    assert found["completed"] == "not satisfied: serve"
    assert found["violation cost serve"] == "4 is claimed, but it is 0"


@pytest.mark.usefixtures("claims_alone")
@pytest.mark.parametrize(
    ("degrees", "noise", "accepted"),
    [(0, 0, {True}), (10, 0, {True}), (19, 0, {True}), (30, 0, {False}), (10, 2, {True}), (19, 2, {True, False})],
)
def test_what_noise_decides_is_as_the_log_says_and_nothing_else(
    arch_log: Log, degrees: float, noise: float, accepted: set[bool]
) -> None:
    """A cube that leans on an edge is higher by 3.6 mm at 10 degrees and by 6.1 mm at 19; up to 8 mm count as standing.

    Two standard deviations of 2 mm leave open what is between 4 and 12 mm.
    """
    angle, half, first = np.radians(degrees), 0.0225, arch_log.about.joints["green"]
    qpos = arch_log.qpos.copy()
    qpos[:, first + 2] = half * (np.cos(angle) + np.sin(angle))
    qpos[:, first + 3 : first + 7] = [np.cos(angle / 2), np.sin(angle / 2), 0, 0]
    leaning = telling(
        replace(arch_log, qpos=qpos),
        setting=arch_log.about.setting | {"perturbation": f"position=5,angle=5,noise={noise}"},
    )
    told = {*arch_log.about.actions[0].label}
    place = next(name for name in told if name.startswith("green_"))
    found = set()
    for there in (True, False):
        label = tuple(sorted(told if there else told - {place}))
        actions = (replace(leaning.about.actions[0], label=label), *leaning.about.actions[1:])
        if certify(telling(leaning, actions=actions)).check("action 1").holds:
            found.add(there)
    assert found == accepted


def test_a_run_may_end_with_an_object_in_the_hand() -> None:
    hold = """
[[tasks]]
name = "hold"
formula = "F (cup_tray & F holding_cup)"
[preference]
kind = "order"
"""
    log = log_of_run(loads(cup_scenario(hold), name="hold"))
    assert log.about.actions[-1].action == "grasp cup" and refutations(log) == {}


def test_measured_costs_depend_on_the_slots_of_objects_at_the_start() -> None:
    """The first action that depends on them carries the mug to the counter, where the fish takes a slot."""
    assert refutations(log_of_run(shipped("kitchen_energy"))) == {}


def test_measured_costs_are_checked_by_where_the_hand_goes() -> None:
    log = log_of_run(shipped("case_study_3_energy"))
    assert certify(log).confirmed
    # Into the other slot of the bin it would have cost something else.
    actions = log.about.actions
    (k,) = [k for k, action in enumerate(actions) if action.action == "transport blue bin1"]
    slots = [cost for *pair, cost in log.about.measured if pair[:2] == ["transport", "san"] and "bin1[" in pair[2]]
    (other,) = set(slots) - {actions[k].cost}
    forged = (*actions[:k], replace(actions[k], cost=other), *actions[k + 1 :])
    words = refutations(telling(log, actions=forged))[f"action {k + 1}"]
    assert words == f"`transport blue bin1`: it costs {actions[k].cost}, not {other}"
    # After a mismatch the arm has observed all objects.
    surprise = Event(actions[k].start, "replan", {})
    assert f"action {k + 1}" not in refutations(telling(log, actions=forged, events=(*log.about.events, surprise)))
    # From the start on it has, too: the honest transit from the bin costs what it costs from one of its slots.
    from_bin = f"action {[action.action for action in actions].index('release pink bin1') + 2}"
    honest = telling(log, events=(Event(0.0, "replan", {}), *log.about.events))
    assert from_bin not in refutations(honest)


@pytest.mark.usefixtures("claims_alone")
@pytest.mark.parametrize(("kinds", "answered"), [(("mismatch", "retry"), True), (("retry", "mismatch"), False)])
def test_a_surprise_is_answered_by_what_comes_after_it(arch_log: Log, kinds: tuple[str, str], answered: bool) -> None:
    first = arch_log.about.actions[0]
    times = np.linspace(first.start, first.end, 4)[1:3]
    events = tuple(Event(float(time), kind, {}) for time, kind in zip(times, kinds, strict=True))
    check = certify(telling(arch_log, events=events)).check("action 1")
    assert ("no event says what was done about it" not in check.words) == answered
