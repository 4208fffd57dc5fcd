"""Symbolic states and actions of a manipulation model, and the propositions of states, as text."""

from collections.abc import Collection, Hashable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Action:
    """A symbolic action; its text has these parts in order, such as `transport blue san`.

    Attributes:
        kind: the kind of its operator.
        obj: its object, or "".
        location: its location, or "".
    """

    kind: str
    obj: str = ""
    location: str = ""

    def __str__(self) -> str:
        """Return the action's text in plans and logs."""
        return " ".join(part for part in (self.kind, self.obj, self.location) if part)


def holding(obj: str) -> str:
    """Return the proposition that the hand holds an object."""
    return f"holding_{obj}"


def at(obj: str, location: str) -> str:
    """Return the proposition that an object rests at a location."""
    return f"{obj}_{location}"


def marked(obj: str, mark: str) -> str:
    """Return the proposition that an object carries a mark."""
    return f"{obj}_{mark}"


def grasped_at(obj: str, location: str) -> str:
    """Return the condition that the hand holds an object that it grasped at a location; no formula can name it."""
    return f"{obj} from {location}"


Barred = Collection[tuple[frozenset[str], str]]
"""(conditions, action): the action does not exist where all these hold, see `ManipulationState.conditions`."""


@dataclass(frozen=True)
class ManipulationState:
    """One symbolic state.

    Attributes:
        hand: location that the hand is over, or the start pose's name.
        held: object in the hand, or None.
        places: (object, location) for every object that is not held, in the model's order.
        marks: (object, mark) for every mark that an object has.
        slots: (object, slot) for every object at a location with several slots, in the model's order, where slots are
            distinguished: see `prefplan.models.manipulation.slots`.
        hand_slot: the slot that the hand is over, if its location has several and they are distinguished; None also
            for the middle between them.
        origin: the location where the held object was grasped, where an exclusion depends on it; else None.
    """

    hand: str
    held: str | None
    places: tuple[tuple[str, str], ...]
    marks: frozenset[tuple[str, str]] = frozenset()
    slots: tuple[tuple[str, int], ...] = ()
    hand_slot: int | None = None
    origin: str | None = None

    @property
    def place(self) -> dict[str, str]:
        """The location of every object that is not held."""
        return dict(self.places)

    @property
    def label(self) -> frozenset[str]:
        """The propositions true in this state."""
        names = {at(obj, place) for obj, place in self.places} | {marked(obj, mark) for obj, mark in self.marks}
        return frozenset(names | ({holding(self.held)} if self.held else set()))

    @property
    def conditions(self) -> frozenset[str]:
        """What exclusions may depend on: the label, and where the held object was grasped."""
        return self.label | ({grasped_at(self.held, self.origin)} if self.held and self.origin else set())

    def __str__(self) -> str:
        """Return the state on one line."""
        parts = [f"hand at {self.hand}"]
        if self.held:
            parts.append(f"holding {self.held}")
        parts += [f"{o} on {place}" for o, place in self.places]
        parts += [f"{o} {mark}" for o, mark in sorted(self.marks)]
        return ", ".join(parts)


def last_place(obj: str | None, states: Sequence[Hashable]) -> str | None:
    """Return where an object rested last along some states; states of other models are skipped."""
    places = (state.place for state in reversed(states) if isinstance(state, ManipulationState))
    return next((place[obj] for place in places if obj in place), None)
