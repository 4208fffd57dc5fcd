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
from sim.evidence.log import Log
from sim.evidence.motion_checks import check_limits
from sim.evidence.replay import RecordedWorld
from sim.evidence.touch_checks import Touches, check_contacts
from sim.geometry.mjcf import columns
from sim.perception.grounding import observe
from sim.perception.sensors import true_poses
from sim.robots.arms.panda import PANDA
from sim.robots.robot import Robot
from sim.simulation.recorder import COMMANDS_PER_UNIT
from sim.simulation.run import Event
from sim.skills import transfer, transport
from sim.world.shapes import CUBE_EDGE_M

GRAZE_M = 0.002
"""How deep a load penetrates another object as it passes over it, m."""


@pytest.mark.usefixtures("claims_alone")
def test_what_no_location_was_seen_to_mark_was_not_marked(arch_log: Log) -> None:
    found = refutations(replace(arch_log, glow=np.full_like(arch_log.glow, -1)))
    assert "log says pink_sanitized" in found["action 4"]
    assert found["completed"] == "not satisfied: phi1, phi2"


@pytest.mark.parametrize(
    ("start", "end", "words"),
    [
        (-0.5, 0.0, "`grasp pink`: it begins before the one before it ends"),
        (0.0, 99.0, r"`grasp pink`: it ends at .* s, the frames at .* s"),
    ],
)
def test_actions_follow_each_other_within_the_frames(arch_log: Log, start: float, end: float, words: str) -> None:
    first, second, *others = arch_log.about.actions
    moved = replace(second, start=second.start + start, end=second.end + end)
    found = refutations(telling(arch_log, actions=(first, moved, *others)))
    assert re.fullmatch(words, found["action 2"])


@pytest.mark.parametrize(
    ("name", "joint"),
    [("speeds", 0), ("accelerations", 1), ("jerks", 2), ("torques", 3), ("torques", 6), ("torque_rates", 5)],
)
def test_a_limit_that_was_passed_is_told(arch_log: Log, name: str, joint: int) -> None:
    loads = {load: np.zeros((len(arch_log.times), 7)) for load in PANDA.load_limits}
    loads[name][100, joint] = 1.01 * np.asarray(PANDA.load_limits[name])[joint]
    (check,) = (one for one in check_limits(arch_log, RecordedWorld(arch_log), loads) if not one.holds)
    assert check.name == f"joint {name.replace('_', ' ')}"
    assert check.words == f"exceeded: 101.0% of the limit, {PANDA.joints[joint]} at {arch_log.times[100]:.2f} s"


def test_limits_are_those_of_what_the_commands_lead_to(arch_log: Log) -> None:
    """A jerk in the commands shows although nothing is recorded of it."""
    controls = arch_log.controls.copy()
    controls[1000:, 0] += COMMANDS_PER_UNIT // 100
    found = refutations(replace(arch_log, controls=controls))
    assert "joint1 at" in found["joint jerks"] and "simulated again" in found


