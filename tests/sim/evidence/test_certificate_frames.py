"""Certificates of logs whose frames were tampered with, and of motions that should not be."""

from __future__ import annotations

import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from forged_logs import claiming, log_of_run, refutations, telling
from scenario_texts import PAST_A_TOWER

from prefplan.scenario.decode import loads
from sim.evidence.certificate import certify
from sim.evidence.dynamics import Dynamics
from sim.evidence.force_checks import check_grip
from sim.evidence.log import Log
from sim.evidence.object_checks import check_motions
from sim.evidence.replay import RecordedWorld
from sim.evidence.touch_checks import check_contacts
from sim.robots.arms.panda import PANDA
from sim.simulation.recorder import COMMANDS_PER_UNIT
from sim.simulation.run import Event
from sim.skills import transfer, transport

GRAZE_M = 0.002
"""How deep a load penetrates another object as it passes over it, m."""


@pytest.mark.usefixtures("claims_alone")
def test_what_no_location_was_seen_to_mark_was_not_marked(arch_log: Log) -> None:
    found = refutations(replace(arch_log, glow=np.full_like(arch_log.glow, -1)))
    assert "log says pink_sanitized" in found["action 4"]
    assert found["completed"] == "not satisfied: phi1, phi2"


@pytest.mark.usefixtures("claims_alone")
@pytest.mark.parametrize(
    ("name", "joint"),
    [("speeds", 0), ("accelerations", 1), ("jerks", 2), ("torques", 3), ("torques", 6), ("torque_rates", 5)],
)
def test_a_limit_that_was_passed_is_told(arch_log: Log, name: str, joint: int) -> None:
    beyond = getattr(arch_log, name).copy()
    beyond[100, joint] = 1.01 * np.asarray(PANDA.load_limits[name])[joint]
    words = refutations(replace(arch_log, **{name: beyond}))[f"joint {name.replace('_', ' ')}"]
    assert words == f"exceeded: 101.0% of the limit, {PANDA.joints[joint]} at {arch_log.times[100]:.2f} s"


def test_what_a_failed_run_did_is_a_finding_and_no_lie(arch_log: Log) -> None:
    """The same limit and the same touch refute a run that claims to be completed."""
    beyond = arch_log.torque_rates.copy()
    beyond[100, 1] = 1.4 * np.asarray(PANDA.load_limits["torque_rates"])[1]
    touch = Event(3.9, "contact", {"moving": "hand", "other": "green"})
    told = sorted((*arch_log.about.events, touch), key=lambda event: event.time)
    log = telling(replace(arch_log, torque_rates=beyond), events=tuple(told))
    wrong = {"joint torque rates", "contacts"}
    assert refutations(log).keys() == wrong and certify(log).findings == ()
    certificate = certify(claiming(log, completed=False, preference=None))
    assert certificate.confirmed and {check.name for check in certificate.findings} == wrong
    hidden = replace(log, speeds=np.zeros_like(log.speeds))
    assert "joint speeds" in refutations(claiming(hidden, completed=False, preference=None))


def test_an_arm_in_the_wrong_place_touches_what_it_should_not(arch_log: Log) -> None:
    first = arch_log.about.joints["joint1"]
    qpos = arch_log.qpos.copy()
    low = int(np.argmin(np.abs(arch_log.times - arch_log.about.actions[1].start - 1.5)))
    qpos[low, first + 1] += 0.25
    words = refutations(replace(arch_log, qpos=qpos))["contacts"]
    time = float(re.fullmatch(r".* touches .* at ([0-9.]+) s", words)[1])
    assert arch_log.times[low - 1] <= time <= arch_log.times[low + 1]


@pytest.mark.parametrize(
    ("time", "other", "refuted"),
    [(3.9, "green", True), (4.5, "green", False), (4.5, "blue", True), (9.0, "green", True)],
)
def test_a_touch_that_the_log_tells_counts_unless_a_fault_threw_the_object_at_the_arm(
    arch_log: Log, time: float, other: str, refuted: bool
) -> None:
    fault = Event(4.0, "fault", {"fault": "knock:green@2"})
    touch = Event(time, "contact", {"moving": "hand", "other": other})
    log = telling(arch_log, events=(*arch_log.about.events, fault, touch))
    words = f"hand touched {other} at {time:.2f} s, according to the log"
    check = check_contacts(log, RecordedWorld(log), [fault])
    assert check.holds != refuted and (words == check.words) == refuted
    # The states do not show this fault, so that the certificate lets it excuse nothing.
    assert refuted or refutations(log)["contacts"] == words


