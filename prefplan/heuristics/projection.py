"""The projection of a manipulation model for a set of tasks: a smaller model, and the map from states to its nodes.

For a set K of tasks, the projection keeps the objects that occur in K's propositions. Objects left out never block an
action: preconditions on them, and supports, are dropped, and slots are not told apart. All locations of capacity one
that K does not mention may be merged. Every step of the model maps to a step of the projection or to none: an action on
an object left out moves at most the hand.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from prefplan.models.costs import CostTable
from prefplan.models.kernels import Integer, inner_kernel
from prefplan.models.manipulation.codes import StateCodes
from prefplan.models.manipulation.listing import listed, moves_of
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.successors import canonical, unpack
from prefplan.models.manipulation.symbolic import ManipulationState
from prefplan.models.manipulation.symmetry import Symmetry
from prefplan.models.transition_system import TransitionSystem

KINDS = ("transit", "grasp", "transport", "release")
"""The kinds of actions, by number."""


@dataclass(frozen=True)
class Projection:
    """The projection for a set of tasks.

    Attributes:
        number: of the projection.
        tasks: the set.
        space: how its states are encoded.
        merged: names of its locations that are merged.
        codes: (S,) int64, of its states.
        system: its transition system, in which the cost of an edge is the number of its price, as in
            `prefplan.models.manipulation.successors.Steps`.
        places: by location of the model, the number here; -1 for merged ones.
        hands: (H,) by pose of the hand in the model, the number here; -1 over merged locations.
    """

    number: int
    tasks: tuple[int, ...]
    space: StateCodes
    merged: tuple[str, ...]
    codes: np.ndarray
    system: TransitionSystem
    places: list[int]
    hands: list[int]

    @classmethod
    def of(
        cls,
        number: int,
        tasks: tuple[int, ...],
        whole: StateCodes,
        view: Symmetry,
        kept: Sequence[str],
        start: ManipulationState,
        names: frozenset[str],
    ) -> Projection:
        """List the states of a projection of a `whole` model onto the objects that are `kept`.

        Its `view` is the model without supports and slots, and says which locations are merged; `names` are the
        propositions of the tasks.
        """
        small = _without(view, kept, start)
        symmetry = Symmetry(small, names, places_alike=bool(view.neutral))
        space = StateCodes(small, names)
        moves = moves_of(space, symmetry)
        poses = len(space.hands)
        prices = CostTable("price", np.arange(len(KINDS) * poses**2).reshape(-1, poses, poses), Fraction(1))
        first = int(canonical(moves, space.encode(small.initial_state, where="start")))
        system, codes = listed(space, moves, [prices], first, names)
        merged = view.neutral_locations
        places = [-1 if name in merged else space.locations.index(name) for name in whole.locations]
        hands = [
            space.hands.index(hand) if x == len(places) else places[x]
            for hand, x in zip(whole.hands, whole.over, strict=True)
        ]
        return cls(number, tasks, space, symmetry.neutral_locations, codes, system, places, hands)


def _without(view: Symmetry, kept: Sequence[str], start: ManipulationState) -> ManipulationModel:
    """Return a model with only some objects, and only as many merged locations as these need."""
    merged = view.neutral_locations
    needed = merged[: len(kept) + 1]
    locations = tuple(p for p in view.model.locations if p.name not in merged or p.name in needed)
    free: Iterator[str] = iter(needed)
    places, hand = {}, start.hand
    for obj in kept:
        place = start.place.get(obj)
        if place is not None:
            places[obj] = next(free) if place in merged else place
            hand = places[obj] if place == start.hand and place in merged else hand
    if hand in merged and hand not in places.values():
        hand = next(free)
    objects = tuple(
        replace(obj, start=places.get(obj.name, locations[0].name)) for obj in view.model.objects if obj.name in kept
    )
    begin = ManipulationState(hand, start.held if start.held in kept else None, tuple(places.items()))
    small = replace(view.model, locations=locations, objects=objects, begin=begin)
    marks = frozenset((obj, mark) for obj, mark in start.marks if obj in kept and mark in small.marks)
    return replace(small, begin=replace(begin, marks=marks))


class ProjectionArrays(NamedTuple):
    """M projections of a model of S slots, H poses of the hand, O objects and D digits.

    Attributes:
        weights: (M, D) int64, weight of each digit in a projection's states, 0 if it is not seen, negative for marks.
        slots: (M, S + 1) int64, location in the projection, -1 for merged ones.
        hands: (M, H) int64, pose in the projection, -1 over merged locations.
        places: (M, n) int64, the locations of the projection that stand for merged ones.
        above: (S + 1,) int64, pose of the hand over each slot.
        radices: (D,) int64, number of values of each digit, and digits: (D,) int64, scratch: digits of a state.
        first: (M,) int64, numbers: (X,) int32: numbers[first[m] + state] is the node of a projection's state.
    """

    weights: np.ndarray
    slots: np.ndarray
    hands: np.ndarray
    places: np.ndarray
    above: np.ndarray
    radices: np.ndarray
    digits: np.ndarray
    first: np.ndarray
    numbers: np.ndarray


def arrays_of(projections: Sequence[Projection], whole: StateCodes) -> ProjectionArrays:
    """Return projections of a model as arrays, given how the model's states are encoded."""
    weights = np.zeros((len(projections), len(whole.radices)), dtype=np.int64)
    places = np.zeros((len(projections), max(len(one.merged) for one in projections) + 1), dtype=np.int64)
    numbers = []
    for m, one in enumerate(projections):
        space = one.space
        for o, obj in enumerate(space.objects):
            weights[m, 1 + whole.objects.index(obj)] = space.weights[1 + o]
        for pair, d in space.mark_digits.items():
            weights[m, whole.mark_digits[pair]] = -space.weights[d]
        places[m, : len(one.merged)] = [space.locations.index(name) for name in one.merged]
        numbers.append(np.zeros(space.bound, dtype=np.int32))
        numbers[m][one.codes] = np.arange(one.system.size)
    slots = np.array([[*one.places, one.space.held] for one in projections])
    first = np.cumsum([0, *map(len, numbers)])[:-1].astype(np.int64)
    radices = np.array(whole.radices, dtype=np.int64)
    return ProjectionArrays(
        weights=weights,
        slots=np.ascontiguousarray(slots[:, whole.location]),  # kernels are compiled for each order in memory
        hands=np.array([one.hands for one in projections]),
        places=places,
        above=whole.above.astype(np.int64),
        radices=radices,
        digits=np.zeros_like(radices),
        first=first,
        numbers=np.concatenate(numbers),
    )


