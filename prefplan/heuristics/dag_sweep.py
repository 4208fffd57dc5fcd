"""Exact cost-to-go for task subsets whose DFAs are acyclic up to self-loops (topological sweep).

The combinations of such automata's states can be ordered so that reading a label leads to an earlier one or changes
nothing. Taken in this order, each needs only a Dijkstra over the nodes whose labels matter, since the cost-to-go after
each change is known already. Every other node of a contracted graph is one edge away from these. The result is that of
Dijkstra on T x A_K, in a tenth of the time or less.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.limits import check_limits
from prefplan.product.contraction import Graph, active_nodes, all_pairs_costs
from prefplan.product.kernels import INFINITE, NO_EDGE, Integer, bare_kernel, kernel
from prefplan.product.product_automaton import Product


class Stages(NamedTuple):
    """A contracted graph of S nodes, and N automata that are acyclic up to self-loops.

    Attributes:
        near: (S, S) int64, edges as a matrix, NO_EDGE for none.
        classes: (S,) int32.
        active: (N, S) bool, whether a node's label can change an automaton.
        delta: (N, Q, C) int32, state after reading a class.
        order: (N, Q) int64, states of each automaton, each after all its successors.
        ends: (N, 2) int32, the accepting and the skipped state of each automaton, or -1.
        sizes: (N,) int64.
    """

    near: np.ndarray
    classes: np.ndarray
    active: np.ndarray
    delta: np.ndarray
    order: np.ndarray
    ends: np.ndarray
    sizes: np.ndarray


def stages_of(product: Product, graph: Graph) -> Stages | None:
    """Return a product as stages, or None if an automaton has a cycle, a task is relaxed or nothing is contracted."""
    order = order_of_states(product.delta, product.sizes)
    if not graph.contracted or product.relaxed or not len(order):
        return None
    active = active_nodes(product, graph)
    return Stages(graph.near, graph.classes, active, product.delta, order, product.ends, product.sizes)


def order_of_states(delta: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Return the states of some automata, each after all its successors, or an empty array if one has a cycle.

    Args:
        delta: (N, Q, C) int32, state after reading a class.
        sizes: (N,) int64, how many of the Q states each automaton has.

    Returns:
        (N, Q) int64, or (0, 0).
    """
    order = np.zeros(delta.shape[:2], dtype=np.int64)
    for i, size in enumerate(sizes.tolist()):
        after, rank = delta[i, :size], 0
        ordered, rest = np.zeros(size, dtype=bool), np.arange(size)
        while rank < size:
            check_limits()
            ready = (ordered[after[rest]] | (after[rest] == rest[:, None])).all(axis=1)
            if not ready.any():
                return np.zeros((0, 0), dtype=np.int64)
            layer, rest = rest[ready], rest[~ready]
            order[i, rank : rank + len(layer)] = layer
            ordered[layer] = True
            rank += len(layer)
    return order


