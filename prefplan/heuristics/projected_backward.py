"""Cost-to-go tables of a manipulation model too large to list, on projections that omit what some tasks do not see.

A step of a projection costs as much as the cheapest step that maps to it; with measured costs, the cheapest over all
poses of the hand that are merged. So a projection's cost-to-go is a lower bound, and consistent: it falls along a step
by at most the step's cost (B. Yang et al., "A General Theory of Additive State Space Abstractions", JAIR 2008).

The bounds of several projections can be added if every action's cost is counted in at most one of them. An action on an
object is counted in the first projection that keeps the object, and so is a transit to a location of capacity one that
holds the object; other transits are not counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import cache, cached_property, partial

import numpy as np

from prefplan.heuristics.backward import Backward
from prefplan.heuristics.projection import Projection
from prefplan.models.kernels import UNBOUNDED
from prefplan.models.manipulation.operators import read_action
from prefplan.models.manipulation.successors import TRANSIT, TRANSPORT
from prefplan.product.reduction import GeneratedProduct
from prefplan.product.space import Graph

GROUP_ENTRIES = 200_000
"""Most entries, by an upper bound, of a table that tasks with an object in common share."""


class ProjectedBackward:
    """Cost-to-go tables of a product whose states are generated, filled by backward searches on projections.

    Attributes:
        costs: (4 H H,) int64, one of the costs of actions, by price as in `Steps`.
        sizes: (N,) int64, number of states of each automaton.
        space: how the model's states are encoded.
        projection: (tasks) -> the projection for some tasks.
    """

    def __init__(self, product: GeneratedProduct) -> None:
        """Take the product."""
        self.costs, self.sizes, self.space = product.graph.costs, product.sizes, product.model.space
        self.projection = cache(partial(Projection, product))

    def with_costs(self, costs: np.ndarray) -> ProjectedBackward:
        """Return a copy for another of the costs, with the same projections."""
        other = copy(self)
        other.costs = costs
        return other

    def entries_of(self, tasks: tuple[int, ...]) -> int:
        """Return an upper bound of the number of entries of a table of some tasks, not counting marks."""
        return self.projection(tasks).entries

    def cost_to_go(self, tasks: tuple[int, ...], factors: np.ndarray | None = None) -> np.ndarray:
        """Return a table as `Backward.cost_to_go`; without `factors`, the tasks must be one of the `groups`.

        In a table of costs, only actions counted for its group have costs: the tables of all groups can be added.
        """
        projection = self.projection(tasks)
        costs = self._least_costs(projection)
        if factors is None:
            before = self.groups[: self.groups.index(tasks)]
            claimed = {obj for group in before for obj in self.projection(group).kept}
            costs = np.where(_concern(projection, [obj for obj in projection.kept if obj not in claimed]), costs, 0)
        return _backward(projection, costs).cost_to_go(range(len(tasks)), factors)

    @cached_property
    def groups(self) -> list[tuple[int, ...]]:
        """A partition of the tasks: tasks with an object in common are together, where tables stay small."""
        groups: list[tuple[int, ...]] = []
        for i in range(len(self.sizes)):
            joined: tuple[int, ...] = (i,)
            for group in list(groups):
                shared = set(self.projection(group).kept) & set(self.projection(joined).kept)
                both = tuple(sorted((*group, *joined)))
                if shared and self.entries_of(both) <= GROUP_ENTRIES:
                    groups.remove(group)
                    joined = both
            groups.append(joined)
        return sorted(groups)

    def _least_costs(self, projection: Projection) -> np.ndarray:
        """Return the costs of a projection's edges: the least of all actions that map to them.

        A transit also stands for transports of objects left out.
        """
        over, number, poses = self.space.over, len(self.space.hands), len(projection.space.hands)
        # Number all poses over merged locations alike.
        hands = np.array(projection.hands)
        whole, small = np.where(hands < 0, poses, hands), np.arange(poses)
        small[projection.merged] = poses
        stays = over[:, None] == over[None, :]
        by_kind = self.costs.reshape(-1, number, number)
        least = np.full((len(by_kind), poses + 1, poses + 1), UNBOUNDED)
        for kind, costs in enumerate(by_kind):
            exists = (stays != (kind in (TRANSIT, TRANSPORT))) & (costs >= 0)
            np.minimum.at(least[kind], (whole[:, None], whole[None, :]), np.where(exists, costs, UNBOUNDED))
        least[TRANSIT] = np.minimum(least[TRANSIT], least[TRANSPORT])
        # Where no action exists, any cost will do.
        least[least == UNBOUNDED] = 0
        graph = projection.product.graph
        return least[:, small[:, None], small[None, :]].ravel()[graph.costs >> graph.shift]


def _concern(projection: Projection, own: Sequence[str]) -> np.ndarray:
    """Return which edges are actions on `own` objects, or transits to a location of capacity one that holds one."""
    system, space = projection.product.listed, projection.space
    objects = [read_action(text).obj for text in system.action_names]
    after = projection.codes[system.targets]
    hand = space.digit(after, 0)
    single = np.array([place.capacity == 1 for place in space.model.locations] + [False])
    alone = single[np.minimum(hand, len(single) - 1)] & np.array([not obj for obj in objects])[system.actions]
    concern: np.ndarray = np.array([obj in own for obj in objects])[system.actions]
    for o, obj in enumerate(space.objects):
        if obj in own:
            concern |= alone & (space.digit(after, 1 + o) == hand)
    return concern


def _backward(projection: Projection, costs: np.ndarray) -> Backward:
    """Return the backward search on a projection, with some costs of its edges."""
    product = projection.product
    graph = replace(product.graph, costs=costs, shift=0)
    invariant = all(dfa.automaton.stutter_invariant for dfa in product.automata)
    return Backward(product, graph if invariant else _with_idling(graph))


def _with_idling(graph: Graph) -> Graph:
    """Return a graph with a self-loop of cost 0 at every node, for actions on objects that are left out."""
    nodes = np.arange(graph.size, dtype=np.int32)
    order = np.argsort(np.concatenate([np.repeat(nodes, np.diff(graph.offsets)), nodes]), kind="stable")
    return replace(
        graph,
        offsets=graph.offsets + np.arange(graph.size + 1),
        targets=np.concatenate([graph.targets, nodes])[order],
        costs=np.concatenate([graph.costs, np.zeros_like(graph.costs, shape=graph.size)])[order],
    )
