"""Exact cost-to-go for a few tasks at a time, by backward Dijkstra on T x A_K (equation 4 for one task)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.models.kernels import INFINITE, NO_EDGE, Integer, bare_kernel, kernel
from prefplan.product.contraction import Graph, active_nodes, all_pairs_costs
from prefplan.product.heap import heap_pop, heap_push
from prefplan.product.product_automaton import Product


class ReverseView(NamedTuple):
    """The reverse of a product: the predecessors of each node, and of each automaton state.

    Attributes:
        offsets: (S + 1,) int64, sources: (E,) int32, costs: (E,) int64: edges by target.
        classes: (S,) int32.
        first: (N, Q, C + 1) int64, states: (X,) int32: `states[first[i, q, c] : first[i, q, c + 1]]` are those from
            which reading class c may lead to q.
        ends: (N, 2) int32, the accepting and the skipped state of each automaton, or -1.
        sizes: (N,) int64.
        near: (S, S) int64, edges as a matrix, NO_EDGE for none; empty unless the graph is contracted.
        active: (N, S) bool, whether a node's label can change an automaton; empty unless the graph is contracted.
    """

    offsets: np.ndarray
    sources: np.ndarray
    costs: np.ndarray
    classes: np.ndarray
    first: np.ndarray
    states: np.ndarray
    ends: np.ndarray
    sizes: np.ndarray
    near: np.ndarray
    active: np.ndarray


def reverse_view(product: Product, graph: Graph) -> ReverseView:
    """Return a product's reverse edges and automaton preimages."""
    nodes = graph.size
    source = np.repeat(np.arange(nodes, dtype=np.int32), np.diff(graph.offsets))
    order = np.argsort(graph.targets, kind="stable")
    tasks, most, labels = product.delta.shape
    first = np.zeros((tasks, most, labels + 1), dtype=np.int64)
    states: list[int] = []
    for i in range(tasks):
        size = int(product.sizes[i])
        into: list[list[list[int]]] = [[[] for _ in range(labels)] for _ in range(most)]
        for q in range(size):
            for c in range(labels):
                bought = slice(product.extra_first[i, q, c], product.extra_first[i, q, c + 1])
                for after in {int(product.delta[i, q, c]), *product.extra_state[bought].tolist()}:
                    into[after][c].append(q)
        for q in range(most):
            first[i, q, 0] = len(states)
            for c in range(labels):
                states += into[q][c]
                first[i, q, c + 1] = len(states)
    near, active = np.zeros((0, 0), dtype=np.int64), np.zeros((0, 0), dtype=bool)
    if graph.contracted:
        near, active = graph.near, active_nodes(product, graph)
    return ReverseView(
        np.searchsorted(graph.targets[order], np.arange(nodes + 1)).astype(np.int64),
        source[order],
        graph.costs[order],
        graph.classes,
        first,
        np.array(states, dtype=np.int32),
        product.ends,
        product.sizes,
        near,
        active,
    )


def restricted(reverse: ReverseView, tasks: np.ndarray) -> ReverseView:
    """Return a contracted product with edges only to nodes whose label can change the automata of some tasks."""
    if not len(reverse.near):
        return reverse
    matters = reverse.active[tasks].any(axis=0)
    near = all_pairs_costs(reverse.near, ~matters)
    near[:, ~matters] = NO_EDGE
    target, source = np.nonzero(near.T < NO_EDGE)
    offsets = np.searchsorted(target, np.arange(len(near) + 1)).astype(np.int64)
    return reverse._replace(offsets=offsets, sources=source.astype(np.int32), costs=near[source, target])


class _Readings(NamedTuple):
    """Buffers for the combinations of automaton states of k tasks from which a reading may lead to a given one.

    Attributes:
        before: (M,) int64, the combinations, as part of a cell's index. satisfied: (M,) int64, their satisfied tasks as
            bits.
        low: (k,) int64, high: (k,) int64, at: (k,) int64: scratch.
    """

    before: np.ndarray
    satisfied: np.ndarray
    low: np.ndarray
    high: np.ndarray
    at: np.ndarray


