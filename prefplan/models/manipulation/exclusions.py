"""Exclusions: actions of a manipulation model that do not exist in some states, such as those that no arm can do.

An action of an exclusion does not exist where all of the exclusion's conditions hold: an object rests at a location, is
in the hand, or has a mark. In `prefplan.models.system.Barred` they are texts; here they are read for one model.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from prefplan.models.manipulation.operators import read_action
from prefplan.models.manipulation.symbolic import Action, at, holding, marked
from prefplan.models.system import Barred

if TYPE_CHECKING:
    from prefplan.models.manipulation.codes import StateCodes
    from prefplan.models.manipulation.model import ManipulationModel


@dataclass(frozen=True)
class Exclusion:
    """An action that does not exist where all the conditions hold.

    Attributes:
        action: the action.
        places: objects that rest at locations, each as (object, location).
        held: objects in the hand.
        marks: marks of objects, each as (object, mark).
    """

    action: Action
    places: frozenset[tuple[str, str]] = frozenset()
    held: frozenset[str] = frozenset()
    marks: frozenset[tuple[str, str]] = frozenset()

    @property
    def locations(self) -> frozenset[str]:
        """The locations that it names."""
        return frozenset(place for _, place in self.places) | {self.action.location}

    @property
    def blockers(self) -> frozenset[str]:
        """The objects on which its conditions depend, without that of its action."""
        return (frozenset(obj for obj, _ in (*self.places, *self.marks)) | self.held) - {self.action.obj}

    def with_objects_exchanged(self, one: str, other: str) -> Exclusion:
        """Return the same with one object in place of another, and the other way round."""
        swap = {one: other, other: one}
        return Exclusion(
            replace(self.action, obj=swap.get(self.action.obj, self.action.obj)),
            frozenset((swap.get(obj, obj), place) for obj, place in self.places),
            frozenset(swap.get(obj, obj) for obj in self.held),
            frozenset((swap.get(obj, obj), mark) for obj, mark in self.marks),
        )

    def with_locations_exchanged(self, one: str, other: str) -> Exclusion:
        """Return the same with one location in place of another, and the other way round."""
        swap = {one: other, other: one}
        return replace(
            self,
            action=replace(self.action, location=swap.get(self.action.location, self.action.location)),
            places=frozenset((obj, swap.get(place, place)) for obj, place in self.places),
        )


def read_exclusions(model: ManipulationModel, barred: Barred) -> frozenset[Exclusion]:
    """Return exclusions given as texts, without those that concern no state of a model.

    Raises:
        ModelError: an action is of an unknown kind, or has not the names that its kind has.
    """
    names = [obj.name for obj in model.objects]
    places = {at(obj, place.name): (obj, place.name) for obj in names for place in model.locations}
    held = {holding(obj): obj for obj in names}
    marks = {marked(obj, mark): (obj, mark) for obj in names for mark in model.marks}
    objects, locations = {"", *names}, {"", *(place.name for place in model.locations)}

    def found() -> Iterator[Exclusion]:
        for conditions, text in barred:
            action = read_action(text, model.operators)
            if action.obj in objects and action.location in locations and conditions <= {*places, *held, *marks}:
                yield Exclusion(
                    action,
                    frozenset(places[name] for name in conditions & places.keys()),
                    frozenset(held[name] for name in conditions & held.keys()),
                    frozenset(marks[name] for name in conditions & marks.keys()),
                )

    return frozenset(found())


def classes(
    names: Sequence[str], exclusions: Collection[Exclusion], exchanged: Callable[[Exclusion, str, str], Exclusion]
) -> tuple[tuple[str, ...], ...]:
    """Return some names in classes: to exchange two of one class leaves a set of exclusions as it is.

    Args:
        names: of objects or of locations.
        exclusions: the set.
        exchanged: returns an exclusion with two names exchanged.
    """
    found: list[list[str]] = []
    for name in names:
        like = (each for each in found if all(exchanged(one, each[0], name) in exclusions for one in exclusions))
        if (home := next(like, None)) is not None:
            home.append(name)
        else:
            found.append([name])
    return tuple(map(tuple, found))


@dataclass(frozen=True)
class ExclusionArrays:
    """B exclusions with C conditions, of a model of A actions.

    Attributes:
        of_action: (A + 1,) int32, the first exclusion of each action, and B.
        first: (B + 1,) int32, the first condition of each exclusion, and C.
        conditions: (C, 3) int64, each a digit of a state, and the values from the second number to below the third that
            it must have.
    """

    of_action: np.ndarray
    first: np.ndarray
    conditions: np.ndarray

    @classmethod
    def of(cls, space: StateCodes, actions: Sequence[str], exclusions: Collection[Exclusion]) -> ExclusionArrays:
        """Return exclusions as arrays, given the encoding of the states and the texts of the actions."""
        number = {text: a for a, text in enumerate(actions)}
        digit = {obj: 1 + o for o, obj in enumerate(space.objects)}
        first_slot = np.searchsorted(space.location, np.arange(len(space.locations) + 1)).tolist()
        slots = {name: first_slot[x : x + 2] for x, name in enumerate(space.locations)}
        ordered = sorted(exclusions, key=lambda each: number[str(each.action)])
        rows = [
            [
                *((digit[obj], *slots[place]) for obj, place in sorted(each.places)),
                *((digit[obj], space.held, space.held + 1) for obj in sorted(each.held)),
                *((space.mark_digits[pair], 1, 2) for pair in sorted(each.marks)),
            ]
            for each in ordered
        ]
        return cls(
            of_action=np.searchsorted(
                [number[str(each.action)] for each in ordered], np.arange(len(actions) + 1)
            ).astype(np.int32),
            first=np.cumsum([0, *map(len, rows)]).astype(np.int32),
            conditions=np.array([row for each in rows for row in each], dtype=np.int64).reshape(-1, 3),
        )
