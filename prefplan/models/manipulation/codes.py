"""Symbolic states encoded as integers."""

from __future__ import annotations

from collections.abc import Collection
from itertools import accumulate
from operator import mul
from typing import TYPE_CHECKING

import numpy as np

from prefplan.errors import ModelError, check_known, choices
from prefplan.exact_costs import INT64_LIMIT
from prefplan.models.manipulation.slots import hand_poses, location_of, pose, slots_at_start
from prefplan.models.manipulation.symbolic import ManipulationState, at, holding, marked

if TYPE_CHECKING:
    from prefplan.models.manipulation.model import ManipulationModel


class StateCodes:
    """The code of each state of a model.

    A code is a mixed-radix integer. Its digits are the hand's pose, each object's slot (the last slot: in the hand),
    one bit for each visible mark of an object, and where the held object was grasped. Where slots are not told apart, a
    location is one slot, whatever its capacity.

    Attributes:
        hands: names of the hand's poses.
        bound: number of codes.
        model: the model.
        locations: names of its locations.
        objects: names of its objects.
        held: slot of an object in the hand.
        location: (slots + 1,) index of each slot's location; the number of locations for `held`.
        over: (hands,) index of the location below each pose of the hand; the number of locations for a start elsewhere.
        above: (slots + 1,) index of the hand's pose over each slot; the last entry is unused.
        radices: number of values of each digit.
        weights: weight of each digit.
        mark_digits: by (object, mark), the digit that is 1 if the object has the mark.
        origins: by (object, location), from 1, the value of the last digit while the hand holds this object, grasped
            there; the digit is 0 in all other states.
    """

    def __init__(
        self, model: ManipulationModel, visible: Collection[str], origins: Collection[tuple[str, str]] = ()
    ) -> None:
        """Lay out the digits; the hand may be over no location at the start.

        Codes contain only those marks that are `visible` propositions, and where the held object was grasped only for
        `origins`, each an object and a location.
        """
        self.model, start = model, model.initial_state
        self.locations = [place.name for place in model.locations]
        self.objects = [obj.name for obj in model.objects]
        self._counts = model.slot_counts
        self._slots = [(name, i) for name, count in self._counts.items() for i in range(count)]
        self.held = len(self._slots)
        self.hands = hand_poses(self._counts, start.hand)
        names = [*self.locations, start.hand]
        self.location = np.array([*(names.index(name) for name, _ in self._slots), len(self.locations)])
        self.over = np.array([names.index(location_of(hand)) for hand in self.hands])
        poses = [pose(name, i if self._counts[name] > 1 else None) for name, i in self._slots]
        self.above = np.array([self.hands.index(hand) for hand in poses] + [0])
        self._hand_slots = {hand: i for hand, (name, i) in zip(poses, self._slots, strict=True) if hand != name}
        self.radices = [len(self.hands)] + [self.held + 1] * len(self.objects)
        pairs = ((obj, mark) for obj in self.objects for mark in model.marks)
        carried = [pair for pair in pairs if marked(*pair) in visible]
        self.mark_digits = {pair: len(self.radices) + d for d, pair in enumerate(carried)}
        grasped = sorted({place for _, place in origins})
        self.origins = {(obj, place): 1 + grasped.index(place) for obj, place in sorted(origins)}
        self.radices += [2] * len(carried) + [1 + len(grasped)]
        *self.weights, self.bound = accumulate(self.radices, mul, initial=1)

    def visible(self, names: Collection[str]) -> list[tuple[int, list[str]]]:
        """Return the digits on which some propositions depend, each with the proposition, or "", of every value."""
        digits = [
            (1 + o, [*(at(obj, self.locations[x]) for x in self.location[:-1]), holding(obj)])
            for o, obj in enumerate(self.objects)
        ]
        digits += [(d, ["", marked(*pair)]) for pair, d in self.mark_digits.items()]
        kept = [(d, [name if name in names else "" for name in values]) for d, values in digits]
        return [(d, values) for d, values in kept if any(values)]

    def digit(self, codes: np.ndarray, d: int) -> np.ndarray:
        """Return one digit of every code."""
        return codes // self.weights[d] % self.radices[d]

    def require_small(self) -> None:
        """Raise ModelError if there are too many objects and slots to number all states."""
        if self.bound >= INT64_LIMIT:
            raise ModelError(f"{len(self.objects)} objects and {self.held} slots make more states than can be numbered")

    @property
    def start(self) -> ManipulationState:
        """The model's initial state, with the slots of its objects.

        Raises:
            ModelError: as in `encode`.
        """
        return self.decode(self.encode(self.model.initial_state, where="start"))

    def decode(self, code: int) -> ManipulationState:
        """Return the state with a code."""
        digits = [code // w % r for w, r in zip(self.weights, self.radices, strict=True)]
        slots = dict(zip(self.objects, digits[1 : 1 + len(self.objects)], strict=True))
        resting = {obj: self._slots[slot] for obj, slot in slots.items() if slot != self.held}
        hand, held = self.hands[digits[0]], next((obj for obj, slot in slots.items() if slot == self.held), None)
        grasped = ((obj, place) for (obj, place), value in self.origins.items() if value == digits[-1])
        return ManipulationState(
            hand=location_of(hand),
            held=held,
            places=tuple((obj, place) for obj, (place, _) in resting.items()),
            marks=frozenset(pair for pair, d in self.mark_digits.items() if digits[d]),
            slots=tuple((obj, i) for obj, (place, i) in resting.items() if self._counts[place] > 1),
            hand_slot=self._hand_slots.get(hand),
            origin=next((place for obj, place in grasped if obj == held), None),
        )

    def encode(self, state: ManipulationState, *, where: str) -> int:
        """Return the code of a state; `where` begins the messages of errors.

        Raises:
            ModelError: the state has names that are not of the model, or leaves an object without a place.
        """
        places = state.place | ({state.held: None} if state.held else {})
        for obj in places:
            check_known(where, "object", obj, self.objects)
        for obj in self.objects:
            if obj not in places:
                raise ModelError(f"{where}: {obj!r} is neither at a location nor in the hand")
            place = places[obj]
            if place is not None and place not in self.locations:
                raise ModelError(f"{where}: {obj!r} at unknown location {place!r} {choices(place, self.locations)}")
        for obj, mark in state.marks:
            if obj not in self.objects or mark not in self.model.marks:
                raise ModelError(f"{where}: {obj!r} cannot be marked {mark!r}")
        code, slots = self.hand(state, where=where), self._resting_slots(state)
        for o, obj in enumerate(self.objects):
            code += self.weights[1 + o] * slots.get(obj, self.held)
        code += self.weights[-1] * self.origins.get((state.held or "", state.origin or ""), 0)
        return code + sum(self.weights[d] for pair, d in self.mark_digits.items() if pair in state.marks)

    def hand(self, state: ManipulationState, *, where: str) -> int:
        """Return the number of the hand's pose in a state; arguments and errors as in `encode`."""
        hand = pose(state.hand, state.hand_slot)
        hand = hand if hand in self.hands else state.hand
        if hand not in self.hands:
            raise ModelError(f"{where}: the hand over unknown location {hand!r} {choices(hand, self.locations)}")
        return self.hands.index(hand)

    def _resting_slots(self, state: ManipulationState) -> dict[str, int]:
        """Return the slot of every object that is not in the hand."""
        places = state.place
        resting = [(obj, places[obj]) for obj in self.objects if obj in places]
        if self.held == len(self.locations):
            return {obj: self.locations.index(place) for obj, place in resting}
        slots = slots_at_start(resting, dict(state.slots), self._counts)
        return {obj: self._slots.index((place, slots[obj])) for obj, place in resting}
