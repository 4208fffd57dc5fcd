"""Operators: the precondition and effect of each kind of action (action schemas, as in STRIPS)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from prefplan.errors import ModelError, choices
from prefplan.models.manipulation.description import Location
from prefplan.models.manipulation.slots import free_slot
from prefplan.models.manipulation.symbolic import Action, ManipulationState, at, holding

if TYPE_CHECKING:
    from prefplan.models.manipulation.model import ManipulationModel

Outcomes = Iterable[tuple[Action, ManipulationState]]
"""The applicable actions of a state, each with its successor."""


class Operator(ABC):
    """A kind of action.

    Attributes:
        kind: first word of its actions.
        parameters: which of `obj` and `location` its actions have.
        travels: whether it moves the hand to the action's location.
    """

    kind: ClassVar[str]
    parameters: ClassVar[tuple[str, ...]] = ("obj", "location")
    travels: ClassVar[bool] = False

    def effect(self, action: Action) -> frozenset[str]:
        """Return the propositions that an action makes true whenever it succeeds."""
        return frozenset()

    @abstractmethod
    def outcomes(self, model: ManipulationModel, state: ManipulationState) -> Outcomes:
        """Return the applicable actions of a state, in the order in which they are tried, each with its successor."""


@dataclass(frozen=True)
class Transit(Operator):
    """Move the empty hand to another location, occupied or not."""

    kind = "transit"
    parameters = ("location",)
    travels = True

    def outcomes(self, model: ManipulationModel, state: ManipulationState) -> Outcomes:
        """See `Operator.outcomes`."""
        for place in model.locations if state.held is None else ():
            if place.name != state.hand:
                yield Action(self.kind, location=place.name), replace(state, hand=place.name, hand_slot=None)


@dataclass(frozen=True)
class Grasp(Operator):
    """Grasp an object with nothing on it at the location below the empty hand."""

    kind = "grasp"
    parameters = ("obj",)

    def effect(self, action: Action) -> frozenset[str]:
        """The hand holds the object."""
        return frozenset({holding(action.obj)})

    def outcomes(self, model: ManipulationModel, state: ManipulationState) -> Outcomes:
        """See `Operator.outcomes`."""
        places, slots = state.place, dict(state.slots)
        here = [obj.name for obj in model.objects if not obj.fixed and places.get(obj.name) == state.hand]
        for obj in here if state.held is None and _is_clear(model, state) else ():
            left = tuple(pair for pair in state.places if pair[0] != obj)
            apart = tuple(pair for pair in state.slots if pair[0] != obj)
            after = replace(state, held=obj, places=left, slots=apart, hand_slot=slots.get(obj))
            yield Action(self.kind, obj), after


@dataclass(frozen=True)
class Transport(Operator):
    """Carry the held object to another location that accepts it."""

    kind = "transport"
    travels = True

    def effect(self, action: Action) -> frozenset[str]:
        """The hand holds the object."""
        return frozenset({holding(action.obj)})

    def outcomes(self, model: ManipulationModel, state: ManipulationState) -> Outcomes:
        """See `Operator.outcomes`."""
        for place in model.locations if state.held is not None else ():
            if place.name != state.hand and _accepts(state, place):
                after = replace(state, hand=place.name, hand_slot=_slot(model, state, place))
                yield Action(self.kind, str(state.held), place.name), after


@dataclass(frozen=True)
class Release(Operator):
    """Put the held object down at the location below the hand, which may give it a mark."""

    kind = "release"

    def effect(self, action: Action) -> frozenset[str]:
        """The object rests at the location."""
        return frozenset({at(action.obj, action.location)})

    def outcomes(self, model: ManipulationModel, state: ManipulationState) -> Outcomes:
        """See `Operator.outcomes`."""
        for obj in () if state.held is None else (state.held,):
            for place in (place for place in model.locations if place.name == state.hand and _accepts(state, place)):
                slot, names = _slot(model, state, place), [other.name for other in model.objects]
                places = {**state.place, obj: place.name}
                slots = {**dict(state.slots), obj: slot} if slot is not None else dict(state.slots)
                after = ManipulationState(
                    hand=place.name,
                    held=None,
                    places=tuple((name, places[name]) for name in names if name in places),
                    marks=state.marks | ({(obj, place.marks)} if place.marks else set()),
                    slots=tuple((name, slots[name]) for name in names if name in slots),
                    hand_slot=slot,
                )
                yield Action(self.kind, obj, place.name), after


def _accepts(state: ManipulationState, place: Location) -> bool:
    """Return whether an object can be put at a location."""
    occupied = [where for _, where in state.places]
    if place.closed or occupied.count(place.name) >= place.capacity:
        return False
    return all(below in occupied for below in place.on) and not any(other in occupied for other in place.clear_of)


def _is_clear(model: ManipulationModel, state: ManipulationState) -> bool:
    """Return whether nothing prevents grasping an object below the hand."""
    occupied = {where for _, where in state.places}
    for place in model.locations:
        if place.name in occupied and state.hand in place.on:
            return False
        if place.name == state.hand and place.closed and not occupied.isdisjoint(place.clear_of):
            return False
    return True


def _slot(model: ManipulationModel, state: ManipulationState, place: Location) -> int | None:
    """Return the slot of a location into which an object is put; None if its slots are not told apart."""
    count, places = model.slot_counts[place.name], state.place
    taken = [slot for obj, slot in state.slots if places.get(obj) == place.name]
    return int(free_slot(taken, 0, count)) if count > 1 else None


STANDARD_OPERATORS: tuple[Operator, ...] = (Transit(), Grasp(), Transport(), Release())
"""The operators of every manipulation model, in order."""


def parameters_of(operators: Iterable[Operator]) -> dict[str, tuple[str, ...]]:
    """Return which of `obj` and `location` each kind of action names, in order."""
    return {operator.kind: operator.parameters for operator in operators}


def read_action(text: str, operators: Iterable[Operator] = STANDARD_OPERATORS) -> Action:
    """Return the action with a text, such as `transport blue san`; its names need not be those of a model.

    Raises:
        ModelError: no operator is of its kind, or the number of names is not that of its parameters.
    """
    kind, *names = text.split() or [""]
    parameters = parameters_of(operators)
    if kind not in parameters:
        raise ModelError(f"unknown action {kind!r} {choices(kind, parameters)}")
    if len(names) != len(parameters[kind]):
        raise ModelError(f"action {text!r}: is written {' '.join((kind, *parameters[kind])).upper()!r}")
    return Action(kind, **dict(zip(parameters[kind], names, strict=True)))
