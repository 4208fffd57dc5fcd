"""The projection of a manipulation model for a set of tasks: a smaller model, and the map from states to its nodes.

For a set K of tasks, the projection keeps the objects that occur in K's propositions. Objects left out never block an
action: preconditions on them, and supports, are dropped, and slots are not told apart. All locations of capacity one
that K does not mention may be merged. Every step of the model maps to a step of the projection or to none: an action on
an object left out moves at most the hand. Exclusions that name only kept objects and locations that are not merged hold
in the projection, too: a task that needs an action that is excluded everywhere is found to be impossible.
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from prefplan.models.costs import CostTable
from prefplan.models.kernels import Integer, inner_kernel
from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.models.manipulation.codes import StateCodes
from prefplan.models.manipulation.listing import listed, moves_of
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.successors import canonical, unpack
from prefplan.models.manipulation.symbolic import ManipulationState, at
from prefplan.models.manipulation.symmetry import IN_HAND, Symmetry, read_exclusions
from prefplan.models.transition_system import TransitionSystem
from prefplan.product.product_automaton import Product
from prefplan.product.reduction import GeneratedProduct

APART_ENTRIES = 400_000
"""Most entries of a table, by an upper bound, for which locations with measured costs, or named by exclusions, are not
merged. If measured locations are always merged, fronts of three and four objects take 1.1 and 2.2 times as long."""


class Projection:
    """The projection for a set of tasks; its states are listed once they are needed.

    Attributes:
        tasks: the set.
        names: the tasks' propositions.
        kept: the objects that occur in `names`.
        view: the model without supports, slots and costs, and which of its locations are merged.
        entries: an upper bound of the number of entries of a table of the tasks, not counting marks.
    """

    def __init__(self, product: GeneratedProduct, tasks: tuple[int, ...]) -> None:
        """Find what the tasks see of a product's model."""
        self.tasks, self._problem = tasks, product.problem
        self._whole, self._start = product.model.space, product.model.start
        self.names: frozenset[str] = frozenset().union(*(product.automata[i].propositions for i in tasks))
        model = self._whole.model
        seen = {obj.name: {name for name, _ in model.propositions_of(obj.name)} & self.names for obj in model.objects}
        self.kept = [obj for obj in seen if seen[obj]]
        locations = tuple(replace(place, at=place.at or (0.0, 0.0), on=(), clear_of=()) for place in model.locations)
        relaxed = replace(model, locations=locations, costs=dict.fromkeys(model.kinds, 0))
        # Exclusions that may hold in the projection, too, each with the locations that it names.
        self._barred = {
            one: {action.location, origin, *(what for _, what in pairs)} - {"", IN_HAND}
            for one in product.model.symmetry.barred
            for action, pairs, origin in read_exclusions(model, [one])
            if action.obj in self.kept and all(obj in self.kept and what not in model.marks for obj, what in pairs)
        }
        named = {at(obj, place) for obj in self.kept for place in set[str]().union(*self._barred.values())}
        merging = (False, True) if isinstance(model.costs, MeasuredCosts) else (True,)
        for apart_names, merges in itertools.product((named, set[str]()), merging):
            self.view = Symmetry(relaxed, self.names | apart_names, places_alike=merges)
            apart, objects = len(locations) - len(self.view.neutral_locations), len(self.kept)
            states = (apart + 2) ** objects * (apart + objects + 2)
            self.entries: int = states * math.prod(product.sizes[list(tasks)].tolist())
            if self.entries <= APART_ENTRIES:
                break

    @cached_property
    def symmetry(self) -> Symmetry:
        """The smaller model, and its locations that are merged."""
        model, merged = _without(self.view, self.kept, self._start), self.view.neutral_locations
        barred = [one for one, places in self._barred.items() if places.isdisjoint(merged)]
        return Symmetry(model, self.view.visible, barred, places_alike=bool(merged))

    @cached_property
    def space(self) -> StateCodes:
        """How the projection's states are encoded."""
        return StateCodes(self.symmetry.model, self.names, self.symmetry.origins)

    @cached_property
    def _listed(self) -> tuple[TransitionSystem, np.ndarray]:
        moves, poses = moves_of(self.space, self.symmetry), len(self.space.hands)
        numbers = np.arange(len(self.space.model.kinds) * poses**2).reshape(-1, poses, poses)
        start = self.space.encode(self.space.model.initial_state, where="start")
        prices = CostTable("price", numbers, self._problem.cost_units[0])
        return listed(self.space, moves, [prices], int(canonical(moves, start)), self.names)

    @property
    def codes(self) -> np.ndarray:
        """(S,) int64, codes of the projection's states."""
        return self._listed[1]

    @cached_property
    def product(self) -> Product:
        """Its product with the tasks' automata; the cost of an edge, without low bits, is its price as in `Steps`."""
        system = replace(self._listed[0], propositions=self._problem.system.propositions)
        return Product(self._problem.over(system, self.tasks))

    @cached_property
    def merged(self) -> list[int]:
        """The locations that stand for merged ones."""
        return [self.space.locations.index(name) for name in self.symmetry.neutral_locations]

    @cached_property
    def places(self) -> list[int]:
        """(L,) number in the projection of each location of the model; -1 for merged ones."""
        merged, locations = self.view.neutral_locations, self.space.locations
        return [-1 if name in merged else locations.index(name) for name in self._whole.locations]

    @cached_property
    def hands(self) -> list[int]:
        """(H,) number in the projection of each pose of the hand in the model; -1 over merged locations."""
        pairs = zip(self._whole.hands, self._whole.over, strict=True)
        elsewhere = len(self.places)
        return [self.space.hands.index(hand) if x == elsewhere else self.places[x] for hand, x in pairs]


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
    begin = ManipulationState(
        hand, start.held if start.held in kept else None, tuple(places.items()), origin=start.origin
    )
    small = replace(view.model, locations=locations, objects=objects, begin=begin)
    marks = frozenset((obj, mark) for obj, mark in start.marks if obj in kept and mark in small.marks)
    return replace(small, begin=replace(begin, marks=marks))


