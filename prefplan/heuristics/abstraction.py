"""Cost-to-go tables of a manipulation model too large to list, on projections that omit what some tasks do not see.

For a set K of tasks, the projection keeps the objects that occur in K's propositions. Objects left out never block an
action: preconditions on them, and supports, are dropped, and slots are not told apart. All locations of capacity one
that K does not mention are merged, unless costs are measured and the table is small without that. Every step of the
model maps to a step of the projection or to none: an action on an object left out moves at most the hand. A step of the
projection costs the least of all steps that map to it; with measured costs, the least over all poses of the hand that
are merged. So costs-to-go there are lower bounds, and consistent: a bound falls along a step by no more than the step's
cost (B. Yang et al., "A General Theory of Additive State Space Abstractions", JAIR 2008).

The bounds of several projections can be added if every action's cost is counted in at most one of them. An action on an
object, and a transit to a location of capacity one that holds it, counts in the first projection that keeps the object;
other transits count nowhere.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from prefplan.heuristics.cost_to_go import Backward
from prefplan.heuristics.projections import Projections
from prefplan.models.costs import DEFAULT_COST, CostTable
from prefplan.models.manipulation.action_costs import MeasuredCosts, cost_tables
from prefplan.models.manipulation.codes import StateCodes
from prefplan.models.manipulation.listing import StateTable, listed, moves_of, table
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.operators import read_action
from prefplan.models.manipulation.state import ManipulationState
from prefplan.models.manipulation.successors import TRANSIT, TRANSPORT, canonical
from prefplan.models.manipulation.symmetry import Symmetry
from prefplan.models.transition_system import TransitionSystem
from prefplan.product.contraction import whole_graph
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.product_automaton import Product

GROUP_ENTRIES = 200_000
"""Tasks that see the same objects share a table of at most this many entries, by an upper bound."""

APART_ENTRIES = 400_000
"""Where costs are measured, locations are merged only in tables of more entries than this, by an upper bound."""

KINDS = ("transit", "grasp", "transport", "release")
"""The kinds of actions, by number."""

NOWHERE = 2**62
"""Stands for the cost of an action that does not exist; larger than any cost."""


@dataclass(frozen=True)
class _Projection:
    """The projection for a set of tasks.

    Attributes:
        number: of the projection.
        tasks: the set.
        space: how its states are encoded.
        symmetry: its model, and which of its locations are merged.
        listing: its states.
        system: its transition system, without costs.
        places: by location of the model, the number here; -1 for merged ones.
        hands: (H,) by pose of the hand in the model, the number here; -1 over merged locations.
    """

    number: int
    tasks: tuple[int, ...]
    space: StateCodes
    symmetry: Symmetry
    listing: StateTable
    system: TransitionSystem
    places: list[int]
    hands: np.ndarray


class Projected:
    """Cost-to-go tables of a product whose states are generated, filled by backward searches on projections.

    Attributes:
        costs: (4 H H,) int64, one of the costs of actions, as in `Moves`.
        sizes: (N,) int64, states of each automaton.
        shift: 0: costs do not count actions.
    """

    def __init__(self, product: GeneratedProduct) -> None:
        """Take the product."""
        self.product, self.costs, self.sizes, self.shift = product, product.costs, product.sizes, 0
        self._model, self._space = product.model.space.model, product.model.space
        self._known: dict[tuple[int, ...], _Projection] = {}

    def with_costs(self, costs: np.ndarray) -> Projected:
        """Return the same for another of the costs; projections made for either serve both."""
        other = copy(self)
        other.costs = costs
        return other

    def objects_of(self, tasks: Sequence[int]) -> list[str]:
        """Return the objects that occur in the propositions of some tasks."""
        names = self._names(tasks)
        return [
            obj.name
            for obj in self._model.objects
            if any(name in names for name, _ in self._model.propositions_of(obj.name))
        ]

    def _names(self, tasks: Sequence[int]) -> frozenset[str]:
        return frozenset().union(*(self.product.automata[i].propositions for i in tasks))

    def entries_of(self, tasks: Sequence[int]) -> int:
        """Return an upper bound of the number of entries of a table of some tasks, not counting marks."""
        return self._entries(tasks, self._view(tasks))

    def _entries(self, tasks: Sequence[int], relaxed: Symmetry) -> int:
        locations = len(self._model.locations) - len(relaxed.neutral)
        objects = len(self.objects_of(tasks))
        states = (locations + 2) ** objects * (locations + objects + 2)
        return states * math.prod(int(self.sizes[i]) for i in tasks)

    def _view(self, tasks: Sequence[int]) -> Symmetry:
        """Return the model without supports, slots and costs, and which of its locations are merged for some tasks."""
        places = tuple(replace(place, at=place.at or (0.0, 0.0), on=(), clear_of=()) for place in self._model.locations)
        relaxed = replace(self._model, locations=places, costs=dict.fromkeys(KINDS, 0))
        if isinstance(self._model.costs, MeasuredCosts):
            apart = Symmetry(relaxed, self._names(tasks), frozenset(), places_alike=False)
            if self._entries(tasks, apart) <= APART_ENTRIES:
                return apart
        return Symmetry(relaxed, self._names(tasks), frozenset())

    def nodes_of(self, tasks: Sequence[int]) -> int:
        """Return the number of nodes in the tables of some tasks."""
        return self._projection(tasks).system.size

    def projection_of(self, tasks: Sequence[int]) -> int:
        """Return the number of the projection that the tables of some tasks are over."""
        return self._projection(tasks).number

    def cost_to_go(self, tasks: Sequence[int], factors: np.ndarray, *, shift: int = 0) -> np.ndarray:
        """Return least weighted costs until some tasks are satisfied or dropped, as `Backward.cost_to_go`."""
        found = self._projection(tasks)
        costs = self._edge_costs(found, self._least_costs(found, loads_seen=False))
        backward = self._backward(found, costs, idle=self._cheapest)
        return backward.cost_to_go(range(len(tasks)), factors, shift=shift)

    def fill_shared(self, table: np.ndarray, tasks: Sequence[int], groups: Sequence[tuple[int, ...]]) -> None:
        """Fill a table with least costs until some tasks are satisfied or dropped, of actions that count in it.

        Args:
            table: as for `Backward.fill`.
            tasks: one of the groups.
            groups: all sets of tasks whose bounds are added.
        """
        found, before = self._projection(tasks), groups[: groups.index(tuple(tasks))]
        claimed = {obj for group in before for obj in self.objects_of(group)}
        own = [obj for obj in self.objects_of(tasks) if obj not in claimed]
        costs = self._edge_costs(found, self._least_costs(found, loads_seen=True), own)
        self._backward(found, costs, idle=0).fill(table, range(len(tasks)))

    def groups(self) -> list[tuple[int, ...]]:
        """Return a partition of the tasks: those that see the same objects are together, where tables stay small."""
        found: list[tuple[int, ...]] = []
        for i in range(len(self.sizes)):
            joined: tuple[int, ...] = (i,)
            for group in list(found):
                shared = set(self.objects_of(group)) & set(self.objects_of(joined))
                if shared and self.entries_of((*group, *joined)) <= GROUP_ENTRIES:
                    found.remove(group)
                    joined = tuple(sorted((*group, *joined)))
            found.append(joined)
        return sorted(found)

    def projections(self) -> Projections | None:
        """Return the projections that tables were made of, if any."""
        found = sorted(self._known.values(), key=lambda projection: projection.number)
        if not found:
            return None
        rows = [self._rows(projection) for projection in found]
        places = np.zeros((len(found), max(len(row[3]) for row in rows) + 1), dtype=np.int64)
        for m, row in enumerate(rows):
            places[m, : len(row[3])] = row[3]
        tables = [self._numbers(projection) for projection in found]
        first = np.cumsum([0, *map(len, tables)])[:-1]
        weights, slots, hands = (np.array([row[k] for row in rows], dtype=np.int64) for k in range(3))
        above = self._space.above.astype(np.int64)
        radices = np.array(self._space.radices, dtype=np.int64)
        digits = radices, np.zeros_like(radices)
        return Projections(
            weights, slots, hands, places, above, *digits, first.astype(np.int64), np.concatenate(tables)
        )

    def _projection(self, tasks: Sequence[int] | np.ndarray) -> _Projection:
        tasks = tuple(int(i) for i in tasks)
        if tasks not in self._known:
            relaxed = self._view(tasks)
            kept = self.objects_of(tasks)
            small, start = _without(relaxed, kept, self.product.model.start)
            names = self._names(tasks)
            seen = Symmetry(small, names, frozenset(), places_alike=bool(relaxed.neutral))
            space = StateCodes(small, start, seen.sees_mark)
            moves = moves_of(space, seen.neutral, seen.unseen)
            states = listed(space, moves, int(canonical(moves, space.encode(start, where="start"))))
            system = table(space, states, cost_tables(small, KINDS, space.hands), names)
            places, hands = self._numbers_in(space, relaxed.neutral)
            self._known[tasks] = _Projection(len(self._known), tasks, space, seen, states, system, places, hands)
        return self._known[tasks]

    def _least_costs(self, found: _Projection, *, loads_seen: bool) -> np.ndarray:
        """Return (4, P, P) the least costs of each kind of action between any two of a projection's P poses.

        Args:
            found: the projection.
            loads_seen: whether a transit stands for transits only; else also for transports of objects left out.
        """
        over, number, poses = self._space.over, len(self._space.hands), len(found.space.hands)
        # All poses over merged locations are one.
        whole, small = np.where(found.hands < 0, poses, found.hands), np.arange(poses)
        small[[found.space.locations.index(name) for name in found.symmetry.neutral]] = poses
        stays = over[:, None] == over[None, :]
        least = np.full((len(KINDS), poses + 1, poses + 1), NOWHERE)
        for kind, costs in enumerate(self.costs.reshape(len(KINDS), number, number)):
            exists = (stays != (kind in (TRANSIT, TRANSPORT))) & (costs >= 0)
            np.minimum.at(least[kind], (whole[:, None], whole[None, :]), np.where(exists, costs, NOWHERE))
        if not loads_seen:
            least[TRANSIT] = np.minimum(least[TRANSIT], least[TRANSPORT])
        # Where no action exists, any cost will do.
        least[least == NOWHERE] = self._cheapest
        return least[:, small[:, None], small[None, :]]

    @property
    def _cheapest(self) -> int:
        """The cost of the cheapest action."""
        known = self.costs[self.costs >= 0]
        return int(known.min()) if len(known) else 0

    def _edge_costs(self, found: _Projection, least: np.ndarray, own: Sequence[str] | None = None) -> np.ndarray:
        """Return the costs of a projection's edges; if `own` is given, 0 for actions that concern no object of it."""
        states, space = found.listing, found.space
        costs: np.ndarray = least.ravel()[states.prices]
        if own is None:
            return costs
        actions = [read_action(text) for text in states.action_names]
        concerns = np.array([action.obj in own for action in actions])[states.actions]
        after = found.listing.codes[states.targets]
        hand = space.digit(after, 0)
        single = np.array([place.capacity == 1 for place in space.model.locations] + [False])
        alone = (
            single[np.minimum(hand, len(single) - 1)] & np.array([not action.obj for action in actions])[states.actions]
        )
        for o, obj in enumerate(space.objects):
            if obj in own:
                concerns |= alone & (space.digit(after, 1 + o) == hand)
        return np.where(concerns, costs, 0)

    def _backward(self, found: _Projection, costs: np.ndarray, *, idle: int) -> Backward:
        """Return what fills tables of a projection with some costs; `idle` is that of an action in no task's sight."""
        problem = self.product.problem
        system = replace(found.system, costs=(CostTable(DEFAULT_COST, costs, problem.units.cost),))
        if not all(problem.automata[i].stutter_invariant for i in found.tasks):
            system = _with_idling(system, idle)
        product = Product(problem.over(system.knowing(problem.system.propositions), found.tasks), counts_actions=False)
        return Backward(product, whole_graph(product))

    def _rows(self, found: _Projection) -> tuple[list[int], list[int], list[int], list[int]]:
        """Return the rows `weights`, `slots`, `hands` and `places` of `Projections` for one projection."""
        whole, space = self._space, found.space
        weights = [0] * len(whole.radices)
        for o, obj in enumerate(space.objects):
            weights[1 + whole.objects.index(obj)] = space.weights[1 + o]
        for pair, d in space.mark_digits.items():
            weights[whole.mark_digits[pair]] = -space.weights[d]
        places = [*found.places, space.held]
        slots = [places[x] for x in whole.location]
        return weights, slots, found.hands.tolist(), [space.locations.index(name) for name in found.symmetry.neutral]

    def _numbers_in(self, space: StateCodes, alike: Collection[str]) -> tuple[list[int], np.ndarray]:
        """Return `places` and `hands` of a projection, given the names of merged locations."""
        whole = self._space
        places = [-1 if name in alike else space.locations.index(name) for name in whole.locations]
        elsewhere = len(places)
        hands = [
            space.hands.index(hand) if x == elsewhere else places[x]
            for hand, x in zip(whole.hands, whole.over, strict=True)
        ]
        return places, np.array(hands)

    def _numbers(self, found: _Projection) -> np.ndarray:
        numbers = np.zeros(found.space.bound, dtype=np.int32)
        numbers[found.listing.codes] = np.arange(found.system.size)
        return numbers


