"""Checks of the faults in a log: each must have been requested, and the states must show its effect."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from prefplan.claims import Check
from prefplan.models.manipulation.symbolic import holding
from sim.evidence.log import Log
from sim.evidence.replay import HOLD_FORCE_N, PRESS_MEMORY_FRAMES, RecordedWorld
from sim.evidence.resimulation import Change
from sim.simulation.run import Event

FAULT_KINDS = {"slip", "move", "knock", "miss", "foreign", "blind"}
"""Kinds of faults; on purpose, nothing here is shared with the code that injects them. A kind of one's own, of which no
state shows an effect, is added."""

FAULT_TIME_S = 1e-6
"""Greatest difference between the time of a fault and that of the state it leaves."""

UNMOVED_M = 0.02
"""Greatest distance by which a knock moves an object at once, m: it changes the velocity alone."""

SLIP_OPENING_M = 0.01
"""In a slip, the gripper is commanded open wider than the fingers are by at least this, m."""


def check_faults(log: Log, world: RecordedWorld, changes: Sequence[Change]) -> tuple[Check, list[tuple[float, str]]]:
    """Check that faults were requested, that changes from outside show them, and that there is no other change.

    Returns:
        The check, and of each fault that the states show, the time, s, and the object that it moved or let slip.
    """
    asked = Counter(map(str, log.about.setting.get("faults") or ()))
    told = [event for event in log.about.events if event.kind == "fault"]
    objections, shown = [], list[tuple[float, str]]()
    for event in told:
        fault = str(event.detail.get("fault"))
        asked[fault] -= 1
        objection = _objection(event, told, log, world, changes) if asked[fault] >= 0 else "it was not asked for"
        if objection:
            objections.append(f"{fault} at {event.time:.2f} s: {objection}")
        elif obj := _slipped(log, world, event) if _kind(event) == "slip" else _moved_by(event):
            shown.append((event.time, obj))
    for change in changes:
        excused = {_moved_by(event) for event in told if _at_once(event, change)}
        for joint in sorted(change.moved.keys() - excused):
            objections.append(f"{joint} was moved from outside at {change.time:.2f} s, and no recorded fault says so")
    words = f"{len(told)}, as asked for, and the states show them" if told else "none"
    return Check("faults", not objections, objections[0] if objections else words), shown


def _at_once(one: Event | Change, other: Event | Change) -> bool:
    return abs(one.time - other.time) < FAULT_TIME_S


def _kind(event: Event) -> str:
    return re.split("[:@]", str(event.detail.get("fault")))[0]


def _moved_by(event: Event) -> str:
    """Return the object that a fault moves from outside, according to its event; empty if it moves none."""
    fault = str(event.detail.get("fault")).partition("@")[0]
    if _kind(event) == "foreign":
        return str(event.detail.get("object"))
    return fault.partition(":")[2] if _kind(event) in ("move", "knock") else ""


def _slipped(log: Log, world: RecordedWorld, event: Event) -> str:
    """Return the object of the last action that had begun at an event."""
    begun = [action.start <= event.time for action in log.about.actions]
    return world.actions[sum(begun) - 1].obj if any(begun) else ""


def _objection(
    event: Event, told: Sequence[Event], log: Log, world: RecordedWorld, changes: Sequence[Change]
) -> str | None:
    """Return why a fault did not happen, or None; no state shows a `blind` camera."""
    kind, due = _kind(event), str(event.detail.get("fault")).rpartition("@")[2]
    begun = sum(action.start <= event.time + FAULT_TIME_S for action in log.about.actions)
    if kind not in FAULT_KINDS:
        return "there is no such fault"
    if not due.isdecimal() or begun < int(due):
        return "it was not due yet"
    if kind == "slip":
        return _objection_to_slip(event, log, world)
    if kind == "miss":
        return _objection_to_miss(event, log, world)
    obj = _moved_by(event)
    return _objection_to_change(event, obj, told, changes) if obj else None


def _objection_to_change(event: Event, obj: str, told: Sequence[Event], changes: Sequence[Change]) -> str | None:
    """Return why a fault did not move an object from outside, or None."""
    change = next((one for one in changes if _at_once(one, event)), None)
    if change is None or obj not in change.moved:
        return f"no state shows that {obj} is moved from outside"
    kinds = {_kind(other) for other in told if _moved_by(other) == obj and _at_once(other, event)}
    if kinds == {"knock"} and change.moved[obj] > UNMOVED_M:
        return f"{obj} jumps to another place, which a knock does not do"
    return None


def _objection_to_slip(event: Event, log: Log, world: RecordedWorld) -> str | None:
    frame, gripper = world.frame_at(event.time), world.robot.gripper
    if world.pad_forces[max(0, frame - PRESS_MEMORY_FRAMES) : frame + 1].min(axis=1).max() <= HOLD_FORCE_N:
        return "nothing was in the hand"
    fingers = [int(world.mujoco.joint(name).qposadr[0]) for name in gripper.joints]
    # The hand is told to open at once, and opens later by the latency.
    last = world.frame_at(event.time + world.scene.latency) + 1
    widths = [gripper.width(float(command)) for command in world.grips[frame + 1 : last + 1]]
    opened = max(widths, default=0.0) > gripper.opened(log.qpos[frame, fingers]) + SLIP_OPENING_M
    return None if opened else "the hand was not commanded open"


def _objection_to_miss(event: Event, log: Log, world: RecordedWorld) -> str | None:
    for action, symbolic in zip(log.about.actions, world.actions, strict=True):
        if symbolic.kind == "grasp" and action.end > event.time:
            return f"`{action.action}` succeeded" if holding(symbolic.obj) in action.label else None
    return None
