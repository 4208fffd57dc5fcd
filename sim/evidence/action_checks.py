"""Checks of the actions in a log: where each brought the hand, its cost and effect, and the events logged for it."""

import math
from collections.abc import Sequence

import numpy as np

from prefplan.claims import Check
from prefplan.exact_costs import exact, to_number
from prefplan.logic.good_prefix import Label
from prefplan.models.costs import UNMEASURED
from prefplan.models.manipulation.action_costs import cost_tables
from prefplan.models.manipulation.codes import StateCodes
from prefplan.models.manipulation.model import ManipulationState
from prefplan.models.manipulation.slots import location_of
from prefplan.models.manipulation.symbolic import Action, at, holding, marked
from sim.evidence.log import Log, LoggedAction
from sim.evidence.replay import AT_LOCATION_M, RecordedWorld
from sim.simulation.run import FRAME_RATE_HZ

ROUNDING_S = 1e-6
"""Greatest rounding error of a time, s."""

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

SURPRISED = "mismatch"
"""Kind of event after an action without its predicted effect."""

ANSWERS = ("retry", "replan", "unaffected", "ended")
"""Kinds of events, one of which must follow a mismatch."""


def check_actions(log: Log, world: RecordedWorld) -> tuple[list[Label], list[Check]]:
    """Return the labels at the start and after every action, and a check of each action.

    An object earns a location's mark by a release there: the object was held as that action began, the location was at
    work, and the object rests there at the end. It loses its marks if it falls from the table.
    """
    own, marks = world.model.own_propositions, {place.name: place.marks for place in world.model.locations}
    world.show(0)
    said = world.label() & own
    trace, checks, hand = [said], list[Check](), _Hand(log, world)
    earned: set[tuple[str, str]] = set()
    for k, (action, symbolic) in enumerate(zip(log.about.actions, world.actions, strict=True), 1):
        before, told, said = trace[-1], said, frozenset(action.label) & own
        effect = world.model.effect(symbolic) & own
        objection = hand.objection(action, symbolic, before)
        world.show(world.frame_at(action.end))
        label, obj, place = world.label(said) & own, symbolic.obj, symbolic.location
        if (mark := marks.get(place)) and at(obj, place) in effect & label and holding(obj) in before:
            earned |= {(obj, mark)} if world.worked(place, start=action.start, end=action.end) else set()
        fallen = world.fallen()
        earned = {(obj, mark) for obj, mark in earned if obj not in fallen}
        label |= {marked(obj, mark) for obj, mark in earned}
        trace.append(label)
        last = k == len(log.about.actions) and not log.about.claims.completed
        words = (", ".join(sorted(effect)) or "nothing else changed") if effect <= label else "failed, as logged"
        if last and label != said == told:
            words = "the last action; the run ended before it was observed"
        else:
            objection = objection or _objection_to_label(label, said)
        if not last:
            objection = objection or _objection_to_events(log, action, failed=not effect <= label)
        checks.append(Check(f"action {k}", objection is None, f"`{action.action}`: {objection or words}"))
    return trace, checks


def _objection_to_label(label: Label, said: Label) -> str | None:
    if label == said:
        return None
    found, logged = (", ".join(sorted(names)) or "nothing" for names in (label - said, said - label))
    return f"the frames show {found}, the log says {logged}"


def _objection_to_events(log: Log, action: LoggedAction, *, failed: bool) -> str | None:
    """Return which event of an action is missing if it failed, or None."""
    kinds = _kinds_during(log, action)
    if SURPRISED not in kinds:
        return "it failed, and no event says so" if failed else None
    answered = any(kind in ANSWERS for kind in kinds[kinds.index(SURPRISED) :])
    return None if answered else "it failed, and no event says what was done about it"


def _kinds_during(log: Log, action: LoggedAction) -> list[str]:
    """Return the kinds of the events of an action."""
    return [event.kind for event in log.about.events if action.start < event.time <= action.end + ROUNDING_S]


