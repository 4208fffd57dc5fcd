"""How the arm and the objects moved, judged from a log: joint limits, leaps of objects, unwanted contacts."""

from __future__ import annotations

import numpy as np

from sim.evidence.check import Check
from sim.evidence.log import Log
from sim.evidence.replay import HOLD_FORCE_N, RecordedWorld
from sim.robots.robot import Robot
from sim.simulation.rollout import FRAME_RATE

OBJECT_SPEED_LIMIT = 3.0
"""No object moves faster, m/s: the hand does not, and nothing falls from higher than the arm lifts it."""

ROUNDING = 1e-6
"""Slack for comparisons of recorded numbers."""

TIME_TO_REST = 2.0
"""What a fault throws about comes to rest within this time, s."""

LEAP_WINDOW = 0.1
"""A leap this near to a recorded fault that moves the object is that fault's doing, s."""


def check_recording(log: Log) -> Check:
    """Check that frames follow each other without a gap, and actions within them."""
    name, times = "recording", log.times
    period = np.diff(times)
    gaps = np.flatnonzero((period <= 0) | (period > 1.5 / FRAME_RATE))
    if times[0] > ROUNDING or len(gaps):
        where = float(times[gaps[0]]) if len(gaps) else 0.0
        return Check(name, False, f"frames are missing or out of order after {where:.2f} s")
    end = float(times[-1])
    before = 0.0
    for k, action in enumerate(log.about.actions, 1):
        if not before - ROUNDING <= action.start <= action.end:
            return Check(name, False, f"action {k} `{action.action}` begins before the one before it ends")
        if action.end > end + 1.5 / FRAME_RATE:
            return Check(
                name,
                False,
                f"it ends at {end:.2f} s, but action {k} `{action.action}` is said to end at {action.end:.2f} s",
            )
        before = action.end
    return Check(name, True, f"{len(times)} frames, {end:.1f} s, {len(log.about.actions)} actions")


def check_limits(log: Log, world: RecordedWorld) -> list[Check]:
    """Check the arm's joint positions, speeds and torques against their limits."""
    angles, robot = world.arm(), world.robot
    low, high = robot.ranges(world.mujoco).T
    middle, half = (low + high) / 2, (high - low) / 2
    checks = [_within("joint positions", np.abs(angles - middle) / half, log.times, robot)]
    # What was recorded as a joint's greatest speed cannot be less than its mean speed.
    mean = np.abs(np.diff(angles, axis=0)) / np.diff(log.times)[:, None]
    hidden = np.argwhere(mean > log.speeds[1:] + 1e-3)
    if len(hidden):
        frame, joint = hidden[0]
        words = (
            f"{robot.joints[joint]} moves at {mean[frame, joint]:.2f} rad/s at {log.times[frame]:.2f} s, "
            f"where at most {log.speeds[frame + 1, joint]:.2f} rad/s are recorded"
        )
        checks.append(Check("joint speeds", False, words))
    else:
        checks.append(_within("joint speeds", log.speeds / robot.velocity_limits, log.times, robot))
    checks.append(_within("joint torques", log.torques / robot.torque_limits, log.times, robot))
    return checks


def _within(name: str, shares: np.ndarray, times: np.ndarray, robot: Robot) -> Check:
    """Return whether shares of a limit, (T, n), stay below 1."""
    frame, joint = np.unravel_index(int(shares.argmax()), shares.shape)
    most = f"{shares[frame, joint]:.1%} of the limit, {robot.joints[joint]} at {times[frame]:.2f} s"
    return Check(name, bool(shares.max() <= 1), f"at most {most}" if shares.max() <= 1 else f"exceeded: {most}")


def check_leaps(log: Log, world: RecordedWorld) -> Check:
    """Check that no object leaps, but for one that a recorded fault moves just then."""
    name = "objects"
    fastest = 0.0
    for obj in (known.name for known in world.model.objects):
        steps = np.linalg.norm(np.diff(world.path(obj), axis=0), axis=1)
        excused = [event.time for event in log.about.events if event.kind == "fault" and _names(event.detail, obj)]
        for frame in np.flatnonzero(steps > OBJECT_SPEED_LIMIT * np.diff(log.times)):
            time = float(log.times[frame + 1])
            if not any(abs(time - moved) <= LEAP_WINDOW for moved in excused):
                words = f"{obj} leaps {steps[frame]:.3f} m at {time:.2f} s, and no recorded fault explains it"
                return Check(name, False, words)
        fastest = max(fastest, float(steps.max(initial=0.0)) * FRAME_RATE)
    return Check(name, True, "none leaps" if fastest > OBJECT_SPEED_LIMIT else f"none leaps; {fastest:.2f} m/s at most")


def _names(detail: dict[str, object], obj: str) -> bool:
    """Return whether the fault of an event, such as `move:pink@3`, is about an object."""
    return str(detail.get("fault")).partition("@")[0].partition(":")[2] == obj


def check_contacts(log: Log, world: RecordedWorld) -> Check:
    """Check every frame for unwanted contacts of the robot or its load.

    The fingers may touch the object that the present action is about; what is being transported may touch them alone.
    An object that a recorded fault has thrown about just before may touch anything.
    """
    name = "contacts"
    for event in log.about.events:
        if event.kind == "contact" and _thrown(log, world, event.time).isdisjoint(map(str, event.detail.values())):
            words = f"{event.detail.get('moving')} touched {event.detail.get('other')} at {event.time:.2f} s"
            return Check(name, False, f"{words}, the log itself says")
    for frame, time in enumerate(log.times):
        world.show(frame)
        obj, carried = _handled(log, world, float(time))
        found = world.touches(obj, aloft=carried and bool(log.pad_forces[frame].min() > HOLD_FORCE_N))
        if found:
            thrown = _thrown(log, world, float(time))
            found = [pair for pair in found if thrown.isdisjoint(pair)]
        if found:
            moving, other = found[0]
            return Check(name, False, f"{moving} touches {other} at {time:.2f} s")
    return Check(name, True, f"none but with what is grasped; {len(log.times)} frames looked at, with {world.dressed}")


def _thrown(log: Log, world: RecordedWorld, time: float) -> set[str]:
    """Return the objects that faults have moved, knocked over or let slip within `TIME_TO_REST` before a time."""
    thrown = set()
    for event in log.about.events:
        if event.kind == "fault" and 0 <= time - event.time <= TIME_TO_REST:
            kind, _, target = str(event.detail.get("fault")).partition("@")[0].partition(":")
            obj = _handled(log, world, event.time)[0] if kind == "slip" else target
            if obj and kind in ("move", "knock", "slip"):
                thrown.add(obj)
    return thrown


def _handled(log: Log, world: RecordedWorld, time: float) -> tuple[str | None, bool]:
    """Return the object that the action at a time, or the one before it, is about, and whether that carries it."""
    begun = [action for action in log.about.actions if action.start <= time]
    action = world.action(begun[-1].action) if begun else None
    if action is None or not action.obj:
        return None, False
    return action.obj, world.model.operator(action.kind).travels
