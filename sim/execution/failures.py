"""Failed actions, and the constraints that they put on later plans."""

from collections import Counter
from collections.abc import Sequence

from prefplan.models.manipulation.model import ManipulationState
from prefplan.models.manipulation.symbolic import Barred, at, grasped_at, holding, last_place
from sim.execution.executor import Execution
from sim.skills.transit import raised_by

MAX_ATTEMPTS = 3
"""Greatest number of attempts at an action that leads to the same unexpected state, and of detours by which an object
is to be brought to a location."""


class Failures:
    """The failed actions of an execution.

    Attributes:
        barred: actions that plans must not contain in states with certain propositions.
        repeated: whether an action was given up after `MAX_ATTEMPTS`.
    """

    def __init__(self) -> None:
        """Begin without failures."""
        self.barred: set[tuple[frozenset[str], str]] = set()
        self.repeated = False
        self._attempts: Counter[tuple[str, ManipulationState]] = Counter()
        self._unreached: Counter[str] = Counter()
        # By object and target, the locations from which the object cannot be brought directly to the target.
        self._detours: dict[tuple[str, str], set[str]] = {}
        self._blocked: Counter[tuple[str, str]] = Counter()
        self._rehearsed: set[tuple[str, str, str]] = set()
        # To be barred instead of the detours if there is no plan with them.
        self._instead: set[tuple[frozenset[str], str]] = set()
        self._detours_barred = False

    def __bool__(self) -> bool:
        """Whether there are constraints on plans."""
        return bool(self.excluded)

    def record(self, run: Execution, before: Sequence[ManipulationState]) -> None:
        """Record that the last action failed, after some states; bar it if it was blocked or failed repeatedly."""
        action, state = run.steps[-1].action, run.steps[-1].observed
        self._attempts[action, state] += 1
        repeated = self._attempts[action, state] >= MAX_ATTEMPTS
        self.repeated |= repeated
        self._unreached[action] += run.blocked == ()
        # A rehearsal has no physics: its result is ignored after `MAX_ATTEMPTS` failures.
        hindering = run.hindering if self._unreached[action] < MAX_ATTEMPTS else ()
        if repeated or run.blocked is not None:
            bars = self._instead if self._adds_detour(run, before) else self.barred
            bars |= {(_conditions(run, s, hindering), action) for s in (before[-1], state)}

    @property
    def excluded(self) -> Barred:
        """Barred actions, and the releases that would bring an object directly to where it needs a detour."""
        detours = (
            (frozenset({grasped_at(obj, source)}), f"release {obj} {target}")
            for (obj, target), places in self._detours.items()
            for source in places
        )
        return {*self.barred, *detours}

    def rehearse(self, run: Execution, state: ManipulationState, actions: Sequence[str]) -> bool:
        """Require a detour where the actions of a new plan would bring an object in vain; return whether one is needed.

        Only transports that failed from another location are rehearsed; the plan begins in `state`.
        """
        place, found = dict(state.place), False
        for action in map(run.scene.model.action, actions):
            obj, target = action.obj, action.location
            source, barred = place.get(obj, ""), self._detours.get((obj, target), set())
            if action.kind == "release":
                place[obj] = target
            elif action.kind == "transport" and barred and source and (obj, source, target) not in self._rehearsed:
                self._rehearsed.add((obj, source, target))
                if not run.can_bring(state, obj, source, target):
                    barred.add(source)
                    found = True
        return found

    def bar_detours(self) -> bool:
        """Give up detours and bar the actions that they were to replace; return whether there were any."""
        found = bool(self._detours)
        self.barred |= self._instead
        self._detours.clear()
        self._detours_barred = True
        return found

    def _adds_detour(self, run: Execution, before: Sequence[ManipulationState]) -> bool:
        """Require a detour for a held object that no other object keeps from a location; return whether one was added.

        With the present grasp, the hand cannot bring the object there; with another grasp it may, after the object was
        put down elsewhere. So plans must not bring the object from where it was grasped directly to that location.
        """
        symbolic = run.scene.model.action(run.steps[-1].action)
        obj, target = symbolic.obj, symbolic.location
        # An object that was grasped but cannot be raised has no target.
        if not target or run.steps[-1].observed.held != obj:
            return False
        if run.blocked is None or _blockers(run, obj, run.hindering):
            return False
        source = last_place(obj, before)
        tried = self._detours.get((obj, target), set())
        given_up = self._detours_barred or self._blocked[obj, target] >= MAX_ATTEMPTS
        if not source or source == target or source in tried or given_up:
            return False
        self._blocked[obj, target] += 1
        self._detours[obj, target] = {*tried, source}
        return True


def _blockers(run: Execution, obj: str, hindering: Sequence[str]) -> set[str]:
    """Return the objects that blocked the last action or made it fail, except the action's own object."""
    return (set(hindering) or {name for name in run.blocked or () if name in run.scene.shapes}) - {obj}


def _conditions(run: Execution, state: ManipulationState, hindering: Sequence[str]) -> frozenset[str]:
    """Return the propositions of a state under which the last action is expected to fail again.

    An action that other objects block is barred until one of these or its own object moves. One that a fixture blocks,
    or whose goal is out of reach, is barred until its own object moves; for a transit to a temporary location, this is
    the object there. Other transits have no object, and their path depends on how high objects are piled up. If the
    goal is out of reach, they are barred until an object moves that is there or raises the hand; else until any object
    moves, unless it is known which objects make them fail.
    """
    symbolic = run.scene.model.action(run.steps[-1].action)
    obj = symbolic.obj
    if not obj and symbolic.location in run.scene.temporary:
        obj = next((name for name, place in state.place.items() if place == symbolic.location), "")
    blockers = _blockers(run, obj, hindering)
    # A temporary location is gone once nothing lies there.
    if not (obj or hindering) and run.blocked == () and symbolic.location in run.scene.slots:
        raising = raised_by(run.cell, symbolic.location)
        if not state.place.keys() >= {*raising}:
            return state.label
        return frozenset(at(name, state.place[name]) for name in raising)
    if not (obj or hindering) or run.blocked is None or not blockers <= state.place.keys():
        return state.label
    places = {at(name, state.place[name]) for name in blockers}
    return state.label & {holding(obj), at(obj, state.place.get(obj, "")), *places} or state.label