class _Hand:
    """Where the hand may be, by the actions so far and by what the frames show after a mismatch."""

    def __init__(self, log: Log, world: RecordedWorld) -> None:
        self._log, self._world, self._model = log, world, world.model
        self._answers = [event.time for event in log.about.events if event.kind in ANSWERS]
        self._begun, self._ended = -math.inf, 0.0
        self._space = StateCodes(world.model, ())
        self._costs = cost_tables(world.model, self._space.hands)[0]
        # The locations over which it may be, and the symbolic state as far as the actions determine it.
        self._over = {world.model.start}
        self._state: ManipulationState | None = self._space.start

    def objection(self, action: LoggedAction, symbolic: Action, label: Label) -> str | None:
        """Follow the next action; return what is wrong with its times, moves or cost, or None.

        Every transit and transport that succeeds must end with the hand over its location. Grasps and releases must be
        at the location to which the hand was last moved; after a mismatch, also where the frames show the hand. `label`
        is that of the frames before the action.
        """
        now, before = action.start + ROUNDING_S, self._ended
        if any(self._begun < time <= now for time in self._answers):
            far = self._distances([self._world.frame_at(before)])
            self._over |= {ELSEWHERE, *(near for near in far if far[near][0] < GOING_ON_M)}
            self._state = None
        self._begun, self._ended = now, action.end
        objection = self._objection_to_times(action, before)
        if self._model.operator(symbolic.kind).travels:
            objection = objection or self._objection_to_end(action, symbolic.location)
        elif symbolic.kind in ("grasp", "release"):
            objection = objection or self._objection_to_place(symbolic, label)
        return self._objection_to_cost(action, symbolic) or objection

    def _objection_to_times(self, action: LoggedAction, before: float) -> str | None:
        """Return why an action does not follow the one before it, or is beyond the frames; or None.

        A missing action shows in the simulation.
        """
        if not before - ROUNDING_S <= action.start <= action.end:
            return "it begins before the one before it ends"
        end = float(self._log.times[-1])
        if action.end > end + 1.5 / FRAME_RATE_HZ:
            return f"it ends at {action.end:.2f} s, the frames at {end:.2f} s"
        return None

    def _objection_to_place(self, action: Action, label: Label) -> str | None:
        """Return in words which move is missing before a grasp or a release, or None; `label` is the one before it."""
        obj, places, over = action.obj, self._world.scene.slots.keys(), self._over
        needed = action.location or next((place for place in places if at(obj, place) in label), None)
        if needed is None:  # the object is off every location, or not in the scenario
            known = any(obj == other.name for other in self._model.objects)
            return f"no action before it brings the hand to where {obj} is" if known and over <= places else None
        return None if needed in over else f"no action before it brings the hand to {needed}"

    def _objection_to_end(self, action: LoggedAction, location: str) -> str | None:
        """Return where the hand is instead at the end of an action that moves it to a location, or None."""
        if location not in self._world.scene.slots:
            # After a mismatch, an object may lie off every location, at a temporary one.
            return None if min(self._answers, default=math.inf) <= self._begun else "there is no such location"
        if SURPRISED in _kinds_during(self._log, action):
            return None
        first, last = (self._world.frame_at(time) for time in (action.end, action.end + ARRIVAL_S))
        far = self._distances(range(first, last + 1))
        if not np.all(far[location] > np.minimum(np.min([*far.values()], axis=0) + NEARER_M, AT_LOCATION_M)):
            return None
        nearest = min(far, key=lambda place: float(far[place][0]))
        distances = f"{1000 * far[location][0]:.0f} mm from {location}, {1000 * far[nearest][0]:.0f} from {nearest}"
        return f"the hand is {distances}"

    def _distances(self, frames: Sequence[int]) -> dict[str, np.ndarray]:
        """Return, by location, the (frames,) distances of its middle or nearest slot from where the hand points, m."""
        points = np.array([self._world.pointed_at(frame, POINTED_M) for frame in frames])[:, :, None, :2]
        rows = {place: np.array([slot.position[:2] for slot in row]) for place, row in self._world.scene.slots.items()}
        return {
            place: np.linalg.norm(points - [row.mean(axis=0), *row], axis=-1).min(axis=(1, 2))
            for place, row in rows.items()
        }

    def _objection_to_cost(self, action: LoggedAction, symbolic: Action) -> str | None:
        """Update where the hand is after an action; return how its cost differs from the scenario's, or None.

        Measured costs depend on the slots between which the hand moves. Until the first mismatch, the actions determine
        these. Then the cost between any slots is accepted; if the hand may be at no location, that of any two poses.
        """
        operator, before = self._model.operator(symbolic.kind), self._poses()
        if operator.travels:
            self._over = {symbolic.location}
        if self._state is not None:
            outcomes = operator.outcomes(self._model, self._state)
            self._state = next((state for other, state in outcomes if other == symbolic), None)
        entries = self._costs.entries[self._model.kinds.index(symbolic.kind)][np.ix_(before, self._poses())]
        right = {self._costs.unit * int(entry) for entry in entries.flat if entry != UNMEASURED}
        if exact(action.cost) in right:
            return None
        return f"it costs {to_number(right.pop()) if len(right) == 1 else 'another amount'}, not {action.cost}"

    def _poses(self) -> list[int]:
        """Return the numbers of the poses that the hand may have: all, if it may be over no location."""
        if self._state is not None:
            return [self._space.hand(self._state, where="")]
        is_over = self._over <= self._world.scene.slots.keys()
        return [i for i, hand in enumerate(self._space.hands) if not is_over or location_of(hand) in self._over]
