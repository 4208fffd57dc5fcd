"""The graph that a product is searched over: the transition system, or what static contraction leaves of it.

A label class is *inert* if no automaton ever changes its state on it: delta_i(q, l) = q for every task or rule i and q
(idempotence is not enough: the empty label makes `a U b` unsatisfiable). States of inert classes are only passed
through. Contraction keeps the other states and the start, at most 64 in all, with the cost of the cheapest path through
inert states between each two; so costs are kept, and sequences of labels that are not inert.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from prefplan.exact_costs import INT64_LIMIT
from prefplan.models.kernels import INFINITE, NO_EDGE, Integer, kernel
from prefplan.product.heap import heap_pop, heap_push
from prefplan.product.product_automaton import Product

NODE_LIMIT = 64
"""Most nodes of a contracted graph: sets of them fit one machine word; on larger graphs contraction does not pay."""


@dataclass(frozen=True)
class Graph:
    """The nodes and edges that are searched, and the states that they stand for.

    Attributes:
        offsets: (S + 1,) int64, targets: (E,) int32, costs: (E,) int64 internal units.
        classes: (S,) int32, label class of each node.
        states: (S,) state of the transition system that each node stands for.
        start: node of s0.
        contracted: whether edges stand for paths through inert states.
        shift: number of low bits of costs, which count actions.
    """

    offsets: np.ndarray
    targets: np.ndarray
    costs: np.ndarray
    classes: np.ndarray
    states: np.ndarray
    start: int
    contracted: bool
    shift: int

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.classes)

    @cached_property
    def near(self) -> np.ndarray:
        """(S, S) int64, the costs of edges as a matrix, NO_EDGE for none."""
        near = np.full((self.size, self.size), NO_EDGE, dtype=np.int64)
        near[np.repeat(np.arange(self.size), np.diff(self.offsets)), self.targets] = self.costs
        return near

    @cached_property
    def least(self) -> np.ndarray:
        """(S, S) int64, least costs from node to node, through any others, NO_EDGE for none."""
        least: np.ndarray = all_pairs_costs(self.near)
        return least


def bits_of(sets: np.ndarray) -> np.ndarray:
    """Return sets of at most NODE_LIMIT nodes, given as (..., S) bool, as (...,) uint64."""
    bits = np.uint64(1) << np.arange(sets.shape[-1], dtype=np.uint64)
    return np.where(sets, bits, np.uint64(0)).sum(axis=-1, dtype=np.uint64)


def whole_graph(product: Product) -> Graph:
    """Return the transition system itself; without nodes and edges where states are generated."""
    states = np.arange(len(product.classes))
    start, shift = product.start_node, product.shift
    return Graph(product.offsets, product.targets, product.costs, product.classes, states, start, False, shift)


def changes(product: Product) -> np.ndarray:
    """Return (N + R, Q, C) whether reading a label class can change an automaton's state."""
    states = np.arange(product.delta.shape[1])[:, None]
    is_state = states < np.concatenate([product.sizes, product.rule_sizes])[:, None, None]
    moves: np.ndarray = is_state & ((product.delta != states) | (np.diff(product.extra_first, axis=2) > 0))
    return moves


def active_nodes(product: Product, graph: Graph) -> np.ndarray:
    """Return (N + R, S) whether reading a node's label can change an automaton in some state."""
    return np.logical_or.reduce(changes(product), axis=1)[:, graph.classes]


def contract(product: Product) -> Graph | None:
    """Return the contracted graph, or None if it had more than NODE_LIMIT nodes or costs might not fit 64 bits."""
    system = product.problem.system.listed
    if system.size * int(product.costs.max(initial=0)) >= INT64_LIMIT:
        return None
    matters = np.logical_or.reduce(changes(product), axis=(0, 1))[product.classes]
    keep = matters.copy()
    keep[system.start] = True
    states = np.flatnonzero(keep)
    if len(states) > NODE_LIMIT:
        return None
    near = np.empty((len(states), len(states)), dtype=np.int64)
    least, last = np.empty((2, len(keep)), dtype=np.int64)
    for k, state in enumerate(states.tolist()):
        cheapest_paths(product.offsets, product.targets, product.costs, ~matters, state, -1, NO_EDGE, least, last)
        near[k] = least[states]
    source, target = np.nonzero((near < NO_EDGE) & matters[states])
    costs = near[source, target]
    if len(states) * int(costs.max(initial=0)) >= INFINITE:
        return None
    return Graph(
        np.searchsorted(source, np.arange(len(states) + 1)).astype(np.int64),
        target.astype(np.int32),
        costs,
        product.classes[states],
        states,
        int(np.searchsorted(states, system.start)),
        True,
        product.shift,
    )


@kernel
def cheapest_paths(
    offsets: np.ndarray,
    targets: np.ndarray,
    costs: np.ndarray,
    passable: np.ndarray,
    source: Integer,
    target: Integer,
    most: Integer,
    least: np.ndarray,
    last: np.ndarray,
) -> None:
    """Write the cost and the last edge of a cheapest path from one node to each, of at least one edge (Dijkstra).

    Ties go to the edge that is met first. Once all impassable nodes are reached, others are left out.

    Args:
        offsets: (S + 1,) int64, where the edges of each node begin.
        targets: (E,) int32.
        costs: (E,) int64.
        passable: (S,) bool, nodes that paths may pass.
        source: where they begin.
        target: where one ends that is wanted alone; -1 for all.
        most: greatest cost of interest.
        least: (S,) int64, output, NO_EDGE where no path that is wanted costs at most that.
        last: (S,) int64, output.
    """
    # Edges to be tried are numbered. Of equal costs the heap has the largest item first. The source may be left twice.
    size = 2 * targets.shape[0]
    keys, items, edges = np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size, np.int64)
    least[:] = NO_EDGE
    node, cost, tried, left = np.int64(source), np.int64(0), np.int64(0), np.sum(~passable)
    count: Integer = np.int64(0)
    while True:
        for edge in range(offsets[node], offsets[node + 1]):
            if cost + costs[edge] <= most and least[targets[edge]] == NO_EDGE:
                edges[tried] = edge
                count = heap_push(keys, items, count, cost + costs[edge], -tried, None)
                tried += 1
        is_new = False
        while count > 0 and not is_new:
            cost, edge = keys[0], edges[-items[0]]
            count = heap_pop(keys, items, count, None)
            node = np.int64(targets[edge])
            if least[node] == NO_EDGE:
                least[node], last[node] = cost, edge
                is_new = passable[node]
                left -= not is_new
                if node == target or (left == 0 and not is_new):
                    return
        if not is_new:
            return


@kernel
def all_pairs_costs(near: np.ndarray) -> np.ndarray:
    """Return the (S, S) least costs from node to node, NO_EDGE for none, given those of edges (Floyd-Warshall)."""
    least = near.copy()
    nodes = least.shape[0]
    for via in range(nodes):
        for source in range(nodes):
            first = least[source, via]
            if first < NO_EDGE:
                for target in range(nodes):
                    least[source, target] = min(least[source, target], first + least[via, target])
    return least