@kernel
def fill_in_order(stages: Stages, tasks: np.ndarray, factors: np.ndarray, table: np.ndarray, stop: np.ndarray) -> None:
    """Fill a table with least costs, weighted by the set of satisfied tasks; return early once `stop` is set.

    Costs of INFINITE and more are treated as in `dijkstra`.

    Args:
        stages: the product.
        tasks: (k,) int64, which tasks.
        factors: (2^k,) int64 >= 0, by which to multiply costs while a set of these tasks is satisfied.
        table: (S * Q_1 * ... * Q_k,) int64, to be filled, indexed node + S * (q_1 + Q_1 * (q_2 + ...)).
        stop: (1,) bool.
    """
    nodes, k = stages.classes.shape[0], tasks.shape[0]
    matters = np.zeros(nodes, dtype=np.bool_)
    for j in range(k):
        matters |= stages.active[tasks[j]]
    changing = np.flatnonzero(matters)
    near = all_pairs_costs(stages.near, ~matters)
    steps, through = _weighted(near, changing, factors), _intermediate(near, changing)
    onto = targets_of(stages, tasks, changing)
    ranks, states = np.zeros(k, dtype=np.int64), np.zeros(k, dtype=np.int64)
    there = np.empty(changing.shape[0], dtype=np.int64)
    costs = np.empty(nodes, dtype=np.int64)
    for _ in range(table.shape[0] // nodes):
        if stop[0]:
            return
        here, stride = 0, nodes
        satisfied = 0
        finished = True
        for j in range(k):
            q = states[j] = stages.order[tasks[j], ranks[j]]
            here += stride * q
            stride *= stages.sizes[tasks[j]]
            if q == stages.ends[tasks[j], 0]:
                satisfied |= 1 << j
            elif q != stages.ends[tasks[j], 1]:
                finished = False
        costs[:] = 0 if finished else NO_EDGE
        if not finished:
            there[:] = changing
            for j in range(k):
                for d in range(changing.shape[0]):
                    there[d] += onto[j, states[j], d]
            _solve(steps[satisfied], changing, through, there, here, table, costs)
        for node in range(nodes):
            table[here + node] = INFINITE if costs[node] >= NO_EDGE else min(costs[node], INFINITE - 1)
        for j in range(k):
            ranks[j] += 1
            if ranks[j] < stages.sizes[tasks[j]]:
                break
            ranks[j] = 0


@kernel
def _weighted(near: np.ndarray, changing: np.ndarray, factors: np.ndarray) -> np.ndarray:
    """Return (F, D, S) the costs of edges from all nodes to D of them, times each factor."""
    steps = np.full((factors.shape[0], changing.shape[0], near.shape[0]), NO_EDGE, dtype=np.int64)
    for f in range(factors.shape[0]):
        for d in range(changing.shape[0]):
            for node in range(near.shape[0]):
                cost = near[node, changing[d]]
                if cost < NO_EDGE:
                    steps[f, d, node] = factors[f] * cost
    return steps


@kernel
def _intermediate(near: np.ndarray, changing: np.ndarray) -> Integer:
    """Return, as bits, those of some nodes through which a path is cheaper than the edge to another of them."""
    through = np.uint64(0)
    for d in range(changing.shape[0]):
        via = changing[d]
        for source in range(near.shape[0]):
            for target in changing:
                if near[source, via] + near[via, target] < near[source, target]:
                    through |= np.uint64(1) << np.uint64(d)
    return through


@kernel
def targets_of(stages: Stages, tasks: np.ndarray, changing: np.ndarray) -> np.ndarray:
    """Return (k, Q, D) what each task adds to the table's index after reading the labels of D nodes."""
    onto = np.zeros((tasks.shape[0], stages.delta.shape[1], changing.shape[0]), dtype=np.int64)
    stride = stages.classes.shape[0]
    for j in range(tasks.shape[0]):
        for q in range(stages.sizes[tasks[j]]):
            for d in range(changing.shape[0]):
                onto[j, q, d] = stride * stages.delta[tasks[j], q, stages.classes[changing[d]]]
        stride *= stages.sizes[tasks[j]]
    return onto


@bare_kernel
def _solve(
    steps: np.ndarray,
    changing: np.ndarray,
    through: Integer,
    there: np.ndarray,
    here: Integer,
    table: np.ndarray,
    costs: np.ndarray,
) -> None:
    """Write the cost-to-go of all nodes: by an immediate change, then through nodes that change nothing (Dijkstra)."""
    waiting = np.uint64(0)
    for d in range(changing.shape[0]):
        if there[d] == here + changing[d]:
            waiting |= np.uint64(through) & np.uint64(1) << np.uint64(d)
        elif table[there[d]] < INFINITE:
            relax(steps[d], table[there[d]], costs)
    while waiting:
        least = np.int64(NO_EDGE)
        best = -1
        for d in range(changing.shape[0]):
            if (waiting >> np.uint64(d)) & np.uint64(1) and costs[changing[d]] < least:
                best, least = d, costs[changing[d]]
        if best < 0:
            return
        waiting ^= np.uint64(1) << np.uint64(best)
        relax(steps[best], least, costs)


@bare_kernel
def relax(steps: np.ndarray, rest: Integer, costs: np.ndarray) -> None:
    """Lower the costs (S,) of all nodes to those of paths through a node with cost-to-go `rest`."""
    for node in range(costs.shape[0]):
        costs[node] = min(costs[node], steps[node] + rest)
