"""Certificates of true logs, and of logs that were tampered with."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_scenes import RELAXED_CUP

import sim
from experiments import scenarios
from experiments.carry_out import carry_out, scene_of
from experiments.evidence import evidence
from prefplan import Purchase, Scenario, cheapest_plan, pareto_front
from prefplan.scenario import loads
from sim.certificate import Certificate, certify
from sim.errors import LogError
from sim.faults import read_fault
from sim.log import ARRAYS, Log
from sim.panda import ARM_JOINTS, TORQUE_LIMITS, VELOCITY_LIMITS
from sim.rollout import Event


def log_of_plan(scenario: Scenario, *, index: int = 0, seed: int | None = None) -> Log:
    scene = scene_of(scenario)
    plan = pareto_front(scenario.problem())[index]
    return evidence(scenario, scene, carry_out(scenario, scene, plan, seed=seed), setting={"seed": seed})


@pytest.fixture(scope="module")
def arch() -> Log:
    """The cheapest plan of Case Study 3: 14 actions, cost 34, mu 17."""
    return log_of_plan(scenarios.find("case_study_3"), seed=4)


@pytest.fixture(scope="module")
def relaxed() -> Log:
    """A cup put onto the tray as it is: washing is skipped, and the tray takes it for clean."""
    return log_of_plan(loads(RELAXED_CUP, name="relaxed"))


def claiming(log: Log, **claims: Any) -> Log:
    return replace(log, about=replace(log.about, claims=replace(log.about.claims, **claims)))


def telling(log: Log, **about: Any) -> Log:
    return replace(log, about=replace(log.about, **about))


def refutations(log: Log) -> dict[str, str]:
    """Return what is refuted: words by name."""
    return {check.name: check.words for check in certify(log).refuted}


def moved(log: Log, thing: str, position: tuple[float, ...], *, since: float, until: float = np.inf) -> Log:
    """Return a log in which an object lies elsewhere for a while."""
    qpos = log.qpos.copy()
    first = log.about.joints[thing]
    frames = (log.times >= since) & (log.times < until)
    qpos[frames, first : first + 7] = [*position, 1, 0, 0, 0]
    return replace(log, qpos=qpos)


def cut(log: Log, time: float) -> Log:
    """Return a log of which only the frames up to a time are left."""
    keep = log.times <= time
    arrays = {name: getattr(log, name)[keep] for name in ARRAYS}
    return replace(log, **arrays)


def without_action(log: Log, k: int) -> Log:
    """Return a log from whose account action k, counted from 1, was dropped."""
    actions = log.about.actions
    return telling(log, actions=actions[: k - 1] + actions[k:])


def test_a_true_log_is_confirmed(arch: Log) -> None:
    certificate = certify(arch)
    assert certificate.refuted == ()
    assert certificate.confirmed and certificate.agrees and certificate.completed
    assert certificate.task_costs == {"phi1": 34, "phi2": 17} and certificate.preference == 17
    names = [check.name for check in certificate.checks]
    assert names[:2] == ["recording", "start"] and names[2:16] == [f"action {k}" for k in range(1, 15)]
    assert names[16:] == [
        "action costs",
        "total cost",
        "task cost phi1",
        "task cost phi2",
        "preference",
        "completed",
        "joint positions",
        "joint speeds",
        "joint torques",
        "objects",
        "contacts",
    ]
    assert "% of the limit, joint" in certificate.check("joint speeds").words


def test_meshes_are_not_needed(arch: Log) -> None:
    certificate = certify(telling(arch, meshes=False))
    assert certificate.confirmed
    assert certificate.check("contacts").words.endswith("with plain shapes of the arm")


def test_a_robot_that_cannot_be_had_is_stood_in_for(arch: Log) -> None:
    assert certify(telling(arch, robot="one nobody knows")).confirmed


def test_relaxations_are_granted_where_they_are_offered(relaxed: Log) -> None:
    certificate = certify(relaxed)
    assert certificate.confirmed
    assert certificate.preference == 9 and certificate.task_costs == {"serve": 1.5, "wash": 1.5}
    assert certificate.check("relaxations").words == "2 used, as offered"
    assert certificate.check("completed").words == "serve satisfied on the recorded states; wash skipped"


def test_an_unfinished_run_is_confirmed_to_be_one(arch: Log) -> None:
    end = arch.about.actions[6].end
    stopped = telling(cut(arch, end), actions=arch.about.actions[:7])
    claims = {"completed": False, "cost": 17, "task_costs": {"phi1": 17, "phi2": 17}, "preference": None}
    certificate = certify(claiming(stopped, **claims))
    assert certificate.confirmed and not certificate.completed
    assert certificate.check("completed").words == "not claimed: phi1 not satisfied"


@pytest.mark.parametrize(
    ("claims", "name", "words"),
    [
        ({"cost": 33}, "total cost", "33 is claimed, but the frames give 34"),
        ({"task_costs": {"phi1": 34, "phi2": 16}}, "task cost phi2", "16 is claimed, but the frames give 17"),
        ({"task_costs": {"phi1": 17, "phi2": 34}}, "task cost phi1", "17 is claimed, but the frames give 34"),
        ({"task_costs": {"phi1": 34}}, "task cost phi2", "nothing is claimed; the frames give 17"),
        ({"preference": 0}, "preference", "0 is claimed, but the frames give 17"),
        ({"preference": None}, "preference", "nothing is claimed; the frames give 17"),
        ({"violation_costs": {"phi1": 2}}, "violation cost phi1", "2 is claimed, but the frames give 0"),
        (
            {"relaxations": (Purchase("phi1", 0, None, 3),)},
            "relaxations",
            "phi1 cannot be skipped for 3 at step 0",
        ),
        (
            {"relaxations": (Purchase("phi1", 3, "blue_bin1", 1),)},
            "relaxations",
            "blue_bin1 at step 3 of phi1, for 1, is not on offer",
        ),
    ],
)
def test_a_forged_claim_is_refuted(arch: Log, claims: dict[str, Any], name: str, words: str) -> None:
    assert refutations(claiming(arch, **claims))[name] == words


@pytest.mark.parametrize(
    ("purchases", "words"),
    [
        ([("serve", 4, "cup_clean", 3)], "cup_clean at step 4 of serve, for 3, is not on offer"),
        ([("serve", 2, "cup_clean", 4)], "cup_clean at step 2 of serve, for 4, is not on offer there"),
        ([("serve", 9, "cup_clean", 4)], "cup_clean at step 9 of serve, for 4, lies beyond the last action"),
        ([("wash", 1, None, 5)], "wash cannot be skipped for 5 at step 1"),
        ([("wash", 0, None, 1)], "wash cannot be skipped for 1 at step 0"),
        ([("dry", 0, None, 1)], "there is no task dry"),
    ],
)
def test_a_relaxation_that_nobody_offers_is_refuted(
    relaxed: Log, purchases: list[tuple[str, int, str | None, int]], words: str
) -> None:
    found = refutations(claiming(relaxed, relaxations=tuple(Purchase(*purchase) for purchase in purchases)))
    assert found["relaxations"].startswith(words)
    assert "completed" in found


def test_without_its_relaxations_a_task_is_not_satisfied(relaxed: Log) -> None:
    skip = tuple(bought for bought in relaxed.about.claims.relaxations if bought.assume is None)
    found = refutations(claiming(relaxed, relaxations=skip))
    assert found["completed"] == "not satisfied on the recorded states: serve"
    assert found["violation cost serve"] == "4 is claimed, but the frames give 0"


@pytest.mark.parametrize("k", range(1, 15))
def test_no_action_can_be_dropped_unnoticed(arch: Log, k: int) -> None:
    found = refutations(without_action(arch, k))
    assert "total cost" in found
    if arch.about.actions[k - 1].action == "release pink san":
        assert found["completed"] == "not satisfied on the recorded states: phi2"


@pytest.mark.parametrize("k", range(1, 15))
def test_no_action_can_be_made_cheaper(arch: Log, k: int) -> None:
    actions = list(arch.about.actions)
    actions[k - 1] = replace(actions[k - 1], cost=0)
    words = refutations(telling(arch, actions=tuple(actions)))["action costs"]
    assert words.startswith(f"action {k} `{actions[k - 1].action}` costs") and words.endswith("not 0")


def test_measured_costs_are_checked_by_where_the_hand_goes() -> None:
    log = log_of_plan(scenarios.find("case_study_3_energy"))
    assert certify(log).confirmed
    # Into the other slot of the bin it would have cost something else.
    (k,) = [k for k, action in enumerate(log.about.actions) if action.action == "transport blue bin1"]
    slots = [cost for *pair, cost in log.about.measured if pair[:2] == ["transport", "san"] and "bin1[" in pair[2]]
    (other,) = set(slots) - {log.about.actions[k].cost}
    forged = tuple(replace(action, cost=other) if i == k else action for i, action in enumerate(log.about.actions))
    words = refutations(telling(log, actions=forged))["action costs"]
    assert words == f"action {k + 1} `transport blue bin1` costs {log.about.actions[k].cost}, not {other}"
    # After a surprise the arm has seen for itself what lies where.
    surprise = Event(log.about.actions[k].start, "replan", {})
    assert "action costs" not in refutations(telling(log, actions=forged, events=(*log.about.events, surprise)))
    actions = log.about.actions
    for k, action in enumerate(actions):
        kind = action.action.split()[0]
        other = next(a.cost for a in actions if a.action.startswith(f"{kind} ") and a.cost != action.cost)
        forged = (*actions[:k], replace(action, cost=other), *actions[k + 1 :])
        words = refutations(telling(log, actions=forged))["action costs"]
        assert words == f"action {k + 1} `{action.action}` costs {action.cost}, not {other}"


@pytest.mark.parametrize("k", range(14))
def test_a_recording_cut_short_is_refuted(arch: Log, k: int) -> None:
    end = 0.0 if k == 0 else arch.about.actions[k - 1].end
    found = refutations(cut(arch, end))
    assert f"but action {k + 1} `" in found["recording"]
    # Told shorter to match, it tells of tasks that were not done.
    found = refutations(telling(cut(arch, end), actions=arch.about.actions[:k]))
    assert "recording" not in found and "not satisfied on the recorded states" in found["completed"]


def test_frames_cut_out_are_missed(arch: Log) -> None:
    keep = (arch.times < 5) | (arch.times > 6)
    arrays = {name: getattr(arch, name)[keep] for name in ARRAYS}
    assert refutations(replace(arch, **arrays))["recording"].startswith("frames are missing or out of order after")
    assert "out of order" in refutations(replace(arch, times=arch.times[::-1].copy()))["recording"]


@pytest.mark.parametrize("thing", ["blue", "pink", "green"])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.95])
def test_a_block_that_is_teleported_is_missed_where_it_was(arch: Log, thing: str, share: float) -> None:
    since = share * arch.times[-1]
    found = refutations(moved(arch, thing, (0.30, 0.45, 0.0225), since=since))
    assert found["objects"].startswith(f"{thing} leaps")
    assert any(name.startswith("action ") for name in found)
    if (thing, share) in {("blue", 0.1), ("blue", 0.5), ("pink", 0.1)}:
        assert "completed" in found


def test_a_block_that_appears_where_it_was_wanted_was_not_carried_there(arch: Log) -> None:
    """Only the end is made up: pink, left alone on the arch, is suddenly in the bin."""
    scenario = scenarios.find("case_study_3")
    blocks = scene_of(scenario).slots
    start, goal = blocks["top"][0].position, blocks["bin1"][0].position
    first = arch.about.joints["pink"]
    qpos = arch.qpos.copy()
    qpos[:, first : first + 7] = arch.qpos[0, first : first + 7]
    late = arch.times > arch.times[-1] - 0.5
    qpos[late, first : first + 7] = arch.qpos[-1, first : first + 7]
    found = refutations(replace(arch, qpos=qpos))
    assert np.hypot(*(goal - start)[:2]) > 0.3
    assert found["objects"].startswith("pink leaps 0.3")
    assert "action 2" in found and "holding_pink" in found["action 2"]
    assert found["completed"].startswith("not satisfied on the recorded states: ")


def test_a_leap_that_a_fault_explains_is_none(arch: Log) -> None:
    leapt = moved(arch, "green", (0.30, 0.45, 0.0225), since=5.0)
    time = float(leapt.times[leapt.times >= 5.0][0])
    fault = Event(time, "fault", {"fault": "move:green@2"})
    assert "objects" in refutations(leapt)
    assert "objects" not in refutations(telling(leapt, events=(*leapt.about.events, fault)))
    assert "objects" in refutations(telling(leapt, events=(replace(fault, detail={"fault": "move:pink@2"}),)))
    assert "objects" in refutations(telling(leapt, events=(replace(fault, time=8.0),)))


def test_what_no_pad_presses_is_not_held(arch: Log) -> None:
    found = refutations(replace(arch, pad_forces=np.zeros_like(arch.pad_forces)))
    assert "frames show nothing, the record tells holding_pink instead" in found["action 2"]
    # Nothing was ever held, so nothing was put down and marked.
    assert found["completed"] == "not satisfied on the recorded states: phi1, phi2"


def test_what_no_location_worked_on_is_not_marked(arch: Log) -> None:
    found = refutations(replace(arch, glow=np.full_like(arch.glow, -1)))
    assert "record tells pink_sanitized instead" in found["action 4"]
    assert found["completed"] == "not satisfied on the recorded states: phi1, phi2"


def test_an_object_that_starts_elsewhere_is_told(arch: Log) -> None:
    swapped = arch.about.text.replace('start = "top"', 'start = "table"')
    assert refutations(telling(arch, text=swapped))["start"] == "pink does not start at table"


def test_another_formula_is_judged_anew(arch: Log) -> None:
    text = arch.about.text.replace("(blue_sanitized & blue_bin1)", "(blue_sanitized & blue_bin2)")
    assert text != arch.about.text
    assert refutations(telling(arch, text=text))["completed"].endswith(": phi1")


@pytest.mark.parametrize("joint", range(7))
def test_a_limit_that_was_passed_is_told(arch: Log, joint: int) -> None:
    for name, array, limits in (("speeds", arch.speeds, VELOCITY_LIMITS), ("torques", arch.torques, TORQUE_LIMITS)):
        beyond = array.copy()
        beyond[100, joint] = 1.01 * limits[joint]
        words = refutations(replace(arch, **{name: beyond}))[f"joint {name}"]
        assert words == f"exceeded: 101.0% of the limit, {ARM_JOINTS[joint]} at {arch.times[100]:.2f} s"


def test_a_joint_past_its_stop_is_told(arch: Log) -> None:
    qpos = arch.qpos.copy()
    qpos[:, arch.about.joints["joint4"]] = -3.1
    assert "exceeded" in refutations(replace(arch, qpos=qpos))["joint positions"]


def test_speeds_are_not_hidden(arch: Log) -> None:
    words = refutations(replace(arch, speeds=np.zeros_like(arch.speeds)))["joint speeds"]
    assert "where at most 0.00 rad/s are recorded" in words


def test_an_arm_in_the_wrong_place_touches_what_it_should_not(arch: Log) -> None:
    first = arch.about.joints["joint1"]
    qpos = arch.qpos.copy()
    low = int(np.argmin(np.abs(arch.times - arch.about.actions[1].start - 1.5)))
    qpos[low, first + 1] += 0.25
    words = refutations(replace(arch, qpos=qpos))["contacts"]
    assert "touches" in words and f"at {arch.times[low]:.2f} s" in words


def test_a_touch_that_the_log_itself_tells_counts(arch: Log) -> None:
    touch = Event(1.0, "contact", {"moving": "hand", "other": "green"})
    words = refutations(telling(arch, events=(*arch.about.events, touch)))["contacts"]
    assert words == "hand touched green at 1.00 s, the log itself says"


def test_what_a_fault_throws_at_the_arm_is_not_the_arms_doing(arch: Log) -> None:
    fault = Event(4.0, "fault", {"fault": "knock:green@2"})
    cases = ((4.5, "green", False), (4.5, "blue", True), (3.9, "green", True), (9.0, "green", True))
    for time, other, refuted in cases:
        touch = Event(time, "contact", {"moving": "hand", "other": other})
        events = (*arch.about.events, fault, touch)
        assert ("contacts" in refutations(telling(arch, events=events))) == refuted


@pytest.mark.slow
def test_a_run_in_which_a_stranger_was_cleared_away_is_certified() -> None:
    scenario = scenarios.find("case_study_3")
    faults = [read_fault("foreign:bin1@1", scenario.model), read_fault("foreign:bin1@2", scenario.model)]
    scene = scene_of(scenario, faults=faults)
    plan = cheapest_plan(scenario.problem())
    log = evidence(scenario, scene, carry_out(scenario, scene, plan, seed=1, faults=faults))
    certificate = certify(log)
    assert certificate.confirmed and certificate.completed
    assert any("foreign" in action.action for action in log.about.actions)
    without = telling(log, joints={name: at for name, at in log.about.joints.items() if "foreign" not in name})
    assert certify(without).agrees


def test_a_bystander_may_not_be_touched_by_the_fingers(arch: Log) -> None:
    """While pink is said to be handled, the fingers hold blue."""
    actions = tuple(replace(a, action=a.action.replace("blue", "green")) for a in arch.about.actions)
    found = refutations(telling(arch, actions=actions))
    assert "touches blue" in found["contacts"]


def test_what_is_not_of_the_scenario_does_not_matter(arch: Log) -> None:
    """A block that is not in the scenario, and a place it does not have, may have been seen."""
    actions = tuple(replace(a, label=(*a.label, "foreign_table", "green_spot_1")) for a in arch.about.actions)
    joints = arch.about.joints | {"foreign": arch.qpos.shape[1]}
    strange = np.tile([0.3, 0.45, 0.0225, 1, 0, 0, 0], (len(arch.times), 1))
    log = replace(telling(arch, actions=actions, joints=joints), qpos=np.hstack([arch.qpos, strange]))
    assert certify(log).confirmed


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"text": "not toml"}, "the scenario in the log is of no use: .*not TOML"),
        ({"text": "[model]\nkind = 'grid'"}, "the scenario in the log is of no use"),
        ({"joints": {}}, "does not say where in a frame 'joint1' is"),
        ({"joints": {f"joint{i}": 1000 for i in range(1, 8)}}, "does not say where in a frame 'joint1' is"),
    ],
)
def test_a_log_that_cannot_be_checked_is_refused(arch: Log, change: dict[str, Any], words: str) -> None:
    with pytest.raises(LogError, match=words):
        certify(telling(arch, **change))


def test_every_certificate_of_a_forger_who_guesses_is_refuted(arch: Log) -> None:
    """Random tamperings of several kinds, none of them told apart beforehand."""
    rng = np.random.default_rng(0)
    claims = arch.about.claims
    kinds: list[Callable[[], Log]] = [
        lambda: claiming(arch, cost=int(rng.integers(1, 34))),
        lambda: claiming(arch, task_costs=claims.task_costs | {"phi1": int(rng.integers(0, 34))}),
        lambda: claiming(arch, preference=int(rng.integers(0, 17))),
        lambda: cut(arch, float(rng.uniform(0, 0.95)) * arch.times[-1]),
        lambda: without_action(arch, int(rng.integers(1, 15))),
        lambda: moved(
            arch,
            str(rng.choice(["blue", "pink", "green"])),
            (0.3, float(rng.uniform(0.40, 0.5)), 0.0225),
            since=float(rng.uniform(0.1, 0.95)) * arch.times[-1],
        ),
        lambda: replace(arch, pad_forces=arch.pad_forces * (arch.times < rng.uniform(0, 25))[:, None]),
    ]
    for _ in range(70):
        certificate = certify(kinds[int(rng.integers(len(kinds)))]())
        assert not certificate.confirmed and not certificate.agrees


@pytest.mark.parametrize("name", ["certificate", "recorded_world", "motion_checks", "cost_checks"])
def test_the_checker_has_no_eyes_in_common_with_the_run(name: str) -> None:
    source = Path(next(iter(sim.__path__)), f"{name}.py").read_text(encoding="utf-8")
    imported = {node.module for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ImportFrom)}
    shared = ("sim.grounding", "sim.watch", "sim.workcell", "sim.execution", "sim.perception", "prefplan.automaton")
    assert imported.isdisjoint({*shared, "prefplan.weighted_automaton", "prefplan.product", "prefplan.planner"})


def test_an_empty_plan_needs_no_action() -> None:
    scenario = loads(RELAXED_CUP.replace("F (cup_clean & cup_tray)", "F cup_desk").replace("F cup_clean", "F cup_desk"))
    scene = scene_of(scenario)
    outcome = carry_out(scenario, scene, cheapest_plan(scenario.problem()))
    certificate: Certificate = certify(evidence(scenario, scene, outcome))
    assert certificate.confirmed and certificate.task_costs == {"serve": 0, "wash": 0}
