"""Exact cost-to-go for task subsets whose DFAs are acyclic up to self-loops, and never lose (topological sweep).

The combinations of the states of acyclic automata are ordered so that reading a label leads to an earlier one or
changes nothing. Let no label lead an automaton to a state that is worse than the one before, as for `F (a & F b)`. Then
the labels passed on the way to a node do no harm, and from node s and automaton states q

    h(s, q) = min over nodes v whose label changes q of d(s, v) + h(v, delta(q, L(v))),

where d are least costs in the whole graph. Where costs are weighted by the set of satisfied tasks, passing a label may
do harm, and h is a lower bound; it is consistent, since d(u, v) <= w(u, s) + d(s, v). An entry takes 7 ns, a tenth of
the time of `backward_dijkstra` or less.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from prefplan.limits import check_limits
from prefplan.models.kernels import NO_EDGE, Integer, bare_kernel, kernel
from prefplan.product.contraction import Graph, active_nodes
from prefplan.product.product_automaton import Product

LARGEST_SIMULATED = 1_000
"""Most states of an automaton of which all pairs are compared: 1 ms for each label and round."""


class Stages(NamedTuple):
    """A contracted graph of S nodes, and N automata that are acyclic up to self-loops.

    Attributes:
        least: (S, S) int64, least costs from node to node, NO_EDGE for none.
        classes: (S,) int32.
        active: (N + R, S) bool, whether a node's label can change an automaton.
        delta: (N, Q, C) int32, state after reading a class.
        order: (N, Q) int64, states of each automaton, each after all its successors.
        ends: (N, 2) int32, the accepting and the skipped state of each automaton, or -1.
        sizes: (N,) int64.
    """

    least: np.ndarray
    classes: np.ndarray
    active: np.ndarray
    delta: np.ndarray
    order: np.ndarray
    ends: np.ndarray
    sizes: np.ndarray


def stages_of(product: Product, graph: Graph) -> Stages | None:
    """Return a product as stages, or None if an automaton has a cycle, a task is relaxed or nothing is contracted."""
    if not graph.contracted or product.relaxed:
        return None
    order = order_of_states(product.delta, product.sizes)
    if not len(order):
        return None
    least, active = graph.least, active_nodes(product, graph)
    return Stages(least, graph.classes, active, product.delta, order, product.ends, product.sizes)


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


def never_lose(product: Product) -> bool:
    """Return whether reading a label never leads an automaton to a state that is worse than the one before.

    A state is no worse than another if it is an end whenever the other is, and every label leads from it to a state no
    worse than from the other (the greatest simulation). False also if an automaton is too large to try.
    """
    for i, size in enumerate(product.sizes.tolist()):
        if size > LARGEST_SIMULATED:
            return False
        after = product.delta[i, :size].astype(np.int64)
        ends = np.isin(np.arange(size), product.ends[i])
        no_worse, before = ends[:, None] >= ends[None, :], None
        while before is None or (no_worse < before).any():
            before = no_worse.copy()
            for label in after.T:
                check_limits()
                no_worse &= before[label[:, None], label[None, :]]
        if not no_worse[after, np.arange(size)[:, None]].all():
            return False
    return True


def sweep(
    stages: Stages, tasks: np.ndarray, factors: np.ndarray, shift: int, table: np.ndarray, unreachable: int
) -> Callable[[np.ndarray], None]:
    """Return a function that fills a table, given the flag (1,) bool that stops it.

    Args:
        stages: the product, for which `never_lose` holds.
        tasks: (k,) int64, which tasks.
        factors: (2^k,) int64 >= 0, by which to multiply costs while a set of these tasks is satisfied.
        shift: low bits that are left out of costs.
        table: (S * Q_1 * ... * Q_k,) of integers, to be filled, indexed node + S * (q_1 + Q_1 * (q_2 + ...)).
        unreachable: stands for no path; costs are cut off at one less.
    """
    changing = np.flatnonzero(stages.active[tasks].any(axis=0))
    sizes, after = stages.sizes[tasks], stages.delta[tasks][:, :, stages.classes[changing]]
    strides = len(stages.classes) * np.cumprod([1, *sizes[:-1]])
    different, kind = np.unique(factors, return_inverse=True)
    costs = stages.least[:, changing].T
    steps = np.stack([np.where(costs < NO_EDGE, factor * (costs >> shift), NO_EDGE) for factor in different])
    onto = strides[:, None, None] * after
    order, ends = stages.order[tasks], stages.ends[tasks]
    return partial(fill_in_order, order, sizes, ends, changing, onto, steps, kind, table, unreachable)


@kernel
def fill_in_order(
    order: np.ndarray,
    sizes: np.ndarray,
    ends: np.ndarray,
    changing: np.ndarray,
    onto: np.ndarray,
    steps: np.ndarray,
    kind: np.ndarray,
    table: np.ndarray,
    unreachable: Integer,
    stop: np.ndarray,
) -> None:
    """Fill a table, each combination of automaton states after all its successors; return early once `stop` is set.

    Args:
        order: (k, Q) int64, see `Stages`.
        sizes: (k,) int64, see `Stages`.
        ends: (k, 2) int32, see `Stages`.
        changing: (D,) int64, the nodes whose label can change an automaton.
        onto: (k, Q, D) int64, what each task adds to the table's index after reading their labels.
        steps: (F, D, S) int64, weighted least costs from all nodes to these.
        kind: (2^k,) int64, which of the weights holds for each set of satisfied tasks.
        table: as in `sweep`.
        unreachable: as in `sweep`.
        stop: (1,) bool.
    """
    nodes, k = steps.shape[2], sizes.shape[0]
    # Sums over tasks from the j-th on: the combination's first entry, those after each label, which tasks are done.
    here, done, satisfied = np.zeros(k + 1, np.int64), np.zeros(k + 1, np.int64), np.zeros(k + 1, np.int64)
    there = np.zeros((k + 1, changing.shape[0]), dtype=np.int64)
    strides, ranks = np.full(k, nodes, dtype=np.int64), np.zeros(k, dtype=np.int64)
    for j in range(1, k):
        strides[j] = strides[j - 1] * sizes[j - 1]
    costs = np.empty(nodes, dtype=np.int64)
    j = k - 1
    for _ in range(table.shape[0] // nodes):
        if stop[0]:
            return
        while j >= 0:
            q = order[j, ranks[j]]
            here[j] = here[j + 1] + strides[j] * q
            done[j] = done[j + 1] + (q == ends[j, 0] or q == ends[j, 1])
            satisfied[j] = satisfied[j + 1] | ((q == ends[j, 0]) << j)
            for d in range(there.shape[1]):
                there[j, d] = there[j + 1, d] + onto[j, q, d]
            j -= 1
        costs[:] = 0 if done[0] == k else NO_EDGE
        step = steps[kind[satisfied[0]]]
        for d in range(changing.shape[0]):
            if there[0, d] != here[0]:
                rest = np.int64(table[there[0, d] + changing[d]])
                if rest < unreachable:
                    relax(step[d], rest, costs)
        for node in range(nodes):
            table[here[0] + node] = unreachable if costs[node] >= NO_EDGE else min(costs[node], unreachable - 1)
        j = 0
        while j < k:
            ranks[j] += 1
            if ranks[j] < sizes[j]:
                break
            ranks[j] = 0
            j += 1


@bare_kernel
def relax(steps: np.ndarray, rest: Integer, costs: np.ndarray) -> None:
    """Lower the costs (S,) of all nodes to those of paths through a node with cost-to-go `rest`."""
    for node in range(costs.shape[0]):
        costs[node] = min(costs[node], steps[node] + rest)
