"""Exclusions: actions of a manipulation model that do not exist in some states, such as those that no arm can do.

An action of an exclusion does not exist where all of the exclusion's conditions hold: an object rests at a location, is
in the hand, or has a mark. In `prefplan.models.system.Barred` they are texts; here they are read for one model.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from prefplan.models.manipulation.operators import read_action
from prefplan.models.manipulation.symbolic import Action, at, holding, marked
from prefplan.models.system import Barred

if TYPE_CHECKING:
    from prefplan.models.manipulation.codes import StateCodes
    from prefplan.models.manipulation.model import ManipulationModel

IN_HAND = ""
"""Stands for the hand, where a condition names the location or the mark of an object."""


Exclusion = tuple[Action, frozenset[tuple[str, str]]]
"""An action that does not exist where all the conditions hold: (object, location) for an object that rests there,
(object, mark), and (object, `IN_HAND`); no location has the name of a mark, as their propositions would be the same."""


def read_exclusions(model: ManipulationModel, barred: Barred) -> frozenset[Exclusion]:
    """Return exclusions given as texts, without those that concern no state of a model.

    Raises:
        ModelError: an action is of an unknown kind, or has not the names that its kind has.
    """
    places, read = [place.name for place in model.locations], dict[str, tuple[str, str]]()
    for obj in (obj.name for obj in model.objects):
        read |= {holding(obj): (obj, IN_HAND)} | {at(obj, place): (obj, place) for place in places}
        read |= {marked(obj, mark): (obj, mark) for mark in model.marks}
    objects, locations = {"", *(obj.name for obj in model.objects)}, {"", *places}
    actions = [(read_action(text, model.operators), names) for names, text in barred]
    return frozenset(
        (action, frozenset(read[name] for name in names))
        for action, names in actions
        if action.obj in objects and action.location in locations and names <= read.keys()
    )


def classes(
    names: Sequence[str], exclusions: Collection[Exclusion], *, objects: bool = False
) -> tuple[tuple[str, ...], ...]:
    """Return names of locations or objects in classes: to exchange two of one leaves a set of exclusions as it is."""
    found: list[list[str]] = []
    for name in names:
        for each in found:
            swap = {name: each[0], each[0]: name}
            swaps = (swap, {}) if objects else ({}, swap)
            if all(_renamed(one, *swaps) in exclusions for one in exclusions):
                each.append(name)
                break
        else:
            found.append([name])
    return tuple(map(tuple, found))


def _renamed(exclusion: Exclusion, objects: Mapping[str, str], locations: Mapping[str, str]) -> Exclusion:
    """Return an exclusion with other names for some objects and locations."""
    action, conditions = exclusion
    obj, location = objects.get(action.obj, action.obj), locations.get(action.location, action.location)
    pairs = frozenset((objects.get(one, one), locations.get(what, what)) for one, what in conditions)
    return replace(action, obj=obj, location=location), pairs


def exclusion_arrays(
    space: StateCodes, actions: Sequence[str], exclusions: Collection[Exclusion]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return exclusions as in `Moves`, given the encoding of the states and the texts of the actions."""
    first_slot = np.searchsorted(space.location, np.arange(len(space.locations) + 1)).tolist()
    slots = {name: first_slot[x : x + 2] for x, name in enumerate(space.locations)}
    slots[IN_HAND] = [space.held, space.held + 1]

    def condition(obj: str, what: str) -> list[int]:
        is_mark = what not in slots
        return [space.mark_digits[obj, what], 1, 2] if is_mark else [1 + space.objects.index(obj), *slots[what]]

    number = {text: a for a, text in enumerate(actions)}
    ordered = sorted((number[str(action)], sorted(conditions)) for action, conditions in exclusions)
    rows = [[condition(*pair) for pair in conditions] for _, conditions in ordered]
    of_action = np.searchsorted([a for a, _ in ordered], np.arange(len(actions) + 1))
    conditions = np.array([row for each in rows for row in each], dtype=np.int64).reshape(-1, 3)
    return of_action.astype(np.int32), np.cumsum([0, *map(len, rows)]).astype(np.int32), conditions
