"""The states of a manipulation model, one at a time, rule by rule."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple


class Arm(NamedTuple):
    """A state: the hand's pose, the object in it, the location and slot of each other object, and the marks."""

    hand: str
    held: str | None
    places: tuple[tuple[str, int] | None, ...]
    marks: frozenset[tuple[str, str]] = frozenset()


class Cell:
    """A manipulation model; slots are told apart only where costs are measured."""

    def __init__(self, model: Any) -> None:
        self.model = model
        self.spots = {place.name: place for place in model.locations}
        self.names = [obj.name for obj in model.objects]
        self.measured: Mapping[Any, Any] | None = getattr(model.costs, "entries", None)

    def start(self, state: Any) -> Arm:
        """Return a state of the model, whose slots are the first free ones, in the order of the objects."""
        given, full = dict(state.places), list[tuple[str, int]]()
        places: list[tuple[str, int] | None] = []
        for name in self.names:
            slot = None if name not in given else (given[name], self._first(given[name], full))
            full += [] if slot is None else [slot]
            places.append(slot)
        return Arm(state.hand, state.held, tuple(places), state.marks)

    def _first(self, location: str, full: list[tuple[str, int]]) -> int:
        slots = range(self.spots[location].capacity if self.measured is not None else 1)
        return next((i for i in slots if (location, i) not in full), 0)

    def label(self, arm: Arm) -> frozenset[str]:
        """Return the propositions that hold in a state."""
        names = {f"{obj}_{place[0]}" for obj, place in zip(self.names, arm.places, strict=True) if place}
        names |= {f"{obj}_{mark}" for obj, mark in arm.marks}
        return frozenset(names | {f"holding_{arm.held}"} if arm.held else names)

    def steps(self, arm: Arm) -> Iterator[tuple[str, Any, Arm]]:
        """Yield the actions of a state, each with its cost or costs and the state after it."""
        here = arm.hand.partition("[")[0]
        for action, after in self._load(arm, here) if arm.held else self._empty(arm, here):
            kind = action.split()[0]
            if self.measured is None:
                yield action, self.model.costs[kind], after
            elif (kind, arm.hand, after.hand) in self.measured:
                yield action, self.measured[kind, arm.hand, after.hand], after

    def _empty(self, arm: Arm, here: str) -> Iterator[tuple[str, Arm]]:
        for name in self.spots:
            if name != here:
                yield f"transit {name}", arm._replace(hand=name)
        occupied = [place[0] for place in arm.places if place]
        if any(here in self.spots[name].on for name in occupied):
            return
        if (
            here in self.spots
            and self.spots[here].closed
            and any(name in occupied for name in self.spots[here].clear_of)
        ):
            return
        for k, obj in enumerate(self.model.objects):
            place = arm.places[k]
            if place is not None and place[0] == here and not obj.fixed:
                lifted = (*arm.places[:k], None, *arm.places[k + 1 :])
                yield f"grasp {obj.name}", arm._replace(hand=self._over(place), held=obj.name, places=lifted)

    def _load(self, arm: Arm, here: str) -> Iterator[tuple[str, Arm]]:
        k = self.names.index(str(arm.held))
        for name in self.spots:
            if name != here and self._has_room(arm, name):
                yield f"transport {arm.held} {name}", arm._replace(hand=self._over(self._free(arm, name)))
        if here in self.spots and self._has_room(arm, here):
            place, mark = self._free(arm, here), self.spots[here].marks
            put = (*arm.places[:k], place, *arm.places[k + 1 :])
            marks = arm.marks | ({(str(arm.held), mark)} if mark else set())
            yield f"release {arm.held} {here}", Arm(self._over(place), None, put, marks)

    def _has_room(self, arm: Arm, name: str) -> bool:
        spot, occupied = self.spots[name], [place[0] for place in arm.places if place]
        if spot.closed or occupied.count(name) >= spot.capacity:
            return False
        return all(below in occupied for below in spot.on) and not any(other in occupied for other in spot.clear_of)

    def _free(self, arm: Arm, name: str) -> tuple[str, int]:
        """Return the slot of a location into which an object is put."""
        taken = {place[1] for place in arm.places if place and place[0] == name}
        free = [i for i in range(self.spots[name].capacity) if i not in taken] if self.measured is not None else [0]
        # Two slots off is as good as any; the first of those that are as good.
        return name, min(free, key=lambda i: (-min([2, *(abs(i - j) for j in taken)]), i))

    def _over(self, place: tuple[str, int]) -> str:
        """Return the hand's pose over a slot."""
        name, i = place
        return f"{name}[{i}]" if self.measured is not None and self.spots[name].capacity > 1 else name