def test_what_a_failed_run_did_is_a_finding_and_no_lie(arch_log: Log, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same limit and the same touch refute a run that claims to be completed."""
    limits = dict(PANDA.load_limits)
    limits["torque_rates"] = np.asarray(limits["torque_rates"]) / 100
    monkeypatch.setattr(Robot, "load_limits", property(lambda self: limits))
    touch = Event(3.9, "contact", {"moving": "hand", "other": "green"})
    told = sorted((*arch_log.about.events, touch), key=lambda event: event.time)
    log = telling(arch_log, events=tuple(told))
    wrong = {"joint torque rates", "contacts"}
    assert refutations(log).keys() == wrong and certify(log).findings == ()
    certificate = certify(claiming(log, completed=False, preference=None))
    assert {check.name for check in certificate.findings} == wrong and certificate.refuted == ()


def touched_by(log: Log, frame: int, qpos: np.ndarray) -> str:
    """Return the first unwanted contact in a state, at a frame of a log, in words."""
    world = RecordedWorld(log)
    touches, data = Touches(log, world), mujoco.MjData(world.mujoco)
    data.qpos[:], data.time = qpos, log.times[frame]
    touches.look(data, frame, recorded=True)
    return check_contacts(log, touches, []).words


@pytest.mark.parametrize(("gap", "holds"), [(20, True), (3, False)])
def test_an_object_that_is_set_down_and_grasped_again_may_touch_its_support(
    arch_log: Log, gap: int, holds: bool
) -> None:
    grasp = arch_log.about.actions[1]
    first, last = (int(np.searchsorted(arch_log.times, time)) for time in (grasp.start, grasp.end))
    assert last - first > 40
    # The pads press it in the air, after a gap at its place, and in the air again.
    again = first + 10 + gap
    height, qpos = arch_log.about.joints["pink"] + 2, arch_log.qpos.copy()
    qpos[first:again, height] += 0.1
    qpos[again + 1 : last + 1, height] += 0.1
    log = replace(arch_log, qpos=qpos)
    world = RecordedWorld(log)
    touches, data = Touches(log, world), mujoco.MjData(world.mujoco)
    world.pad_forces[[*range(first, first + 10), *range(again, last + 1)]] = 5.0
    data.qpos[:], data.time = qpos[again], log.times[again]
    touches.look(data, again, recorded=True)
    assert check_contacts(log, touches, []).holds == holds


def test_an_arm_in_the_wrong_place_touches_what_it_should_not(arch_log: Log) -> None:
    first = arch_log.about.joints["joint1"]
    qpos = arch_log.qpos.copy()
    low = int(np.argmin(np.abs(arch_log.times - arch_log.about.actions[1].start - 1.5)))
    qpos[low, first + 1] += 0.25
    assert re.fullmatch(f".* touches .* at {arch_log.times[low]:.2f} s", touched_by(arch_log, low, qpos[low]))
    assert "touches" not in touched_by(arch_log, low, arch_log.qpos[low])
    words = refutations(replace(arch_log, qpos=qpos))["simulated again"]
    assert words.endswith(f"first at {arch_log.times[low]:.2f} s"), "and no command leads there"


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
    world = RecordedWorld(log)
    check = check_contacts(log, Touches(log, world), [(fault.time, "green")])
    assert check.holds != refuted and (words == check.words) == refuted
    # The states do not show this fault, so that the certificate lets it excuse nothing.
    assert refuted or refutations(log)["contacts"] == words


@pytest.mark.parametrize(("near", "far"), [("blue", "pink"), ("pink", "blue")])
def test_where_one_object_may_be_only_the_nearer_of_two_rests(arch_log: Log, near: str, far: str) -> None:
    world, qpos = RecordedWorld(arch_log), arch_log.qpos.copy()
    for obj, off in ((near, -0.02), (far, 0.03)):
        pose, _ = columns(world.mujoco, obj)
        qpos[0, pose] = [*world.scene.slots["san"][0].position + [off, 0.0, CUBE_EDGE_M / 2], 1.0, 0.0, 0.0, 0.0]
    world = RecordedWorld(replace(arch_log, qpos=qpos))
    world.show(0)
    assert world.resting(None) == {near: "san", "green": "right"}


def test_frames_show_the_places_that_a_run_observes(arch_log: Log) -> None:
    """Objects are in slots or on each other, off by centimetres; some are on one of two supports alone."""
    rng, world, qpos = np.random.default_rng(0), RecordedWorld(arch_log), arch_log.qpos.copy()
    data, slots = mujoco.MjData(world.mujoco), [slot for row in world.scene.slots.values() for slot in row]
    seen, frame = [], 0
    while frame < len(qpos):
        data.qpos[:] = qpos[frame]
        for obj in rng.permutation(world.objects):
            below = data.body(str(rng.choice(world.objects))).xpos + [0.0, 0.0, CUBE_EDGE_M / 2]
            base = below if rng.random() < 0.3 else slots[rng.integers(len(slots))].position
            pose, _ = columns(world.mujoco, str(obj))
            off = np.array([*rng.normal(0, 0.025, 2), CUBE_EDGE_M / 2 + rng.normal(0, 0.003)])
            data.qpos[pose] = [*base + off, 1.0, 0.0, 0.0, 0.0]
            mujoco.mj_fwdPosition(world.mujoco, data)
        if not (data.contact.dist[: data.ncon] < -0.004).any():
            poses = {obj: pose for obj, pose in true_poses(world.scene, data).items() if obj in world.objects}
            seen.append(observe(world.scene, data, poses, hand="home", held=None).place)
            qpos[frame], frame = data.qpos, frame + 1
    world = RecordedWorld(replace(arch_log, qpos=qpos))
    for frame, places in enumerate(seen):
        world.show(frame)
        assert world.resting(None) == places
    assert sum("top" in places.values() for places in seen) > len(seen) / 20


def test_an_object_is_held_only_while_all_pads_press_it(arch_log: Log) -> None:
    world = RecordedWorld(arch_log)
    frame = world.frame_at(arch_log.about.actions[2].end)  # `transport pink san`
    world.show(frame)
    held = []
    for forces in ((10.0, 10.0), (10.0, 0.0), (0.0, 10.0), (0.0, 0.0)):
        world.pad_forces[:] = forces
        held.append(world.held())
    assert held == ["pink", None, None, None]


def test_a_bystander_may_not_be_touched_by_the_fingers(arch_log: Log) -> None:
    """The log claims that pink is handled while the fingers hold blue."""
    actions = tuple(replace(a, action=a.action.replace("blue", "green")) for a in arch_log.about.actions)
    found = refutations(telling(arch_log, actions=actions))
    assert "touches blue" in found["contacts"]


def test_the_arm_may_not_touch_itself(arch_log: Log) -> None:
    qpos = arch_log.qpos.copy()
    qpos[40, [arch_log.about.joints[name] for name in PANDA.joints]] = [0.0, 0.0, 0.0, -3.05, 0.0, 0.3, 0.78]
    link = r"(hand|left_finger|right_finger|link\d)"
    assert re.match(f"{link} touches {link} at", touched_by(arch_log, 40, qpos[40]))
    assert "simulated again" in refutations(replace(arch_log, qpos=qpos))


def test_a_load_that_brushes_a_bystander_on_its_way_is_refuted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The controller lets the load brush the can on top of a tower, and its log has no event for this contact."""
    can_top = 0.06 + 0.045 + 0.06
    monkeypatch.setattr(transfer, "check_path", lambda *args, **options: None)
    monkeypatch.setattr(transport, "transfer_height", lambda *args, **options: can_top + 0.0225 - GRAZE_M)
    log = log_of_run(loads(PAST_A_TOWER, name="can"))
    silent = telling(log, events=tuple(event for event in log.about.events if event.kind != "contact"))
    assert len(silent.about.events) < len(log.about.events)
    assert refutations(silent)["contacts"].startswith("cup touches can at ")