@inner_kernel
def observe(projections: ProjectionArrays | None, node: Integer) -> None:
    """Write the digits of a state whose bounds are looked up; nothing to do where states are listed."""
    if projections is not None:
        unpack(projections.radices, node, projections.digits)


@inner_kernel
def place_of(projections: ProjectionArrays | None, projection: Any, p: Integer, node: Integer) -> Integer:
    """Return the node that table p has for the observed state: that of its projection; the state's, if there is none.

    Which projection each table has, (P,) or None, is `projection`; `node` is the state.
    """
    if projections is None:
        return node
    m, digits = projection[p], projections.digits
    hand, held = digits[0], projections.slots.shape[1] - 1
    state, moved, rank = np.int64(0), projections.hands[m, hand], 0
    for d in range(1, digits.shape[0]):
        weight = projections.weights[m, d]
        if weight == 0:
            continue
        value = digits[d]
        if weight < 0:
            # A mark: it has no location.
            state -= weight * value
            continue
        slot = projections.slots[m, value]
        if slot < 0:
            slot = projections.places[m, rank]
            rank += 1
            if value < held and projections.above[value] == hand:
                moved = slot
        state += weight * slot
    if moved < 0:
        moved = projections.places[m, rank]
    return np.int64(projections.numbers[projections.first[m] + state + moved])
