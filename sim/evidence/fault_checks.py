"""Checks of the faults in a log: each must have been requested, and the states must show its effect."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from prefplan.claims import Check
from prefplan.models.manipulation.symbolic import holding
from sim.evidence.log import Log
from sim.evidence.replay import FAULT_TIME_S, HOLD_FORCE_N, PRESS_MEMORY_FRAMES, RecordedWorld
from sim.evidence.resimulation import Change
from sim.geometry.mjcf import columns
from sim.simulation.run import FRAME_RATE_HZ, Event

FAULT_KINDS = {"slip", "move", "knock", "miss", "foreign", "blind"}
"""Kinds of faults; on purpose, nothing here is shared with the code that injects them. A kind of one's own, of which no
state shows an effect, is added."""

PUSH_SPEEDS_M_S, TOSS_SPEEDS_M_S, SPINS_RAD_S = (0.24, 0.61), (0.59, 0.61), (7.9, 14.1)
"""Ranges of the horizontal, upward and rotational speeds that a knock gives an object."""

UNMOVED_M = 0.02
"""Greatest distance that a knocked object covers in a frame beyond what its own speed allows, m."""

UPRIGHT = 1e-6
"""Greatest x and y of the quaternion of an object that a fault puts down: it is rotated about z alone."""

SLIP_OPENING_M = 0.01
"""In a slip, the gripper is commanded open wider than the fingers are by at least this, m."""


@dataclass(frozen=True)
class _Pose:
    """Position, (3,) m, and quaternion, (4,), of an object, and its velocity, (6,) m/s and rad/s."""

    position: np.ndarray
    rotation: np.ndarray
    velocity: np.ndarray


def shown_faults(log: Log, world: RecordedWorld, changes: Sequence[Change]) -> list[Event]:
    """Return the faults that were requested and that the states show, in order of time."""
    return [event for event, objection in _judged(log, world, changes) if objection is None]


def check_faults(log: Log, world: RecordedWorld, changes: Sequence[Change]) -> Check:
    """Check that faults were requested, that changes from outside show them, and that there is no other change."""
    name = "faults"
    told = []
    for event, objection in _judged(log, world, changes):
        told.append(event)
        if objection:
            return Check(name, False, f"{event.detail.get('fault')} at {event.time:.2f} s: {objection}")
    for change in changes:
        wrong = sorted(change.joints - world.excused(change.time))
        if wrong:
            words = f"{wrong[0]} was moved from outside at {change.time:.2f} s, and no recorded fault says so"
            return Check(name, False, words)
    return Check(name, True, f"{len(told)}, as asked for, and the states show them" if told else "none")


def _judged(log: Log, world: RecordedWorld, changes: Sequence[Change]) -> Iterator[tuple[Event, str | None]]:
    """Yield each fault in the log, and why it did not happen, or None."""
    asked = Counter(map(str, log.about.setting.get("faults") or ()))
    for event in log.about.events:
        if event.kind == "fault":
            fault = str(event.detail.get("fault"))
            asked[fault] -= 1
            yield event, _objection(event, log, world, changes) if asked[fault] >= 0 else "it was not asked for"


def _objection(event: Event, log: Log, world: RecordedWorld, changes: Sequence[Change]) -> str | None:
    """Return why a fault did not happen, or None; no state shows a `blind` camera."""
    kind, _, due = re.sub(":[^@]*", "", str(event.detail.get("fault"))).partition("@")
    begun = [action for action in log.about.actions if action.start <= event.time + FAULT_TIME_S]
    if kind not in FAULT_KINDS:
        return "there is no such fault"
    if not due.isdecimal() or len(begun) < int(due):
        return "it was not due yet"
    if kind == "slip":
        return _objection_to_slip(event, log, world)
    if kind == "miss":
        return _objection_to_miss(event, log, world)
    for obj in world.disturbed(event):
        change = next((one for one in changes if abs(one.time - event.time) < FAULT_TIME_S), None)
        if change is None or obj not in change.joints:
            return f"no state shows that {obj} is moved from outside"
        before, after = (_pose(obj, world, *state) for state in (change.before, change.after))
        if _is_moved_twice(log, world, event, obj):
            continue
        if kind == "knock":
            return _objection_to_knock(obj, before, after)
        if kind == "foreign" and before.position[2] > 0:
            return f"{obj} was on the table before"
        return _objection_to_move(obj, after)
    return None


def _is_moved_twice(log: Log, world: RecordedWorld, event: Event, obj: str) -> bool:
    """Return whether several faults act on an object at once, so that no state shows each alone."""
    events = [other for other in log.about.events if abs(other.time - event.time) < FAULT_TIME_S]
    return sum(obj in world.disturbed(other) for other in events) > 1


def _pose(obj: str, world: RecordedWorld, qpos: np.ndarray, qvel: np.ndarray) -> _Pose:
    pose, rates = columns(world.mujoco, obj)
    position, rotation = np.split(qpos[pose], [3])
    return _Pose(position, rotation, qvel[rates])


def _objection_to_knock(obj: str, before: _Pose, after: _Pose) -> str | None:
    falling = float(np.linalg.norm(before.velocity[:3])) / FRAME_RATE_HZ
    if np.linalg.norm(after.position - before.position) > UNMOVED_M + falling:
        return f"{obj} jumps to another place, which a knock does not do"
    speeds = [float(np.linalg.norm(part)) for part in np.split(after.velocity, [2, 3])]
    ranges = (PUSH_SPEEDS_M_S, TOSS_SPEEDS_M_S, SPINS_RAD_S)
    if all(low <= speed <= high for speed, (low, high) in zip(speeds, ranges, strict=True)):
        return None
    return f"{obj} gets {speeds[0]:.2f} m/s, {speeds[1]:.2f} m/s upwards and {speeds[2]:.1f} rad/s, which is no knock"


def _objection_to_move(obj: str, after: _Pose) -> str | None:
    if np.any(after.velocity != 0):
        return f"{obj} is moving when it is put down"
    if np.abs(after.rotation[1:3]).max() > UPRIGHT:
        return f"{obj} is not upright when it is put down"
    return None


def _objection_to_slip(event: Event, log: Log, world: RecordedWorld) -> str | None:
    frame, gripper = world.frame_at(event.time), world.robot.gripper
    pressed = log.pad_forces[max(0, frame - PRESS_MEMORY_FRAMES) : frame + 1].min(axis=1) > HOLD_FORCE_N
    if not np.any(pressed):
        return "nothing was in the hand"
    fingers = [int(world.mujoco.joint(name).qposadr[0]) for name in gripper.joints]
    width = gripper.opened(world.qpos[frame, fingers])
    command = float(world.command(event.time + world.scene.latency)[world.mujoco.actuator(gripper.actuator).id])
    return None if gripper.width(command) > width + SLIP_OPENING_M else "the hand was not commanded open"


def _objection_to_miss(event: Event, log: Log, world: RecordedWorld) -> str | None:
    for action in log.about.actions:
        symbolic = world.action(action.action)
        if symbolic and symbolic.kind == "grasp" and action.end > event.time:
            return f"`{action.action}` succeeded" if holding(symbolic.obj) in action.label else None
    return None
