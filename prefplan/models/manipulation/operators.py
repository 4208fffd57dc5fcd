"""Operators: the precondition and effect of each kind of action (action schemas, as in STRIPS)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from prefplan.errors import ModelError
from prefplan.models.manipulation.action import Action, at, holding, parse_action
from prefplan.models.manipulation.codes import StateCodes, StateLayer
from prefplan.models.manipulation.description import Description
from prefplan.models.manipulation.state import ManipulationState

Outcomes = Iterable[tuple[Action, ManipulationState]]
"""The applicable actions of a state, each with its successor."""

LayerSuccessors = Iterable[tuple[Action, np.ndarray, np.ndarray]]
"""Actions, each with the states of a layer where it is applicable (mask or indices), and their successors' codes."""


class Operator:
    """A kind of action.

    A subclass defines `outcomes`, for one state, or `successors`, for many at once; the default of each uses the other.

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

    def outcomes(self, model: Description, state: ManipulationState) -> Outcomes:
        """Return the applicable actions of a state, each with its successor."""
        space = StateCodes(model, state)
        layer = StateLayer(space, space.array(space.encode(state, where="state")))
        for action, found, targets in self.successors(layer):
            if np.arange(1)[found].size:
                yield action, space.decode(int(targets[0]))

    def successors(self, layer: StateLayer) -> LayerSuccessors:
        """Return the actions of this kind, in the order of the model's objects and locations, with their successors.

        Raises:
            ModelError: a successor is not a state of the model, or an action is of another kind.
        """
        space, found = layer.space, defaultdict[Action, list[tuple[int, int]]](list)
        for i, state in enumerate(layer.states):
            for action, after in self.outcomes(space.model, state):
                if action.kind != self.kind:
                    raise ModelError(f"operator {self.kind!r} yields `{action}`, an action of another kind")
                found[action].append((i, space.encode(after, where=f"after `{action}`")))
        objects = {obj: k for k, obj in enumerate(space.objects)}
        locations = {location: k for k, location in enumerate(space.locations)}
        for action in sorted(
            found, key=lambda action: (objects.get(action.obj, -1), locations.get(action.location, -1))
        ):
            index, targets = np.array(found[action], dtype=np.int64).T
            yield action, index, targets


@dataclass(frozen=True)
class Transit(Operator):
    """Move the empty hand to another location, occupied or not."""

    kind = "transit"
    parameters = ("location",)
    travels = True

    def successors(self, layer: StateLayer) -> LayerSuccessors:
        """See `Operator.successors`."""
        for x, name in enumerate(layer.space.locations):
            mask = layer.empty & (layer.over != x)
            yield Action(self.kind, location=name), mask, layer.codes[mask] + (x - layer.hand[mask])


@dataclass(frozen=True)
class Grasp(Operator):
    """Grasp an object with nothing on it at the location below the empty hand."""

    kind = "grasp"
    parameters = ("obj",)

    def effect(self, action: Action) -> frozenset[str]:
        """The hand holds the object."""
        return frozenset({holding(action.obj)})

    def successors(self, layer: StateLayer) -> LayerSuccessors:
        """See `Operator.successors`."""
        space = layer.space
        ready = layer.empty & layer.clear & (layer.over < len(space.locations))
        for o, obj in enumerate(space.model.objects):
            mask = ready & (layer.places[o] == layer.over) & (not obj.fixed)
            slot = layer.slots[o][mask]
            raised = space.weights[1 + o] * (space.held - slot).astype(space.dtype)
            yield Action(self.kind, obj.name), mask, layer.codes[mask] + raised + space.above[slot] - layer.hand[mask]


@dataclass(frozen=True)
class Transport(Operator):
    """Carry the held object to another location that accepts it."""

    kind = "transport"
    travels = True

    def effect(self, action: Action) -> frozenset[str]:
        """The hand holds the object."""
        return frozenset({holding(action.obj)})

    def successors(self, layer: StateLayer) -> LayerSuccessors:
        """See `Operator.successors`."""
        space = layer.space
        for obj, place in zip(space.objects, layer.places, strict=True):
            held = place == len(space.locations)
            for x, name in enumerate(space.locations):
                mask = held & (layer.over != x) & layer.accepts[x]
                target = layer.codes[mask] + space.above[layer.free[x][mask]] - layer.hand[mask]
                yield Action(self.kind, obj, name), mask, target


@dataclass(frozen=True)
class Release(Operator):
    """Put the held object down at the location below the hand, which may give it a mark."""

    kind = "release"

    def effect(self, action: Action) -> frozenset[str]:
        """The object rests at the location."""
        return frozenset({at(action.obj, action.location)})

    def successors(self, layer: StateLayer) -> LayerSuccessors:
        """See `Operator.successors`."""
        space = layer.space
        for o, obj in enumerate(space.objects):
            held = layer.places[o] == len(space.locations)
            for x, location in enumerate(space.model.locations):
                mask = held & (layer.over == x) & layer.accepts[x]
                slot, codes = layer.free[x][mask], layer.codes[mask]
                lowered = space.weights[1 + o] * (slot - space.held).astype(space.dtype)
                target = codes + lowered + space.above[slot] - layer.hand[mask]
                if location.marks:
                    d = space.mark_digits[obj, location.marks]
                    target = target + space.weights[d] * (1 - space.digit(codes, d)).astype(space.dtype)
                yield Action(self.kind, obj, location.name), mask, target


STANDARD_OPERATORS: tuple[Operator, ...] = (Transit(), Grasp(), Transport(), Release())
"""The operators of every manipulation model, in order."""


def parameters_of(operators: Iterable[Operator]) -> dict[str, tuple[str, ...]]:
    """Return which of `obj` and `location` each kind of action names, in order."""
    return {operator.kind: operator.parameters for operator in operators}


def read_action(text: str, operators: Iterable[Operator] = STANDARD_OPERATORS) -> Action:
    """Return the action with a text, such as `transport blue san`; its names need not be those of a model.

    Raises:
        ModelError: no operator has actions of this form.
    """
    return parse_action(text, parameters_of(operators))
