"""Symbolic states encoded as integers, and arrays of states by their digits."""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property

import numpy as np

from prefplan.errors import ModelError, check_known, choices
from prefplan.models.manipulation.action import at, holding, marked
from prefplan.models.manipulation.description import Description
from prefplan.models.manipulation.slots import free_slot, hand_poses, location_of, pose, slots_at_start
from prefplan.models.manipulation.state import ManipulationState

MAX_CODES = 2**62
"""Number of codes up to which codes and their differences fit 64-bit integers."""


class StateCodes:
    """The code of each state of a model.

    A code is one mixed-radix integer: the hand's pose, then each object's slot (the last one: in the hand), then one
    bit for each object and mark. Where slots are not told apart, a location is one slot, whatever its capacity.

    Attributes:
        model: the model.
        hands: names of the hand's poses.
        bound: number of codes.
        locations: names of the locations.
        objects: names of the objects.
        held: slot of an object in the hand.
        location: (slots + 1,) index of each slot's location, one beyond them for `held`.
        over: (hands,) index of the location below each pose of the hand; one beyond them for a start pose elsewhere.
        above: (slots + 1,) index of the hand's pose over each slot; the last entry is unused.
        dtype: of arrays of codes: int64, or Python's integers where these do not fit.
        radices: number of values of each digit.
        weights: weight of each digit.
        mark_digits: by (object, mark), the digit that is 1 if the object has the mark.
    """

    def __init__(self, model: Description, start: ManipulationState) -> None:
        """Lay out the digits.

        Args:
            model: locations, objects and marks.
            start: the first state, whose hand may be over no location.
        """
        self.model = model
        self.locations = [place.name for place in model.locations]
        self.objects = [obj.name for obj in model.objects]
        self._slot_counts = list(model.slot_counts.values())
        self._slots = [(x, i) for x, count in enumerate(self._slot_counts) for i in range(count)]
        self.held = len(self._slots)
        self.hands = hand_poses(self.locations, self._slot_counts, start.hand)
        names = [*self.locations, start.hand]
        self.location = np.array([*(x for x, _ in self._slots), len(self.locations)])
        self.over = np.array([names.index(location_of(hand)) for hand in self.hands])
        poses = [self._pose(slot) for slot in range(self.held)]
        self.above = np.array([self.hands.index(hand) for hand in poses] + [0])
        self._hand_slots = {
            hand: i for hand, (x, i) in zip(poses, self._slots, strict=True) if self._slot_counts[x] > 1
        }
        self.radices = [len(self.hands)] + [self.held + 1] * len(self.objects)
        carried = [(obj, mark) for obj in self.objects for mark in model.marks]
        self.mark_digits = {pair: len(self.radices) + d for d, pair in enumerate(carried)}
        self.radices += [2] * len(carried)
        self.weights = [1]
        for radix in self.radices:
            self.weights.append(self.weights[-1] * radix)
        self.bound = self.weights.pop()
        self.dtype = np.dtype(np.int64 if self.bound < MAX_CODES else object)

    def _pose(self, slot: int) -> str:
        """Return the hand's pose over a slot."""
        x, i = self._slots[slot]
        return pose(self.locations[x], i if self._slot_counts[x] > 1 else None)

    def seen(self, names: Collection[str] | None) -> list[tuple[int, list[str]]]:
        """Return the digits on which propositions depend, each with the proposition that each value makes true, or "".

        Args:
            names: the propositions; None for all.
        """
        told = [
            (1 + o, [*(at(obj, self.locations[x]) for x in self.location[:-1]), holding(obj)])
            for o, obj in enumerate(self.objects)
        ]
        told += [(d, ["", marked(*pair)]) for pair, d in self.mark_digits.items()]
        kept = [(d, [name if names is None or name in names else "" for name in values]) for d, values in told]
        return [(d, values) for d, values in kept if any(values)]

    def digit(self, codes: np.ndarray, d: int) -> np.ndarray:
        """Return one digit of every code."""
        found: np.ndarray = codes // self.weights[d] % self.radices[d]
        return found.astype(np.int64)

    def array(self, *codes: int) -> np.ndarray:
        """Return codes as an array."""
        return np.array(codes, dtype=self.dtype)

    def require_small(self) -> None:
        """Raise ModelError if there are too many objects and slots for all states to be listed."""
        if self.bound >= MAX_CODES:
            raise ModelError(f"{len(self.objects)} objects and {self.held} slots make more states than can be numbered")

    def decode(self, code: int) -> ManipulationState:
        """Return the state with a code."""
        digits = [code // w % r for w, r in zip(self.weights, self.radices, strict=True)]
        slots = dict(zip(self.objects, digits[1 : 1 + len(self.objects)], strict=True))
        resting = {obj: self._slots[slot] for obj, slot in slots.items() if slot != self.held}
        hand = self.hands[digits[0]]
        return ManipulationState(
            hand=location_of(hand),
            held=next((obj for obj, slot in slots.items() if slot == self.held), None),
            places=tuple((obj, self.locations[x]) for obj, (x, _) in resting.items()),
            marks=frozenset(pair for pair, d in self.mark_digits.items() if digits[d]),
            slots=tuple((obj, i) for obj, (x, i) in resting.items() if self._slot_counts[x] > 1),
            hand_slot=self._hand_slots.get(hand),
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
        hand = pose(state.hand, state.hand_slot)
        hand = hand if hand in self.hands else state.hand
        if hand not in self.hands:
            raise ModelError(f"{where}: the hand over unknown location {hand!r} {choices(hand, self.locations)}")
        code = self.hands.index(hand)
        slots = self._resting_slots(state, [(obj, str(places[obj])) for obj in self.objects if places[obj] is not None])
        for o, obj in enumerate(self.objects):
            code += self.weights[1 + o] * slots.get(obj, self.held)
        for obj, mark in state.marks:
            if (obj, mark) not in self.mark_digits:
                raise ModelError(f"{where}: {obj!r} cannot be marked {mark!r}")
            code += self.weights[self.mark_digits[obj, mark]]
        return code

    def _resting_slots(self, state: ManipulationState, resting: list[tuple[str, str]]) -> dict[str, int]:
        """Return the slot of every object that is not in the hand."""
        if self.held == len(self.locations):
            return {obj: self.locations.index(place) for obj, place in resting}
        found = slots_at_start(resting, dict(state.slots), self.model.slot_counts)
        return {obj: self._slots.index((self.locations.index(place), found[obj])) for obj, place in resting}

    def free_slots(self, x: int, slots: list[np.ndarray], number: int) -> np.ndarray:
        """Return (number,) the slot of location x into which an object would be put in each of a number of states."""
        first = self._slots.index((x, 0))
        if self._slot_counts[x] == 1:
            return np.full(number, first)
        taken = np.zeros((self._slot_counts[x], number), dtype=bool)
        for slot in slots:
            taken |= slot == first + np.arange(self._slot_counts[x])[:, None]
        return first + free_slot(taken)


class StateLayer:
    """N states, as arrays with one entry for each.

    Attributes:
        space: the encoding of the states.
        codes: (N,).
        hand: (N,) index of the hand's pose.
        over: (N,) index of the location below the hand, one beyond them for none.
        slots: for each object, (N,) its slot.
        places: for each object, (N,) index of its location, one beyond them for the hand.
        free: for each location, (N,) the slot into which an object would be put.
        accepts: for each location, (N,) bool, whether an object can be put there.
        empty: (N,) bool, whether the hand is empty.
        clear: (N,) bool, whether nothing prevents grasping an object below the hand.
    """

    def __init__(self, space: StateCodes, codes: np.ndarray) -> None:
        """Decode the digits of every code."""
        self.space, self.codes = space, codes
        self.hand = space.digit(codes, 0)
        self.over = space.over[self.hand]
        self.slots = [space.digit(codes, 1 + o) for o in range(len(space.objects))]
        self.places = [space.location[slot] for slot in self.slots]
        self.free = [space.free_slots(x, self.slots, len(codes)) for x in range(len(space.locations))]
        self.empty = np.ones(len(codes), dtype=bool)
        for place in self.places:
            self.empty &= place != len(space.locations)
        self._judge_locations()

    def _judge_locations(self) -> None:
        """Set `accepts` and `clear` by the number of objects at each location."""
        locations, names = self.space.model.locations, self.space.locations
        zero = np.zeros(len(self.codes), dtype=np.int8)
        count = [sum((place == x for place in self.places), start=zero) for x in range(len(names))]
        self.accepts = [(count[x] < where.capacity) & (not where.closed) for x, where in enumerate(locations)]
        self.clear = np.ones(len(self.codes), dtype=bool)
        for x, where in enumerate(locations):
            for support in where.on:
                self.accepts[x] &= count[names.index(support)] > 0
                self.clear &= (self.over != names.index(support)) | (count[x] == 0)
            for other in where.clear_of:
                self.accepts[x] &= count[names.index(other)] == 0
                if where.closed:
                    self.clear &= (self.over != x) | (count[names.index(other)] == 0)

    @cached_property
    def states(self) -> list[ManipulationState]:
        """The states themselves."""
        return [self.space.decode(int(code)) for code in self.codes]
