"""Exact cost-to-go for a few tasks at a time, by backward Dijkstra on T x A_K (equation 4 for one task).

The preference's growth on the way can be bounded or itself be what is minimised: an edge of cost w taken while S is the
satisfied set makes mu grow by rate(S) w.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.heap import heap_pop, heap_push
from prefplan.kernels import FAR, INFINITE, Integer, ProductView, kernel
from prefplan.product import Product


class Backward(NamedTuple):
    """A product turned round: who leads to a node, and which automaton states lead to one.

    Attributes:
        offsets: (S + 1,) int64, sources: (E,) int32, costs: (E,) int64: edges by target.
        classes: (S,) int32.
        first: (N, Q, C + 1) int64: `first[i, q, c] : first[i, q, c + 1]` are the states that reading class c may lead
            from to q. states: (X,) int32.
        ends: (N, 2) int32, the accepting and the skipped state of each automaton, or -1.
        sizes: (N,) int64.
        shift: the low bits of costs, that count actions and do not make mu grow.
        near: (S, S) int64, edges as a matrix, FAR for none; empty unless the graph is contracted.
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
    shift: int
    near: np.ndarray
    active: np.ndarray


def backward(product: Product, forward: ProductView) -> Backward:
    """Return a product's reverse edges and automaton preimages."""
    nodes = len(forward.classes)
    source = np.repeat(np.arange(nodes, dtype=np.int32), np.diff(forward.offsets))
    order = np.argsort(forward.targets, kind="stable")
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
    bits = np.bitwise_or.reduce(forward.active, axis=1)
    nodes_active = (bits[:, None] >> np.arange(min(nodes, 64), dtype=np.uint64)[None, :]) & np.uint64(1) > 0
    return Backward(
        np.searchsorted(forward.targets[order], np.arange(nodes + 1)).astype(np.int64),
        source[order],
        forward.costs[order],
        forward.classes,
        first,
        np.array(states, dtype=np.int32),
        np.stack([product.accepting, product.skipped], axis=1),
        product.sizes,
        forward.shift,
        forward.near,
        nodes_active if forward.macro else np.zeros((0, 0), dtype=bool),
    )


def restricted(reverse: Backward, tasks: np.ndarray) -> Backward:
    """Return a contracted product with only those edges that end where a label matters to some tasks."""
    if not len(reverse.near):
        return reverse
    near = reverse.near.copy()
    matters = reverse.active[tasks].any(axis=0)
    for via in np.flatnonzero(~matters):
        np.minimum(near, near[:, via, None] + near[None, via, :], out=near)
    near[:, ~matters] = FAR
    target, source = np.nonzero(near.T < FAR)
    offsets = np.searchsorted(target, np.arange(len(near) + 1)).astype(np.int64)
    return reverse._replace(offsets=offsets, sources=source.astype(np.int32), costs=near[source, target])


def cost_to_go(
    reverse: Backward,
    tasks: np.ndarray,
    dtype: type,
    *,
    rates: np.ndarray | None = None,
    budgets: np.ndarray | None = None,
) -> np.ndarray:
    """Return the least cost until all of some tasks are satisfied or dropped, for every budget of mu's growth.

    Args:
        reverse: the product.
        tasks: (k,) int64, which tasks.
        dtype: np.int32 or np.int64.
        rates: (2^k,) int64 >= 0, growth of mu for a unit of cost while a set of these tasks is satisfied.
        budgets: (B,) int64, falling: how much mu may grow; one that is not bounded if None.

    Returns:
        (B, S * Q_1 * ... * Q_k) of the chosen type, indexed node + S * (q_1 + Q_1 * (q_2 + ...)); infinite where it
        cannot be done.

    Raises:
        OverflowError: if a finite cost does not fit the type.
    """
    size = len(reverse.classes) * int(np.prod(reverse.sizes[tasks]))
    infinite = INFINITE[dtype]
    if budgets is None:
        budgets = np.array([FAR], dtype=np.int64)
    if rates is None:
        rates = np.zeros(2 ** len(tasks), dtype=np.int64)
    ones = np.ones(2 ** len(tasks), dtype=np.int64)
    table: np.ndarray = np.full((len(budgets), size), infinite, dtype=dtype)
    if not _dijkstra(restricted(reverse, tasks), tasks, ones, rates, budgets, table, infinite):
        raise OverflowError
    return table


def growth_to_go(reverse: Backward, tasks: np.ndarray, dtype: type, rates: np.ndarray) -> np.ndarray:
    """Return the least growth of mu until all of some tasks are satisfied or dropped, whatever the cost.

    Arguments, shape and errors are those of `cost_to_go`.
    """
    size = len(reverse.classes) * int(np.prod(reverse.sizes[tasks]))
    infinite = INFINITE[dtype]
    table: np.ndarray = np.full((1, size), infinite, dtype=dtype)
    budgets, none = np.array([FAR], dtype=np.int64), np.zeros_like(rates)
    spent = restricted(reverse, tasks)
    spent = spent._replace(costs=spent.costs >> spent.shift)
    if not _dijkstra(spent, tasks, rates, none, budgets, table, infinite):
        raise OverflowError
    return table[0]


