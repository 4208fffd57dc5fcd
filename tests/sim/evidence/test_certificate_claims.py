"""Certificates of logs whose claims or events contradict the frames."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from forged_logs import claiming, log_of_run, refutations, telling
from scenario_texts import shipped

from prefplan import Purchase
from sim.evidence.certificate import certify
from sim.evidence.log import Log
from sim.simulation.rollout import Event


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


def test_measured_costs_are_checked_by_where_the_hand_goes() -> None:
    log = log_of_run(shipped("case_study_3_energy"))
    assert certify(log).confirmed
    # Into the other slot of the bin it would have cost something else.
    actions = log.about.actions
    (k,) = [k for k, action in enumerate(actions) if action.action == "transport blue bin1"]
    slots = [cost for *pair, cost in log.about.measured if pair[:2] == ["transport", "san"] and "bin1[" in pair[2]]
    (other,) = set(slots) - {actions[k].cost}
    forged = (*actions[:k], replace(actions[k], cost=other), *actions[k + 1 :])
    words = refutations(telling(log, actions=forged))["action costs"]
    assert words == f"action {k + 1} `transport blue bin1` costs {actions[k].cost}, not {other}"
    # After a mismatch the arm has observed all objects.
    surprise = Event(actions[k].start, "replan", {})
    assert "action costs" not in refutations(telling(log, actions=forged, events=(*log.about.events, surprise)))
