"""The reachable states of a manipulation model, generated a whole breadth-first layer at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import overload

import numpy as np

from prefplan.errors import ModelError, choices
from prefplan.models.manipulation.action_costs import ACTION_KINDS, UNMEASURED
from prefplan.models.manipulation.cost_matrix import cost_matrix, unmeasured
from prefplan.models.manipulation.description import Description, ManipulationState
from prefplan.models.manipulation.numbering import Numbering
from prefplan.models.manipulation.slots import free_slot, hand_poses, location_of, pose, slots_at_start
from prefplan.models.transition_system import TransitionSystem


class _Codes(Sequence[ManipulationState]):
    """Reachable states by number, decoded on demand."""

    def __init__(self, builder: _Builder, codes: np.ndarray) -> None:
        self._builder, self._codes = builder, codes

    def __len__(self) -> int:
        return len(self._codes)

    @overload
    def __getitem__(self, index: int) -> ManipulationState: ...

    @overload
    def __getitem__(self, index: slice) -> list[ManipulationState]: ...

    def __getitem__(self, index: int | slice) -> ManipulationState | list[ManipulationState]:
        if isinstance(index, slice):
            return [self._builder.decode(int(code)) for code in self._codes[index]]
        return self._builder.decode(int(self._codes[index]))


class _Builder:
    """Codes of states, and the edges between them.

    A state is one mixed-radix integer: the hand's pose, then each object's slot (the last one: in the hand), then one
    bit for each object and mark. Where slots are not told apart, a location is one slot with room for several.
    """

    def __init__(self, model: Description, start: ManipulationState) -> None:
        self.model = model
        self.start = start
        self.marks = model.marks
        self.names = [place.name for place in model.locations]
        self.obj_names = [obj.name for obj in model.objects]
        self.slot_counts = list(model.slot_counts.values())
        self.hands = hand_poses(self.names, self.slot_counts, start.hand)
        self.slots = [(x, i) for x, count in enumerate(self.slot_counts) for i in range(count)]
        self.held = len(self.slots)
        self.nowhere = len(self.names)
        locations = [*self.names, start.hand]
        # The location of a slot, of the hand where an object is held, and of each pose of the hand.
        self.location = np.array([*(x for x, _ in self.slots), self.nowhere])
        self.over = np.array([locations.index(location_of(hand)) for hand in self.hands])
        self.hand_slots = {self.pose(slot): i for slot, (x, i) in enumerate(self.slots) if self.slot_counts[x] > 1}
        self.above = np.array([self.hands.index(self.pose(slot)) for slot in range(self.held)] + [0])
        radices = (
            [len(self.hands)] + [self.held + 1] * len(self.obj_names) + [2] * (len(self.obj_names) * len(model.marks))
        )
        self.weights = [1]
        for radix in radices[:-1]:
            self.weights.append(self.weights[-1] * radix)
        if self.weights[-1] * radices[-1] >= 2**62:
            raise ModelError(f"{len(self.obj_names)} objects and {self.held} places are more than a state can hold")
        self.radices = radices

    def pose(self, slot: int) -> str:
        """Return the hand's pose over a slot."""
        x, i = self.slots[slot]
        return pose(self.names[x], i if self.slot_counts[x] > 1 else None)

    def mark_digit(self, obj: int, mark: str) -> int:
        """Return the digit that holds whether an object carries a mark."""
        return 1 + len(self.obj_names) + obj * len(self.marks) + self.marks.index(mark)

    def digit(self, codes: np.ndarray, d: int) -> np.ndarray:
        """Return one digit of every code."""
        return codes // self.weights[d] % self.radices[d]

    def decode(self, code: int) -> ManipulationState:
        """Return the state a code stands for."""
        digits = [code // w % r for w, r in zip(self.weights, self.radices, strict=True)]
        slots = dict(zip(self.obj_names, digits[1 : 1 + len(self.obj_names)], strict=True))
        resting = {obj: self.slots[slot] for obj, slot in slots.items() if slot != self.held}
        hand = self.hands[digits[0]]
        return ManipulationState(
            hand=location_of(hand),
            held=next((obj for obj, slot in slots.items() if slot == self.held), None),
            places=tuple((obj, self.names[x]) for obj, (x, _) in resting.items()),
            marks=frozenset(
                (obj, mark)
                for o, obj in enumerate(self.obj_names)
                for mark in self.marks
                if digits[self.mark_digit(o, mark)]
            ),
            slots=tuple((obj, i) for obj, (x, i) in resting.items() if self.slot_counts[x] > 1),
            hand_slot=self.hand_slots.get(hand),
        )

    def start_code(self) -> int:
        """Return the code of the start state.

        Raises:
            ModelError: it mentions what the model does not have, or leaves an object without a place.
        """
        where = self.start.place | ({self.start.held: None} if self.start.held else {})
        for obj in where.keys() - set(self.obj_names):
            raise ModelError(f"start: unknown object {obj!r} {choices(obj, self.obj_names)}")
        for obj in self.obj_names:
            if obj not in where:
                raise ModelError(f"start: {obj!r} is neither at a location nor in the hand")
            place = where[obj]
            if place is not None and place not in self.names:
                raise ModelError(f"start: {obj!r} at unknown location {place!r} {choices(place, self.names)}")
        resting = [(obj, str(where[obj])) for obj in self.obj_names if where[obj] is not None]
        slots = self.start_slots(resting)
        hand = pose(self.start.hand, self.start.hand_slot)
        code = self.hands.index(hand if hand in self.hands else self.start.hand)
        for o, obj in enumerate(self.obj_names):
            code += self.weights[1 + o] * slots.get(obj, self.held)
        for obj, mark in self.start.marks:
            if obj not in self.obj_names or mark not in self.marks:
                raise ModelError(f"start: {obj!r} cannot be marked {mark!r}")
            code += self.weights[self.mark_digit(self.obj_names.index(obj), mark)]
        return code

    def start_slots(self, resting: list[tuple[str, str]]) -> dict[str, int]:
        """Return the slot of every object that rests at first."""
        if sum(self.slot_counts) == len(self.names):
            return {obj: self.names.index(place) for obj, place in resting}
        found = slots_at_start(resting, dict(self.start.slots), self.model.slot_counts)
        return {obj: self.slots.index((self.names.index(place), found[obj])) for obj, place in resting}

    def successors(self, codes: np.ndarray) -> list[tuple[str, str, np.ndarray, np.ndarray]]:
        """Return (kind, action, mask, target codes of the masked) for every action, in the model's order."""
        at = self.digit(codes, 0)
        hand = self.over[at]
        slot = [self.digit(codes, 1 + o) for o in range(len(self.obj_names))]
        place = [self.location[s] for s in slot]
        count = [sum((p == x).astype(np.int8) for p in place) for x in range(self.nowhere)]
        free = [self.free_slots(x, slot, len(codes)) for x in range(self.nowhere)]
        accepts = [count[x] < where.capacity for x, where in enumerate(self.model.locations)]
        for x, where in enumerate(self.model.locations):
            accepts[x] = accepts[x] & (not where.closed)
            for support in where.on:
                accepts[x] = accepts[x] & (count[self.names.index(support)] > 0)
            for other in where.clear_of:
                accepts[x] = accepts[x] & (count[self.names.index(other)] == 0)
        clear = [np.ones(len(codes), dtype=bool) for _ in self.names]
        for x, where in enumerate(self.model.locations):
            for support in where.on:
                clear[self.names.index(support)] &= count[x] == 0
            for other in where.clear_of if where.closed else ():
                clear[x] &= count[self.names.index(other)] == 0
        empty = np.logical_and.reduce([p != self.nowhere for p in place]) if place else np.ones(len(codes), dtype=bool)
        found = []
        for x, name in enumerate(self.names):
            mask = empty & (hand != x)
            found.append(("transit", f"transit {name}", mask, codes[mask] + (x - at[mask])))
        for o, movable in enumerate(self.model.objects):
            mask = empty & (place[o] == hand) & (hand < self.nowhere)
            mask &= _pick(clear, hand) & (not movable.fixed)
            raised = self.weights[1 + o] * (self.held - slot[o][mask])
            target = codes[mask] + raised + self.above[slot[o][mask]] - at[mask]
            found.append(("grasp", f"grasp {movable.name}", mask, target))
        for o, obj in enumerate(self.obj_names):
            for x, name in enumerate(self.names):
                mask = (place[o] == self.nowhere) & (hand != x) & accepts[x]
                target = codes[mask] + self.above[free[x][mask]] - at[mask]
                found.append(("transport", f"transport {obj} {name}", mask, target))
        for o, obj in enumerate(self.obj_names):
            for x, spot in enumerate(self.model.locations):
                mask = (place[o] == self.nowhere) & (hand == x) & accepts[x]
                lowered = self.weights[1 + o] * (free[x][mask] - self.held)
                target = codes[mask] + lowered + self.above[free[x][mask]] - at[mask]
                if spot.marks:
                    d = self.mark_digit(o, spot.marks)
                    target = target + self.weights[d] * (1 - self.digit(codes[mask], d))
                found.append(("release", f"release {obj} {spot.name}", mask, target))
        return found

    def free_slots(self, x: int, slot: list[np.ndarray], number: int) -> np.ndarray:
        """Return the slot of a location into which an object would be put in each of a number of states."""
        first = self.slots.index((x, 0))
        if self.slot_counts[x] == 1:
            return np.full(number, first)
        taken = np.zeros((self.slot_counts[x], number), dtype=bool)
        for s in slot:
            taken |= s == first + np.arange(self.slot_counts[x])[:, None]
        return first + free_slot(taken)

    def build(self) -> TransitionSystem:
        """Generate the reachable states layer by layer and gather their edges, sorted by source."""
        matrix, unit = cost_matrix(self.model, self.hands)
        layer = np.array([self.start_code()], dtype=np.int64)
        codes = Numbering(self.weights[-1] * self.radices[-1])
        codes.add(layer)
        sources, targets, actions, costs = [], [], [], []
        action_names: list[str] = []
        while len(layer):
            found = self.successors(layer)
            action_names = [action for _, action, _, _ in found]
            for a, (kind, name, mask, target) in enumerate(found):
                before, after = self.digit(layer[mask], 0), self.digit(target, 0)
                cost = matrix[ACTION_KINDS.index(kind), before, after]
                for hand in before[cost == UNMEASURED]:
                    raise unmeasured(name, self.hands[hand])
                sources.append(layer[mask])
                targets.append(target)
                actions.append(np.full(len(target), a, dtype=np.int32))
                costs.append(cost)
            layer = codes.add(np.concatenate([target for *_, target in found]))
        source = codes.number(np.concatenate(sources))
        target = codes.number(np.concatenate(targets))
        action = np.concatenate(actions)
        order = np.argsort(source, kind="stable")
        labels, label_sets = self.labels(codes.all)
        return TransitionSystem(
            states=_Codes(self, codes.all),
            start=0,
            offsets=np.searchsorted(source[order], np.arange(len(codes.all) + 1)).astype(np.int64),
            targets=target[order].astype(np.int32),
            actions=action[order],
            costs=np.concatenate(costs)[order],
            unit=unit,
            labels=labels,
            action_names=tuple(action_names),
            label_sets=label_sets,
            propositions=self.propositions(),
        )

    def propositions(self) -> frozenset[str]:
        """Return every proposition of the model."""
        names = {f"holding_{obj}" for obj in self.obj_names}
        for place in (*self.names, *self.model.marks):
            names |= {f"{obj}_{place}" for obj in self.obj_names}
        return frozenset(names) | self.model.propositions

    def labels(self, codes: np.ndarray) -> tuple[np.ndarray, tuple[frozenset[str], ...]]:
        """Return each state's label as an index, and the distinct labels: all but the hand's pose matters."""
        keys, labels = np.unique(codes // self.radices[0], return_inverse=True)
        # Objects in other slots of the same locations give the same label.
        numbers: dict[frozenset[str], int] = {}
        merged = [numbers.setdefault(self.decode(int(key) * self.radices[0]).label, len(numbers)) for key in keys]
        return np.array(merged, dtype=np.int32)[labels], tuple(numbers)


def reachable(model: Description, start: ManipulationState) -> TransitionSystem:
    """Return every state of a manipulation model that is reachable from one of them."""
    return _Builder(model, start).build()


def _pick(rows: list[np.ndarray], index: np.ndarray) -> np.ndarray:
    return np.array(rows)[np.minimum(index, len(rows) - 1), np.arange(len(index))]
