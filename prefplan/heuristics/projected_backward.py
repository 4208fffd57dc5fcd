"""Cost-to-go tables of a manipulation model too large to list, on projections that omit what some tasks do not see.

A step of a projection costs the least of all steps that map to it; with measured costs, the least over all poses of the
hand that are merged. So costs-to-go there are lower bounds, and consistent: a bound falls along a step by no more than
the step's cost (B. Yang et al., "A General Theory of Additive State Space Abstractions", JAIR 2008).

The bounds of several projections can be added if every action's cost is counted in at most one of them. An action on an
object, and a transit to a location of capacity one that holds it, counts in the first projection that keeps the object;
other transits count nowhere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import replace

import numpy as np

from prefplan.heuristics.backward import Backward
from prefplan.heuristics.projection import KINDS, Projection, ProjectionArrays, arrays_of
from prefplan.models.costs import DEFAULT_COST, CostTable
from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.models.manipulation.operators import read_action
from prefplan.models.manipulation.successors import TRANSIT, TRANSPORT
from prefplan.models.manipulation.symmetry import Symmetry
from prefplan.models.transition_system import TransitionSystem
from prefplan.product.contraction import whole_graph
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.product_automaton import Product

GROUP_ENTRIES = 200_000
"""Tasks that see the same objects share a table of at most this many entries, by an upper bound."""

APART_ENTRIES = 400_000
"""Where costs are measured, locations are merged only in tables of more entries than this, by an upper bound: merging
them always, fronts of three and four objects take 1.1 and 2.2 times as long."""

NOWHERE = 2**62
"""Stands for the cost of an action that does not exist; larger than any cost."""


class ProjectedBackward:
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
        self._made: dict[tuple[int, ...], Projection] = {}

    def with_costs(self, costs: np.ndarray) -> ProjectedBackward:
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
        locations = len(self._model.locations) - len(relaxed.neutral_locations)
        objects = len(self.objects_of(tasks))
        states = (locations + 2) ** objects * (locations + objects + 2)
        return states * math.prod(int(self.sizes[i]) for i in tasks)

    def _view(self, tasks: Sequence[int]) -> Symmetry:
        """Return the model without supports, slots and costs, and which of its locations are merged for some tasks."""
        places = tuple(replace(place, at=place.at or (0.0, 0.0), on=(), clear_of=()) for place in self._model.locations)
        relaxed = replace(self._model, locations=places, costs=dict.fromkeys(KINDS, 0))
        if isinstance(self._model.costs, MeasuredCosts):
            apart = Symmetry(relaxed, self._names(tasks), places_alike=False)
            if self._entries(tasks, apart) <= APART_ENTRIES:
                return apart
        return Symmetry(relaxed, self._names(tasks))

    def nodes_of(self, tasks: Sequence[int]) -> int:
        """Return the number of nodes in the tables of some tasks."""
        return self._projection(tasks).system.size

    def projection_of(self, tasks: Sequence[int]) -> int:
        """Return the number of the projection that the tables of some tasks are over."""
        return self._projection(tasks).number

    def growth(self, tasks: Sequence[int], factors: np.ndarray) -> np.ndarray:
        """Return least weighted costs until some tasks are satisfied or dropped, as `Backward.growth`."""
        projection = self._projection(tasks)
        costs = self._edge_costs(projection, self._least_costs(projection, loads_seen=False))
        return self._backward(projection, costs).growth(range(len(tasks)), factors)

    def shared(self, tasks: Sequence[int], groups: Sequence[tuple[int, ...]]) -> np.ndarray:
        """Return least costs until some tasks are satisfied or dropped, of actions that count in this table, as int32.

        The tasks are one of the `groups` whose bounds are added.
        """
        projection, before = self._projection(tasks), groups[: groups.index(tuple(tasks))]
        claimed = {obj for group in before for obj in self.objects_of(group)}
        own = [obj for obj in self.objects_of(tasks) if obj not in claimed]
        costs = self._edge_costs(projection, self._least_costs(projection, loads_seen=True), own)
        return self._backward(projection, costs).cost_to_go(range(len(tasks)), dtype=np.int32)

    def groups(self) -> list[tuple[int, ...]]:
        """Return a partition of the tasks: those that see the same objects are together, where tables stay small."""
        groups: list[tuple[int, ...]] = []
        for i in range(len(self.sizes)):
            joined: tuple[int, ...] = (i,)
            for group in list(groups):
                shared = set(self.objects_of(group)) & set(self.objects_of(joined))
                if shared and self.entries_of((*group, *joined)) <= GROUP_ENTRIES:
                    groups.remove(group)
                    joined = tuple(sorted((*group, *joined)))
            groups.append(joined)
        return sorted(groups)

    def arrays(self) -> ProjectionArrays | None:
        """Return the projections that tables were made of, if any."""
        return arrays_of([*self._made.values()], self._space) if self._made else None

    def _projection(self, tasks: Sequence[int]) -> Projection:
        tasks = tuple(tasks)
        if tasks not in self._made:
            view, kept, names = self._view(tasks), self.objects_of(tasks), self._names(tasks)
            start = self.product.model.start
            self._made[tasks] = Projection.of(len(self._made), tasks, self._space, view, kept, start, names)
        return self._made[tasks]

    def _least_costs(self, projection: Projection, *, loads_seen: bool) -> np.ndarray:
        """Return (4, P, P) the least costs of each kind of action between any two of a projection's P poses.

        Without `loads_seen`, a transit also stands for transports of objects left out.
        """
        over, number, poses = self._space.over, len(self._space.hands), len(projection.space.hands)
        # All poses over merged locations are one.
        hands = np.array(projection.hands)
        whole, small = np.where(hands < 0, poses, hands), np.arange(poses)
        small[[projection.space.locations.index(name) for name in projection.merged]] = poses
        stays = over[:, None] == over[None, :]
        least = np.full((len(KINDS), poses + 1, poses + 1), NOWHERE)
        for kind, costs in enumerate(self.costs.reshape(len(KINDS), number, number)):
            exists = (stays != (kind in (TRANSIT, TRANSPORT))) & (costs >= 0)
            np.minimum.at(least[kind], (whole[:, None], whole[None, :]), np.where(exists, costs, NOWHERE))
        if not loads_seen:
            least[TRANSIT] = np.minimum(least[TRANSIT], least[TRANSPORT])
        # Where no action exists, any cost will do.
        least[least == NOWHERE] = 0
        return least[:, small[:, None], small[None, :]]

    def _edge_costs(self, projection: Projection, least: np.ndarray, own: Sequence[str] | None = None) -> np.ndarray:
        """Return the costs of a projection's edges; if `own` is given, 0 for actions that concern no object of it."""
        system, space = projection.system, projection.space
        costs: np.ndarray = least.ravel()[system.costs[0].entries]
        if own is None:
            return costs
        actions = [read_action(text) for text in system.action_names]
        concerns = np.array([action.obj in own for action in actions])[system.actions]
        after = projection.codes[system.targets]
        hand = space.digit(after, 0)
        single = np.array([place.capacity == 1 for place in space.model.locations] + [False])
        alone = (
            single[np.minimum(hand, len(single) - 1)] & np.array([not action.obj for action in actions])[system.actions]
        )
        for o, obj in enumerate(space.objects):
            if obj in own:
                concerns |= alone & (space.digit(after, 1 + o) == hand)
        return np.where(concerns, costs, 0)

    def _backward(self, projection: Projection, costs: np.ndarray) -> Backward:
        """Return what fills tables of a projection with some costs."""
        problem = self.product.problem
        only = CostTable(DEFAULT_COST, costs, problem.units.cost)
        system = replace(projection.system, costs=(only,), propositions=problem.system.propositions)
        if not all(problem.automata[i].stutter_invariant for i in projection.tasks):
            system = _with_idling(system)
        product = Product(problem.over(system, projection.tasks), counts_actions=False)
        return Backward(product, whole_graph(product))


def _with_idling(system: TransitionSystem) -> TransitionSystem:
    """Return a system in which every state has one more action, a self-loop of cost 0: one on an object left out."""
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
            replace(each, entries=np.concatenate([each.entries, np.zeros(system.size, dtype=np.int64)])[order])
            for each in system.costs
        ),
        action_names=(*system.action_names, "wait"),
    )
