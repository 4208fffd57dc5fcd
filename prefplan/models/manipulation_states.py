"""The reachable states of a manipulation model, generated a whole breadth-first layer at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from prefplan.errors import ModelError, choices
from prefplan.models.action_costs import ACTION_KINDS, UNMEASURED, cost_matrix, unmeasured
from prefplan.transition_system import TransitionSystem

if TYPE_CHECKING:
    from prefplan.models.manipulation import ManipulationModel


@dataclass(frozen=True)
class ManipulationState:
    """One symbolic state.

    Attributes:
        hand: location the hand is over, or the start pose's name.
        held: object in the hand, or None.
        places: (object, location) for every object that rests somewhere, in the model's order.
        marks: (object, mark) for every mark an object carries.
    """

    hand: str
    held: str | None
    places: tuple[tuple[str, str], ...]
    marks: frozenset[tuple[str, str]] = frozenset()

    @property
    def place(self) -> dict[str, str]:
        """The location of every object that rests somewhere."""
        return dict(self.places)

    @property
    def label(self) -> frozenset[str]:
        """The propositions true in this state."""
        names = {f"{thing}_{place}" for thing, place in (*self.places, *self.marks)}
        return frozenset(names | ({f"holding_{self.held}"} if self.held else set()))

    def __str__(self) -> str:
        """Return the state on one line."""
        parts = [f"hand at {self.hand}"]
        if self.held:
            parts.append(f"holding {self.held}")
        parts += [f"{o} on {place}" for o, place in self.places]
        parts += [f"{o} {mark}" for o, mark in sorted(self.marks)]
        return ", ".join(parts)


class _Codes(Sequence[ManipulationState]):
    """Reachable states by number, decoded on demand."""

    def __init__(self, builder: _Builder, codes: np.ndarray) -> None:
        self._builder, self._codes = builder, codes

    def __len__(self) -> int:
        return len(self._codes)

    def __getitem__(self, index):  # type: ignore[no-untyped-def]
        if isinstance(index, slice):
            return [self._builder.decode(int(code)) for code in self._codes[index]]
        return self._builder.decode(int(self._codes[index]))


class _Builder:
    """Codes of states, and the edges between them.

    A state is one mixed-radix integer: the hand's pose, then each object's place (the last one: in the hand),
    then one bit for each object and mark.
    """

    def __init__(self, model: ManipulationModel, start: ManipulationState) -> None:
        self.model = model
        self.start = start
        self.marks = model.marks
        self.names = [place.name for place in model.locations]
        self.things = [thing.name for thing in model.objects]
        self.hands = self.names + ([start.hand] if start.hand not in self.names else [])
        self.held = len(self.names)
        radices = [len(self.hands)] + [self.held + 1] * len(self.things) + [2] * (len(self.things) * len(model.marks))
        self.weights = [1]
        for radix in radices[:-1]:
            self.weights.append(self.weights[-1] * radix)
        if self.weights[-1] * radices[-1] >= 2**62:
            raise ModelError(f"{len(self.things)} objects and {self.held} locations are more than a state can hold")
        self.radices = radices

    def mark_digit(self, thing: int, mark: str) -> int:
        """Return the digit that holds whether an object carries a mark."""
        return 1 + len(self.things) + thing * len(self.marks) + self.marks.index(mark)

    def digit(self, codes: np.ndarray, d: int) -> np.ndarray:
        """Return one digit of every code."""
        return codes // self.weights[d] % self.radices[d]

    def decode(self, code: int) -> ManipulationState:
        """Return the state a code stands for."""
        digits = [code // w % r for w, r in zip(self.weights, self.radices, strict=True)]
        places = digits[1 : 1 + len(self.things)]
        return ManipulationState(
            hand=self.hands[digits[0]],
            held=next((o for o, p in zip(self.things, places, strict=True) if p == self.held), None),
            places=tuple((o, self.names[p]) for o, p in zip(self.things, places, strict=True) if p != self.held),
            marks=frozenset(
                (thing, mark)
                for o, thing in enumerate(self.things)
                for mark in self.marks
                if digits[self.mark_digit(o, mark)]
            ),
        )

    def start_code(self) -> int:
        """Return the code of the start state.

        Raises:
            ModelError: it mentions what the model does not have, or leaves an object without a place.
        """
        where = self.start.place | ({self.start.held: None} if self.start.held else {})
        for thing in where.keys() - set(self.things):
            raise ModelError(f"start: unknown object {thing!r} {choices(thing, self.things)}")
        code = self.hands.index(self.start.hand)
        for o, thing in enumerate(self.things):
            if thing not in where:
                raise ModelError(f"start: {thing!r} is neither at a location nor in the hand")
            place = where[thing]
            if place is not None and place not in self.names:
                raise ModelError(f"start: {thing!r} at unknown location {place!r} {choices(place, self.names)}")
            code += self.weights[1 + o] * (self.held if place is None else self.names.index(place))
        for thing, mark in self.start.marks:
            if thing not in self.things or mark not in self.marks:
                raise ModelError(f"start: {thing!r} cannot be marked {mark!r}")
            code += self.weights[self.mark_digit(self.things.index(thing), mark)]
        return code

    def successors(self, codes: np.ndarray) -> list[tuple[str, str, np.ndarray, np.ndarray]]:
        """Return (kind, action, mask, target codes of the masked) for every action, in the model's order."""
        hand = self.digit(codes, 0)
        place = [self.digit(codes, 1 + o) for o in range(len(self.things))]
        count = [sum((p == x).astype(np.int8) for p in place) for x in range(self.held)]
        room = [count[x] < where.capacity for x, where in enumerate(self.model.locations)]
        for x, where in enumerate(self.model.locations):
            room[x] = room[x] & (not where.closed)
            for support in where.on:
                room[x] = room[x] & (count[self.names.index(support)] > 0)
            for other in where.clear_of:
                room[x] = room[x] & (count[self.names.index(other)] == 0)
        clear = [np.ones(len(codes), dtype=bool) for _ in self.names]
        for x, where in enumerate(self.model.locations):
            for support in where.on:
                clear[self.names.index(support)] &= count[x] == 0
            for other in where.clear_of if where.closed else ():
                clear[x] &= count[self.names.index(other)] == 0
        empty = np.logical_and.reduce([p != self.held for p in place]) if place else np.ones(len(codes), dtype=bool)
        found = []
        for x, name in enumerate(self.names):
            mask = empty & (hand != x)
            found.append(("transit", f"transit {name}", mask, codes[mask] + (x - hand[mask])))
        for o, movable in enumerate(self.model.objects):
            mask = empty & (place[o] == hand) & (hand < self.held)
            mask &= _pick(clear, hand) & (not movable.fixed)
            found.append(
                (
                    "grasp",
                    f"grasp {movable.name}",
                    mask,
                    codes[mask] + self.weights[1 + o] * (self.held - place[o][mask]),
                )
            )
        for o, thing in enumerate(self.things):
            for x, name in enumerate(self.names):
                mask = (place[o] == self.held) & (hand != x) & room[x]
                found.append(("transport", f"transport {thing} {name}", mask, codes[mask] + (x - hand[mask])))
        for o, thing in enumerate(self.things):
            for x, spot in enumerate(self.model.locations):
                mask = (place[o] == self.held) & (hand == x) & room[x]
                target = codes[mask] + self.weights[1 + o] * (x - self.held)
                if spot.marks:
                    d = self.mark_digit(o, spot.marks)
                    target = target + self.weights[d] * (1 - self.digit(codes[mask], d))
                found.append(("release", f"release {thing} {spot.name}", mask, target))
        return found

    def build(self) -> TransitionSystem:
        """Generate the reachable states layer by layer and gather their edges, sorted by source."""
        matrix, decimals = cost_matrix(self.model, self.hands)
        layer = np.array([self.start_code()], dtype=np.int64)
        codes = _Numbering(self.weights[-1] * self.radices[-1])
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
            decimals=decimals,
            labels=labels,
            action_names=tuple(action_names),
            label_sets=label_sets,
            propositions=self.propositions(),
        )

    def propositions(self) -> frozenset[str]:
        """Return every proposition of the model."""
        names = {f"holding_{thing}" for thing in self.things}
        for place in (*self.names, *self.model.marks):
            names |= {f"{thing}_{place}" for thing in self.things}
        return frozenset(names) | self.model.propositions

    def labels(self, codes: np.ndarray) -> tuple[np.ndarray, tuple[frozenset[str], ...]]:
        """Return each state's label as an index, and the distinct labels: all but the hand's pose matters."""
        keys, labels = np.unique(codes // self.radices[0], return_inverse=True)
        sets = []
        for key in keys:
            sets.append(self.decode(int(key) * self.radices[0]).label)
        return labels.astype(np.int32), tuple(sets)


def reachable(model: ManipulationModel, start: ManipulationState) -> TransitionSystem:
    """Return every state of a manipulation model that is reachable from one of them."""
    return _Builder(model, start).build()


def _pick(rows: list[np.ndarray], index: np.ndarray) -> np.ndarray:
    return np.array(rows)[np.minimum(index, len(rows) - 1), np.arange(len(index))]


DENSE = 2**28
"""Codes up to here are looked up in an array of all possible ones."""


class _Numbering:
    """Codes in the order in which they were added, and the way back."""

    def __init__(self, bound: int) -> None:
        self._layers: list[np.ndarray] = []
        self._count = 0
        self._index = np.full(bound, -1, dtype=np.int32) if bound <= DENSE else None
        self._sorted = np.empty(0, dtype=np.int64)

    @property
    def all(self) -> np.ndarray:
        """All codes, by number."""
        return np.concatenate(self._layers)

    def add(self, codes: np.ndarray) -> np.ndarray:
        """Number codes that are new, smallest first, and return them."""
        if self._index is not None:
            new = np.unique(codes[self._index[codes] < 0])
            self._index[new] = np.arange(self._count, self._count + len(new), dtype=np.int32)
        else:
            new = np.setdiff1d(codes, self._sorted)
            self._sorted = np.union1d(self._sorted, new)
        self._layers.append(new)
        self._count += len(new)
        return new

    def number(self, codes: np.ndarray) -> np.ndarray:
        """Return the numbers of codes."""
        if self._index is not None:
            return self._index[codes]
        rank = np.argsort(self.all)
        return rank[np.searchsorted(self.all, codes, sorter=rank)]