def test_a_bystander_may_not_be_touched_by_the_fingers(arch_log: Log) -> None:
    """The log claims that pink is handled while the fingers hold blue."""
    actions = tuple(replace(a, action=a.action.replace("blue", "green")) for a in arch_log.about.actions)
    found = refutations(telling(arch_log, actions=actions))
    assert "touches blue" in found["contacts"]


def test_the_arm_may_not_touch_itself(arch_log: Log) -> None:
    qpos = arch_log.qpos.copy()
    qpos[40, [arch_log.about.joints[name] for name in PANDA.joints]] = [0.0, 0.0, 0.0, -3.05, 0.0, 0.3, 0.78]
    link = r"(hand|left_finger|right_finger|link\d)"
    assert re.match(f"{link} touches {link} at", refutations(replace(arch_log, qpos=qpos))["contacts"])


def test_a_load_that_brushes_a_bystander_on_its_way_is_refuted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The controller lets the load brush the can on top of a tower, and its log has no event for this contact."""
    can_top = 0.06 + 0.045 + 0.06
    monkeypatch.setattr(transfer, "check_path", lambda *args, **options: None)
    monkeypatch.setattr(transport, "transfer_height", lambda *args, **options: can_top + 0.0225 - GRAZE_M)
    log = log_of_run(loads(PAST_A_TOWER, name="can"))
    silent = telling(log, events=tuple(event for event in log.about.events if event.kind != "contact"))
    assert len(silent.about.events) < len(log.about.events)
    assert refutations(silent)["contacts"].startswith("cup touches can at ")


@pytest.mark.parametrize(("factor", "frames", "holds"), [(1.9, 1, True), (1.9, 2, False), (2.6, 1, False)])
def test_a_pad_is_pressed_harder_for_no_longer_than_an_impact(
    arch_log: Log, factor: float, frames: int, holds: bool
) -> None:
    dynamics, forces = Dynamics(arch_log, RecordedWorld(arch_log)), arch_log.pad_forces.copy()
    first = next(k for k in range(1, len(forces)) if forces[k - 1 : k + 3].min() > 14)
    forces[first : first + frames, 0] *= factor
    assert check_grip(replace(arch_log, pad_forces=forces), dynamics).holds == holds


def test_what_spins_about_a_centre_of_mass_beside_its_middle_falls_freely(arch_log: Log) -> None:
    """MuJoCo tells the velocity of the middle, which circles."""
    log = telling(arch_log, setting={"seed": 4, "perturbation": "position=5,angle=5,centre=15"})
    world = RecordedWorld(log)
    data, states = mujoco.MjData(world.mujoco), []
    data.qpos[:], data.ctrl[:] = world.qpos[0], log.controls[0] / COMMANDS_PER_UNIT
    data.joint("pink").qpos[:3], data.joint("pink").qvel[3:] = [0.8, 0, 1.5], [20, 5, 30]
    for _ in range(10):
        states.append((data.time, data.qpos.copy(), data.qvel.copy()))
        mujoco.mj_step(world.mujoco, data, 17)
    times, qpos, qvel = (np.array(rows) for rows in zip(*states, strict=True))
    hovering = qpos.copy()
    hovering[:, world.mujoco.joint("pink").qposadr[0] + 2] = 1.5
    still = np.where(np.arange(qvel.shape[1]) == world.mujoco.joint("pink").dofadr[0] + 2, 0, qvel)
    found = []
    for places, rates in ((qpos, qvel), (hovering, still)):
        flight = replace(log, times=times, qpos=places, qvel=rates, interventions=log.interventions[:0])
        there = RecordedWorld(flight)
        found.append(check_motions(there, Dynamics(flight, there)))
    assert found[0].holds and found[1].words == "nothing touches pink at 0.03 s, but it does not fall freely"


def test_what_flies_into_the_hand_between_two_states_meets_the_robot(arch_log: Log) -> None:
    world = RecordedWorld(arch_log)
    dynamics, k = Dynamics(arch_log, world), world.frame_at(1.0)
    assert "panda" not in dynamics.may_meet("pink", k)
    world.show(k)
    palm = world.pointed_at(np.array([-0.08]))[0]
    joint, span = world.mujoco.joint("pink"), np.diff(dynamics.times)[k]
    place, dof = int(joint.qposadr[0]), int(joint.dofadr[0])
    dynamics.qvel[k, dof : dof + 3] = (palm - dynamics.qpos[k, place : place + 3]) / span
    assert "panda" in dynamics.may_meet("pink", k)