@kernel
def _buffer(reverse: ReverseView, tasks: np.ndarray) -> _Readings:
    most = 1
    for j in range(tasks.shape[0]):
        most *= reverse.sizes[tasks[j]]
    k = tasks.shape[0]
    return _Readings(
        np.empty(most, dtype=np.int64),
        np.empty(most, dtype=np.int64),
        np.empty(k, dtype=np.int64),
        np.empty(k, dtype=np.int64),
        np.empty(k, dtype=np.int64),
    )


@bare_kernel
def _readings(reverse: ReverseView, tasks: np.ndarray, cell: Integer, buffer: _Readings) -> Integer:
    """Write the combinations from which reading a cell's label may lead to it, and return how many there are."""
    first, states, ends, sizes = reverse.first, reverse.states, reverse.ends, reverse.sizes
    nodes = reverse.classes.shape[0]
    label = reverse.classes[cell % nodes]
    rest = cell // nodes
    k = tasks.shape[0]
    for j in range(k):
        q = rest % sizes[tasks[j]]
        rest //= sizes[tasks[j]]
        buffer.low[j] = first[tasks[j], q, label]
        buffer.high[j] = first[tasks[j], q, label + 1]
        buffer.at[j] = buffer.low[j]
        if buffer.low[j] == buffer.high[j]:
            return 0
    found = 0
    while True:
        stride = np.int64(nodes)
        before = np.int64(0)
        satisfied = 0
        for j in range(k):
            q = states[buffer.at[j]]
            before += stride * q
            stride *= sizes[tasks[j]]
            if q == ends[tasks[j], 0]:
                satisfied |= 1 << j
        buffer.before[found], buffer.satisfied[found] = before, satisfied
        found += 1
        j = 0
        while j < k:
            buffer.at[j] += 1
            if buffer.at[j] < buffer.high[j]:
                break
            buffer.at[j] = buffer.low[j]
            j += 1
        if j == k:
            return found


@bare_kernel
def _finished(reverse: ReverseView, tasks: np.ndarray, combination: Integer) -> bool:
    """Return whether all tasks are satisfied or dropped in a combination of their automata's states."""
    for j in range(tasks.shape[0]):
        q = combination % reverse.sizes[tasks[j]]
        combination //= reverse.sizes[tasks[j]]
        if q != reverse.ends[tasks[j], 0] and q != reverse.ends[tasks[j], 1]:
            return False
    return True


@kernel
def dijkstra(reverse: ReverseView, tasks: np.ndarray, factors: np.ndarray, table: np.ndarray, stop: np.ndarray) -> None:
    """Fill a table with least costs, weighted by the set of satisfied tasks; return early once `stop` is set.

    Costs of INFINITE and more are entered as INFINITE - 1, still a lower bound. Cells whose node has no incoming edge
    have no predecessors, and need not enter the open list.
    """
    offsets, sources, costs = reverse.offsets, reverse.sources, reverse.costs
    nodes = reverse.classes.shape[0]
    buffer = _buffer(reverse, tasks)
    keys, items = np.empty(4096, dtype=np.int64), np.empty(4096, dtype=np.int64)
    count: Integer = 0
    for combination in range(table.shape[0] // nodes):
        if _finished(reverse, tasks, combination):
            for node in range(nodes):
                table[node + nodes * combination] = 0
                if offsets[node] < offsets[node + 1]:
                    if count == keys.shape[0]:
                        keys, items = _twice(keys), _twice(items)
                    count = heap_push(keys, items, count, 0, node + nodes * combination)
    while count > 0 and not stop[0]:
        cost, cell = keys[0], items[0]
        count = heap_pop(keys, items, count)
        if table[cell] < cost:
            continue
        node = cell % nodes
        for reading in range(_readings(reverse, tasks, cell, buffer)):
            before, factor = buffer.before[reading], factors[buffer.satisfied[reading]]
            for edge in range(offsets[node], offsets[node + 1]):
                source = sources[edge]
                new = min(cost + factor * costs[edge], INFINITE - 1)
                if new < table[source + before]:
                    table[source + before] = new
                    if offsets[source] < offsets[source + 1]:
                        if count == keys.shape[0]:
                            keys, items = _twice(keys), _twice(items)
                        count = heap_push(keys, items, count, new, source + before)


@kernel
def _twice(array: np.ndarray) -> np.ndarray:
    longer = np.empty(2 * array.shape[0], dtype=array.dtype)
    longer[: array.shape[0]] = array
    return longer