@kernel
def _dijkstra(
    reverse: Backward,
    tasks: np.ndarray,
    factors: np.ndarray,
    rates: np.ndarray,
    budgets: np.ndarray,
    table: np.ndarray,
    infinite: Integer,
) -> bool:
    """Fill a table by labels (cost, growth), in order of cost; each settles the budgets that nothing met before.

    A label that grows no less than an earlier one of its cell is dominated; of those over the largest finite budget
    only the first matters.
    """
    offsets, sources, costs, classes = reverse.offsets, reverse.sources, reverse.costs, reverse.classes
    first, states, ends, sizes = reverse.first, reverse.states, reverse.ends, reverse.sizes
    nodes = classes.shape[0]
    k = tasks.shape[0]
    last = budgets.shape[0] - 1
    strictest = budgets[1] if last > 0 else -1
    least = np.full(table.shape[1], FAR, dtype=np.int64)
    last_cost = np.full(table.shape[1], FAR, dtype=np.int64)
    last_growth = np.full(table.shape[1], FAR, dtype=np.int64)
    strides = np.empty(k, dtype=np.int64)
    stride = np.int64(1)
    for j in range(k):
        strides[j] = stride
        stride *= sizes[tasks[j]]
    room = 4096
    keys = np.empty(room, dtype=np.int64)
    items = np.empty(room, dtype=np.int64)
    cells = np.empty(room, dtype=np.int64)
    growths = np.empty(room, dtype=np.int64)
    count: Integer = 0
    made = 0
    for combination in range(stride):
        finished = True
        for j in range(k):
            q = combination // strides[j] % sizes[tasks[j]]
            if q != ends[tasks[j], 0] and q != ends[tasks[j], 1]:
                finished = False
        if finished:
            for node in range(nodes):
                if made == room:
                    keys, items, cells, growths, room = _grown(keys, items, cells, growths)
                cells[made] = node + nodes * combination
                growths[made] = 0
                count = heap_push(keys, items, count, 0, made)
                made += 1
    low = np.empty(k, dtype=np.int64)
    high = np.empty(k, dtype=np.int64)
    at = np.empty(k, dtype=np.int64)
    while count > 0:
        cost, item = keys[0], items[0]
        count = heap_pop(keys, items, count)
        cell, growth = cells[item], growths[item]
        if growth >= least[cell] or (growth > strictest and least[cell] < FAR):
            continue
        least[cell] = growth
        level = last
        while budgets[level] < growth:
            level -= 1
        while level >= 0 and table[level, cell] > cost:
            table[level, cell] = cost
            level -= 1
        node = cell % nodes
        if offsets[node] == offsets[node + 1]:
            continue
        combination = cell // nodes
        label = classes[node]
        possible = True
        for j in range(k):
            q = combination // strides[j] % sizes[tasks[j]]
            low[j] = first[tasks[j], q, label]
            high[j] = first[tasks[j], q, label + 1]
            at[j] = low[j]
            possible &= low[j] < high[j]
        while possible:
            before = np.int64(0)
            satisfied = 0
            for j in range(k):
                q = states[at[j]]
                before += strides[j] * q
                if q == ends[tasks[j], 0]:
                    satisfied |= 1 << j
            rate = rates[satisfied]
            for edge in range(offsets[node], offsets[node + 1]):
                new_cell = sources[edge] + nodes * before
                new = cost + factors[satisfied] * costs[edge]
                more = growth + rate * (costs[edge] >> reverse.shift)
                if new >= last_cost[new_cell] and more >= last_growth[new_cell]:
                    continue
                if more < least[new_cell] and (more <= strictest or least[new_cell] == FAR):
                    last_cost[new_cell], last_growth[new_cell] = new, more
                    if new >= infinite:
                        return False
                    if made == room:
                        keys, items, cells, growths, room = _grown(keys, items, cells, growths)
                    cells[made] = new_cell
                    growths[made] = more
                    count = heap_push(keys, items, count, new, made)
                    made += 1
            j = 0
            while j < k:
                at[j] += 1
                if at[j] < high[j]:
                    break
                at[j] = low[j]
                j += 1
            possible = j < k
    return True


@kernel
def _grown(
    keys: np.ndarray, items: np.ndarray, cells: np.ndarray, growths: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, int]:
    return _twice(keys), _twice(items), _twice(cells), _twice(growths), 2 * keys.shape[0]


@kernel
def _twice(array: np.ndarray) -> np.ndarray:
    longer = np.empty(2 * array.shape[0], dtype=array.dtype)
    longer[: array.shape[0]] = array
    return longer
