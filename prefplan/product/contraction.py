"""The graph that a product is searched over: the transition system, or what static contraction leaves of it.

A label class is *inert* if no automaton ever changes its state on it: delta_i(q, l) = q for every task or rule i and q
(idempotence is not enough: the empty label makes `a U b` unsatisfiable). States of inert classes are only passed
through. Contraction keeps the other states and the start, at most 64 in all, with the cost of the cheapest path through
inert states between each two; so costs are kept, and sequences of labels that are not inert.
"""

from collections.abc import Sequence
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
        """(S, S) int64, least costs from node to node, through any others, NO_EDGE for none (Floyd-Warshall)."""
        least: np.ndarray = self.near
        for via in range(self.size):
            least = np.minimum(least, least[:, via, None] + least[via])
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
    is_state = states < product.follower_sizes[:, None, None]
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
    node = np.full(len(keep), -1, dtype=np.int64)
    node[states] = np.arange(len(states))
    near = np.empty((len(states), len(states)), dtype=np.int64)
    _cheapest_paths(product.offsets, product.targets, product.costs, matters, states, node, near)
    if len(states) * int(near.max(initial=0)) >= INFINITE:
        return None
    source, target = np.nonzero(near >= 0)
    return Graph(
        np.searchsorted(source, np.arange(len(states) + 1)).astype(np.int64),
        target.astype(np.int32),
        near[source, target],
        product.classes[states],
        states,
        int(node[system.start]),
        True,
        product.shift,
    )


@kernel
def _cheapest_paths(
    offsets: np.ndarray,
    targets: np.ndarray,
    costs: np.ndarray,
    matters: np.ndarray,
    states: np.ndarray,
    node: np.ndarray,
    near: np.ndarray,
) -> None:
    """Write the cost of the cheapest path through inert states from each kept one to each that matters; -1 for none."""
    size = offsets.shape[0] - 1
    distance = np.empty(size, dtype=np.int64)
    keys = np.empty(targets.shape[0] + size + 1, dtype=np.int64)
    items = np.empty(targets.shape[0] + size + 1, dtype=np.int64)
    for k in range(states.shape[0]):
        near[k, :] = -1
        distance[:] = -1
        count: Integer = np.int64(0)
        for edge in range(offsets[states[k]], offsets[states[k] + 1]):
            count = heap_push(keys, items, count, costs[edge], np.int64(targets[edge]), None)
        while count > 0:
            cost, s = keys[0], items[0]
            count = heap_pop(keys, items, count, None)
            if distance[s] >= 0:
                continue
            distance[s] = cost
            if matters[s]:
                near[k, node[s]] = cost
                continue
            for edge in range(offsets[s], offsets[s + 1]):
                if distance[targets[edge]] < 0:
                    count = heap_push(keys, items, count, cost + costs[edge], np.int64(targets[edge]), None)


def edges_between(
    product: Product, graph: Graph, before: int, after: int, automata: Sequence[int], cost: int
) -> list[int]:
    """Return the edges of a path of one cost between two nodes on which no automaton moves before the last edge.

    There are none if there is no such path. Ties go to fewer actions, then to the model's order of actions. The
    `automata` are the states before, and the cost is as in `Product.costs`.
    """
    rests = (product.delta[np.arange(len(automata)), automata] == np.array(automata)[:, None]).all(axis=0)
    arrays = product.offsets, product.targets, product.costs, product.classes
    ends = int(graph.states[before]), int(graph.states[after])
    edges: list[int] = _cheapest_path(*arrays, rests, *ends, cost).tolist()
    return edges


@kernel
def _cheapest_path(
    offsets: np.ndarray,
    targets: np.ndarray,
    costs: np.ndarray,
    classes: np.ndarray,
    passable: np.ndarray,
    source: Integer,
    target: Integer,
    limit: Integer,
) -> np.ndarray:
    """Return the edges, one at least, of a path of cost `limit` through states of (C,) passable classes; or none."""
    # A link of a path has a number, an edge and the link before it. Of equal costs the heap has the largest item first,
    # so that ties go to the link made first. A state is left at most once, the source perhaps twice.
    most = 2 * targets.shape[0]
    edges, before = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
    costs_so_far, links = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
    passed = np.zeros(classes.shape[0], dtype=np.bool_)
    waiting: Integer = np.int64(0)
    state, link, cost, made = np.int64(source), np.int64(-1), np.int64(0), np.int64(0)
    while True:
        for edge in range(offsets[state], offsets[state + 1]):
            if cost + costs[edge] <= limit and not passed[targets[edge]]:
                edges[made], before[made] = edge, link
                waiting = heap_push(costs_so_far, links, waiting, cost + costs[edge], -made, None)
                made += 1
        while waiting > 0:
            cost, link = costs_so_far[0], -links[0]
            waiting = heap_pop(costs_so_far, links, waiting, None)
            state = np.int64(targets[edges[link]])
            if state == target and cost == limit:
                return _edges_to(link, edges, before)
            if passable[classes[state]] and not passed[state]:
                break
        else:
            return np.empty(0, dtype=np.int64)
        passed[state] = True


@kernel
def _edges_to(link: Integer, edges: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Return the edges of the path that ends with a link."""
    length, at = 0, link
    while at >= 0:
        length, at = length + 1, before[at]
    path = np.empty(length, dtype=np.int64)
    for k in range(length - 1, -1, -1):
        path[k], link = edges[link], before[link]
    return path
