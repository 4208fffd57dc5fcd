"""The graph that a product is searched over: the transition system, or what static contraction leaves of it.

A label class is *inert* if no automaton ever changes its state on it: delta_i(q, l) = q for every task or rule i and q
(idempotence is not enough: the empty label makes `a U b` unsatisfiable). States of inert classes are only passed
through. Contraction keeps the other states and the start, at most 64 in all; the edge between two of them has the cost
of the cheapest path through inert states. This preserves costs, and sequences of labels that are not inert.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np

from prefplan.exact_costs import INT64_LIMIT
from prefplan.limits import run_within_limits
from prefplan.models.kernels import INFINITE, Integer, kernel
from prefplan.product.heap import heap_pop, heap_push
from prefplan.product.product_automaton import Product
from prefplan.product.space import Graph, changes

NODE_LIMIT = 64
"""Most nodes of a contracted graph: sets of them fit one machine word; on larger graphs contraction does not pay."""


def contract(product: Product) -> Graph | None:
    """Return the contracted graph, or None if it had more than NODE_LIMIT nodes or costs might not fit 64 bits."""
    whole = product.graph
    if whole.size * int(whole.costs.max(initial=0)) >= INT64_LIMIT:
        return None
    matters = np.logical_or.reduce(changes(product.tables), axis=(0, 1))[whole.classes]
    keep = matters.copy()
    keep[whole.start] = True
    states = np.flatnonzero(keep)
    if len(states) > NODE_LIMIT:
        return None
    node = np.full(len(keep), -1, dtype=np.int64)
    node[states] = np.arange(len(states))
    near = np.empty((len(states), len(states)), dtype=np.int64)
    arrays = whole.offsets, whole.targets, whole.costs, matters, states, node, near
    run_within_limits(partial(_cheapest_paths, *arrays), len(states) * len(whole.targets))
    if len(states) * int(near.max(initial=0)) >= INFINITE:
        return None
    source, target = np.nonzero(near >= 0)
    return Graph(
        np.searchsorted(source, np.arange(len(states) + 1)).astype(np.int64),
        target.astype(np.int32),
        near[source, target],
        whole.classes[states],
        states,
        int(node[whole.start]),
        True,
        whole.shift,
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
    stop: np.ndarray,
) -> None:
    """Write the cost of the cheapest path through inert states from each kept one to each that matters; -1 for none.

    It returns early once `stop` is set.
    """
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
        while count > 0 and not stop[0]:
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
    """Return the edges of a path of a given cost between two nodes; no automaton moves before the last edge.

    Return none if there is no such path. Ties go to fewer actions, then to the model's order of actions. `automata` are
    the automaton states at the first node; `cost` is as in `Graph.costs`.
    """
    rests = (product.tables.delta[np.arange(len(automata)), automata] == np.array(automata)[:, None]).all(axis=0)
    arrays = product.graph.offsets, product.graph.targets, product.graph.costs, product.graph.classes
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
    # A link of a path has a number, an edge and the link before it. Heap items are the numbers times -1: ties go to the
    # link made first. A state is left at most once, the source perhaps twice.
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