def _without(
    view: Symmetry, kept: Sequence[str], start: ManipulationState
) -> tuple[ManipulationModel, ManipulationState]:
    """Return a model with only some objects, and only as many merged locations as these need."""
    needed = view.neutral[: len(kept) + 1]
    locations = tuple(p for p in view.model.locations if p.name not in view.neutral or p.name in needed)
    free: Iterator[str] = iter(needed)
    places, hand = {}, start.hand
    for obj in kept:
        place = start.place.get(obj)
        if place is not None:
            places[obj] = next(free) if place in view.neutral else place
            hand = places[obj] if place == start.hand and place in view.neutral else hand
    if hand in view.neutral and hand not in places.values():
        hand = next(free)
    objects = tuple(
        replace(obj, start=places.get(obj.name, locations[0].name)) for obj in view.model.objects if obj.name in kept
    )
    begin = ManipulationState(hand, start.held if start.held in kept else None, tuple(places.items()))
    small = replace(view.model, locations=locations, objects=objects, begin=begin)
    marks = frozenset((obj, mark) for obj, mark in start.marks if obj in kept and mark in small.marks)
    begin = replace(begin, marks=marks)
    return replace(small, begin=begin), begin


def _with_idling(system: TransitionSystem, cost: int) -> TransitionSystem:
    """Return a system in which every state has one more action, a self-loop."""
    states = np.arange(system.size)
    source = np.concatenate([np.repeat(states, np.diff(system.offsets)), states])
    order = np.argsort(source, kind="stable")
    added = np.full(system.size, len(system.action_names), dtype=np.int32)
    return replace(
        system,
        offsets=system.offsets + np.arange(system.size + 1),
        targets=np.concatenate([system.targets, states.astype(np.int32)])[order],
        actions=np.concatenate([system.actions, added])[order],
        costs=tuple(
            replace(each, entries=np.concatenate([each.entries, np.full(system.size, cost)])[order])
            for each in system.costs
        ),
        action_names=(*system.action_names, "wait"),
    )
