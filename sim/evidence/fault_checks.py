"""Checks of the faults in a log: each must have been requested, and the states must show its effect."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from prefplan.claims import Check
from prefplan.models.manipulation.symbolic import holding
from sim.evidence.log import Log
from sim.evidence.replay import HOLD_FORCE_N, PRESS_MEMORY_FRAMES, RecordedWorld
from sim.evidence.resimulation import Change
from sim.simulation.run import Event

FAULT_KINDS = {"slip", "move", "knock", "miss", "foreign", "blind"}
"""Kinds of faults; on purpose, nothing here is shared with the code that injects them. Users may add kinds of their own
whose effect no state shows."""

FAULT_TIME_S = 1e-6
"""Greatest difference between the time of a fault and the time of the state that it sets, s."""

UNMOVED_M = 0.02
"""Greatest distance by which a knock moves an object at once, m: a knock changes only the velocity."""

SLIP_OPENING_M = 0.01
"""Least increase of the gripper's commanded width in a slip, m."""


@dataclass(frozen=True)
class _Fault:
    """A logged fault, due with action `due`, after `begun` have begun; `obj` is what it moves from outside, or ""."""

    text: str
    time: float
    kind: str
    obj: str
    due: int
    begun: int

    def shows_in(self, change: Change) -> bool:
        """Return whether a change moves the fault's object at the fault's time."""
        return self.obj == change.joint and abs(self.time - change.time) < FAULT_TIME_S


def check_faults(log: Log, world: RecordedWorld, changes: Sequence[Change]) -> tuple[Check, list[tuple[float, str]]]:
    """Check that faults were requested, that changes from outside show them, and that there is no other change.

    Returns:
        The check; and for each fault that the states show, its time, s, and the object that it moved or let slip.
    """
    told = [_read(event, log) for event in log.about.events if event.kind == "fault"]
    wanted, found = Counter(map(str, log.about.setting.get("faults") or ())), Counter(fault.text for fault in told)
    unasked, missing = found - wanted, sorted((wanted - found).elements())
    objections, shown = list[str](), list[tuple[float, str]]()
    for fault in told:
        objection = "it was not asked for" if fault.text in unasked else _objection(fault, log, world, changes)
        if objection:
            objections.append(f"{fault.text} at {fault.time:.2f} s: {objection}")
        elif obj := world.actions[fault.begun - 1].obj if fault.kind == "slip" else fault.obj:
            shown.append((fault.time, obj))
    for change in changes:
        kinds = {fault.kind for fault in told if fault.shows_in(change)}
        when = f"at {change.time:.2f} s"
        if not kinds:
            objections.append(f"{change.joint} was moved from outside {when}, and no recorded fault says so")
        elif kinds == {"knock"} and change.far > UNMOVED_M:
            objections.append(f"{change.joint} jumps to another place {when}, which a knock does not do")
    words = f"{len(told)}, as asked for, and the states show them" if told else "none"
    words += f"; asked for, too, but not done: {', '.join(missing)}" if missing else ""
    return Check("faults", not objections, objections[0] if objections else words), shown


def _read(event: Event, log: Log) -> _Fault:
    """Return the fault in an event; its kind is empty if the event cannot be read."""
    text = str(event.detail.get("fault"))
    parts = re.fullmatch(r"([^:@]+):?(.*)@(\d+)", text)
    kind, argument, due = parts.groups() if parts else ("", "", "0")
    obj = argument if kind in ("move", "knock") else str(event.detail.get("object")) if kind == "foreign" else ""
    begun = sum(action.start <= event.time + FAULT_TIME_S for action in log.about.actions)
    return _Fault(text, event.time, kind, obj, int(due), begun)


def _objection(fault: _Fault, log: Log, world: RecordedWorld, changes: Sequence[Change]) -> str | None:
    """Return why a fault did not happen as logged, or None; no state shows a `blind` camera."""
    if fault.kind not in FAULT_KINDS:
        return "there is no such fault"
    if fault.begun < fault.due:
        return "it was not due yet"
    if fault.kind == "slip":
        frame = world.frame_at(fault.time)
        if world.pad_forces[max(0, frame - PRESS_MEMORY_FRAMES) : frame + 1].min(axis=1).max() <= HOLD_FORCE_N:
            return "nothing was in the hand"
        # The hand is commanded to open at once; the command reaches it after the latency.
        last = world.frame_at(fault.time + world.scene.latency) + 1
        first, *widths = (world.robot.gripper.width(float(command)) for command in world.grips[frame : last + 1])
        return None if max(widths, default=0.0) > first + SLIP_OPENING_M else "the hand was not commanded open"
    if fault.kind == "miss":
        for action, symbolic in zip(log.about.actions, world.actions, strict=True):
            if symbolic.kind == "grasp" and action.end > fault.time:
                return f"`{action.action}` succeeded" if holding(symbolic.obj) in action.label else None
    if fault.obj and not any(map(fault.shows_in, changes)):
        return f"no state shows that {fault.obj} is moved from outside"
    return None