class ProjectionArrays(NamedTuple):
    """M projections of a model of S slots, H poses of the hand, O objects and D digits, for P tables.

    Attributes:
        number: (P,) int64, the projection that each table is over.
        weights: (M, D) int64, weight of each digit in a projection's states, 0 if it is left out, negative for marks.
        slots: (M, S + 1) int64, each slot's location in the projection, -1 for merged ones.
        hands: (M, H) int64, each pose's number in the projection, -1 over merged locations.
        places: (M, n) int64, the locations of the projection that stand for merged ones.
        origins: (M, D, V) int64, what a value of the last digit adds to a projection's state while an object is held.
        above: (S + 1,) int64, pose of the hand over each slot.
        radices: (D,) int64, number of values of each digit.
        digits: (D,) int64, scratch: digits of the observed state.
        first: (M,) int64, where each projection begins in `numbers`.
        numbers: (X,) int32, numbers[first[m] + state] is the node of a state of projection m.
    """

    number: np.ndarray
    weights: np.ndarray
    slots: np.ndarray
    hands: np.ndarray
    places: np.ndarray
    origins: np.ndarray
    above: np.ndarray
    radices: np.ndarray
    digits: np.ndarray
    first: np.ndarray
    numbers: np.ndarray


def arrays_of(each: Sequence[Projection], whole: StateCodes) -> ProjectionArrays:
    """Return the projection of each table as arrays, given how the model's states are encoded."""
    projections = list(dict.fromkeys(each))
    weights = np.zeros((len(projections), len(whole.radices)), dtype=np.int64)
    places = np.zeros((len(projections), max(len(one.merged) for one in projections) + 1), dtype=np.int64)
    origins = np.zeros((*weights.shape, whole.radices[-1]), dtype=np.int64)
    numbers = []
    for m, one in enumerate(projections):
        space = one.space
        for o, obj in enumerate(space.objects):
            weights[m, 1 + whole.objects.index(obj)] = space.weights[1 + o]
        for pair, d in space.mark_digits.items():
            weights[m, whole.mark_digits[pair]] = -space.weights[d]
        for (obj, place), value in space.origins.items():
            origins[m, 1 + whole.objects.index(obj), whole.origins[obj, place]] = value * space.weights[-1]
        places[m, : len(one.merged)] = one.merged
        numbers.append(np.zeros(space.bound, dtype=np.int32))
        numbers[m][one.codes] = np.arange(len(one.codes))
    slots = np.array([[*one.places, one.space.held] for one in projections])
    first = np.cumsum([0, *map(len, numbers)])[:-1].astype(np.int64)
    radices = np.array(whole.radices, dtype=np.int64)
    return ProjectionArrays(
        number=np.array([projections.index(one) for one in each]),
        weights=weights,
        slots=np.ascontiguousarray(slots[:, whole.location]),  # kernels are compiled for each order in memory
        hands=np.array([one.hands for one in projections]),
        places=places,
        origins=origins,
        above=whole.above.astype(np.int64),
        radices=radices,
        digits=np.zeros_like(radices),
        first=first,
        numbers=np.concatenate(numbers),
    )


@inner_kernel
def observe(projections: ProjectionArrays | None, node: Integer) -> None:
    """Write the digits of a state before its bounds are looked up; do nothing where states are listed."""
    if projections is not None:
        unpack(projections.radices, node, projections.digits)


@inner_kernel
def place_of(projections: ProjectionArrays | None, p: Integer, node: Integer) -> Integer:
    """Return the node of the observed state `node` in table p's projection; `node` itself where states are listed."""
    if projections is None:
        return node
    m, digits = projections.number[p], projections.digits
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
        if value == held:
            state += projections.origins[m, d, digits[-1]]
        if slot < 0:
            slot = projections.places[m, rank]
            rank += 1
            if value < held and projections.above[value] == hand:
                moved = slot
        state += weight * slot
    if moved < 0:
        moved = projections.places[m, rank]
    return np.int64(projections.numbers[projections.first[m] + state + moved])
