"""Checks of the actions in a log: where the hand went, and whether recorded events agree with actions and frames."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from prefplan.claims import Check
from prefplan.logic.good_prefix import Label
from prefplan.models.manipulation.symbolic import Action, at
from sim.evidence.log import EVENTS, Log, LoggedAction
from sim.evidence.motion_checks import ROUNDING_S
from sim.evidence.replay import AT_LOCATION_M, RecordedWorld
from sim.simulation.run import Event

POINTED_M = np.linspace(0, 0.12, 13)
"""Distances ahead of the tool of the points that decide which location a hand is over, m."""

NEARER_M = 0.005
"""The hand is over a location if no other one is nearer by more than this."""

GOING_ON_M = 2 * AT_LOCATION_M
"""After a mismatch, the next action may begin at any location nearer to the hand than this, m."""

ELSEWHERE = ""
"""Stands for a place that is no location of the scenario."""

ARRIVAL_S = 0.35
"""A movement may still settle for this long after its action has ended."""

LAST_EVENT_S = 1.0
"""An event is recorded at most this long after the last frame."""

SURPRISED, ANSWERS = "mismatch", ("retry", "replan", "unaffected", "ended")
"""Kind of the event of an action without its predicted effect, and the kinds of which one must follow."""


def check_hand(log: Log, world: RecordedWorld, trace: Sequence[Label]) -> Check:
    """Check that the hand went where the actions say, and that no grasp or release lacks the move that it needs.

    Every transit and transport that succeeded must end with the hand over its location. Grasps and releases must be at
    the location to which the hand was last moved; after a mismatch, also where the frames show the hand.
    """
    answers = [event.time for event in log.about.events if event.kind in ANSWERS]
    over, since, checked = {world.model.start}, -math.inf, 0
    for k, (action, symbolic) in enumerate(zip(log.about.actions, world.actions, strict=True), 1):
        now, place, objection = action.start + ROUNDING_S, symbolic.location, None
        for time in answers:
            if since < time <= now:
                far = _distances(world, [world.frame_at(time if k > 1 else 0.0)])
                over |= {ELSEWHERE, *(near for near in far if far[near][0] < GOING_ON_M)}
        since = now
        if symbolic.kind in ("grasp", "release"):
            objection = _objection_to_hand(world, symbolic, over, trace[k - 1])
        elif world.model.operator(symbolic.kind).travels:
            over = {place}
            if place not in world.scene.slots:
                # After a mismatch, an object may lie off every location, at a temporary one.
                objection = None if min(answers, default=math.inf) <= now else "there is no such location"
            elif not any(event.kind == SURPRISED for event in _during(log, action)):
                checked += 1
                objection = _objection_to_end(world, action, place)
        if objection:
            return Check("hand", False, f"action {k} `{action.action}`: {objection}")
    return Check("hand", True, f"over the location of each of {checked} actions")


def _objection_to_hand(world: RecordedWorld, action: Action, over: set[str], label: Label) -> str | None:
    """Return which move a grasp or a release lacks, before which the frames show a label, in words, or None."""
    obj, places = action.obj, world.scene.slots.keys()
    needed = action.location or next((place for place in places if at(obj, place) in label), None)
    if needed is None:  # the object is off every location, or not in the scenario
        known = any(obj == other.name for other in world.model.objects)
        return f"no action before it brings the hand to where {obj} is" if known and over <= places else None
    return None if needed in over else f"no action before it brings the hand to {needed}"


def _objection_to_end(world: RecordedWorld, action: LoggedAction, location: str) -> str | None:
    """Return where the hand is instead at the end of an action that moves it to a location, or None."""
    far = _distances(world, range(world.frame_at(action.end), world.frame_at(action.end + ARRIVAL_S) + 1))
    least = np.min([*far.values()], axis=0)
    if not np.all(far[location] > np.minimum(least + NEARER_M, AT_LOCATION_M)):
        return None
    nearest = min(far, key=lambda place: float(far[place][0]))
    return f"the hand is {1000 * far[location][0]:.0f} mm from {location}, {1000 * far[nearest][0]:.0f} from {nearest}"


def _distances(world: RecordedWorld, frames: Sequence[int]) -> dict[str, np.ndarray]:
    """Return, by location, the (frames,) distances from what the hand points at to its middle or nearest slot, m."""
    points = np.array([world.pointed_at(frame, POINTED_M) for frame in frames])[:, :, None, :2]
    rows = {place: np.array([slot.position[:2] for slot in slots]) for place, slots in world.scene.slots.items()}
    return {
        place: np.linalg.norm(points - [row.mean(axis=0), *row], axis=-1).min(axis=(1, 2))
        for place, row in rows.items()
    }


def _during(log: Log, action: LoggedAction) -> list[Event]:
    """Return the events of an action."""
    return [event for event in log.about.events if action.start < event.time <= action.end + ROUNDING_S]


def check_events(log: Log, world: RecordedWorld, trace: Sequence[Label]) -> Check:
    """Check that each action has the events that its frames imply, and no others."""
    events, count = log.about.events, len(log.about.actions)
    for k, (action, symbolic) in enumerate(zip(log.about.actions, world.actions, strict=True), 1):
        failed = not world.model.effect(symbolic) & world.model.own_propositions <= trace[k]
        own, last = _during(log, action), k == count and not log.about.claims.completed
        objection = None if last else _objection_to_surprise([event.kind for event in own], failed=failed)
        if objection:
            return Check("events", False, f"action {k} `{action.action}`: {objection}")
    for event, before in zip(events, (0.0, *(event.time for event in events)), strict=False):
        if not before <= event.time <= log.times[-1] + LAST_EVENT_S:
            return Check("events", False, f"`{event.kind}` at {event.time:.2f} s is out of order, or has no frames")
        if event.kind not in EVENTS:
            return Check("events", False, f"`{event.kind}` at {event.time:.2f} s is nothing that a log tells")
    return Check("events", True, f"{len(events)}, as the frames show")


def _objection_to_surprise(kinds: Sequence[str], *, failed: bool) -> str | None:
    """Return what the events of an action lack if it failed, or None."""
    if SURPRISED not in kinds:
        return "it failed, and no event says so" if failed else None
    answered = any(kind in ANSWERS for kind in kinds[kinds.index(SURPRISED) :])
    return None if answered else "it failed, and no event says what was done about it"
