"""Least weighted cost-to-go for task subsets whose DFAs are acyclic up to self-loops (topological sweep).

The combinations of the states of acyclic automata are ordered so that reading a label leads to an earlier one or
changes nothing. From node s and automaton states q,

    h(s, q) = min over nodes v whose label changes q of d(s, v) + h(v, delta(q, L(v))),

where d are least costs in the whole graph, whatever labels are passed. That is a relaxation: h is a lower bound, and
consistent, since d(u, v) <= w(u, s) + d(s, v). It is exact if costs have equal weights, and no label leads an automaton
to a state that is worse than the one before, as for `F (a & F b)`: then the labels passed do no harm (`never_lose`).

For all nodes of a combination together this is the minimum of a few rows of numbers, a tenth of the time of
`backward_dijkstra` or less.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from graphlib import CycleError, TopologicalSorter
from typing import NamedTuple

import numpy as np

from prefplan.limits import check_limits
from prefplan.models.kernels import INFINITE, NO_EDGE, UNREACHABLE, Integer, inner_kernel, kernel
from prefplan.product.contraction import NODE_LIMIT, Graph, active_nodes, bits_of
from prefplan.product.product_automaton import Product

LARGEST_SIMULATED = 1_000
"""Most states of an automaton of which all pairs are compared: 1 ms for each label and round."""

MOST = {np.dtype(np.uint16): 20_000, np.dtype(np.int32): UNREACHABLE, np.dtype(np.int64): INFINITE}
"""Stands for no path in tables of these types; larger sums are cut off at one less. Three times as much still fits."""


class Stages(NamedTuple):
    """A contracted graph of S nodes, and N automata that are acyclic up to self-loops.

    Attributes:
        least: (S, S) int64, least costs from node to node, NO_EDGE for none.
        active: (N + R, S) bool, whether a node's label can change the automaton of a task or rule.
        after: (N, Q, S) int32, state after reading a node's label.
        order: (N, Q) int64, states of each automaton, each after all its successors.
        ends: (N, 2) int32, the accepting and the skipped state of each automaton, or -1.
        sizes: (N,) int64.
    """

    least: np.ndarray
    active: np.ndarray
    after: np.ndarray
    order: np.ndarray
    ends: np.ndarray
    sizes: np.ndarray


def stages_of(product: Product, graph: Graph) -> Stages | None:
    """Return a product as stages, or None if an automaton has a cycle, a task is relaxed or nothing is contracted."""
    if not graph.contracted or product.relaxed:
        return None
    try:
        order = _order_of_states(product.delta[: len(product.sizes)], product.sizes)
    except CycleError:
        return None
    active, after = active_nodes(product, graph), product.delta[: len(product.sizes), :, graph.classes]
    return Stages(graph.least, active, after, order, product.ends, product.sizes)


def _order_of_states(delta: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Return (N, Q) the states of some automata, each after all its successors; CycleError if that is not possible."""
    order = np.zeros(delta.shape[:2], dtype=np.int64)
    for i, size in enumerate(sizes.tolist()):
        check_limits()
        successors = {q: {*after} - {q} for q, after in enumerate(delta[i, :size].tolist())}
        order[i, :size] = list(TopologicalSorter(successors).static_order())
    return order


def never_lose(product: Product) -> bool:
    """Return whether reading a label never leads an automaton to a state that is worse than the one before.

    A state is no worse than another if it is an end whenever the other is, and every label leads from it to a state no
    worse than from the other (the greatest simulation). False also if an automaton is too large to try.
    """
    for i, size in enumerate(product.sizes.tolist()):
        if size > LARGEST_SIMULATED:
            return False
        after = np.unique(product.delta[i, :size], axis=1).astype(np.int64)
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


class Layout(NamedTuple):
    """Where a table over S nodes and k tasks of at most Q automaton states has its entries.

    Attributes:
        first: (S,) int64, place: (S, k, Q) int64: entry = first[node] + sum_j place[node, j, q_j]; there is none where
            a place is -1.
        entries: how many there are.
    """

    first: np.ndarray
    place: np.ndarray
    entries: int


def full_layout(stages: Stages, tasks: Sequence[int]) -> Layout:
    """Return the layout of a table with all entries: entry = node + S * (q_1 + Q_1 * (q_2 + ...))."""
    nodes, most = stages.after.shape[2], stages.after.shape[1]
    strides = nodes * np.cumprod([1, *stages.sizes[list(tasks)]])
    place = np.broadcast_to(strides[:-1, None] * np.arange(most), (nodes, len(tasks), most))
    return Layout(np.arange(nodes), place, int(strides[-1]))


class SweepInput(NamedTuple):
    """Input for filling a table of S nodes and k tasks of at most Q automaton states, with F different weights.

    Attributes:
        order: (k, Q) int64, sizes: (k,) int64, ends: (k, 2) int32: see `Stages`.
        active: (k, Q) uint64, nodes whose label changes a state. kept: (k, Q) uint64, nodes that have entries for it.
        first: (S,) int64. here: (k, Q, S) int64, what the state adds to the index of a node's entry. onward: (k, Q, S)
            int64, the same after reading the node's label.
        steps: (F, S, NODE_LIMIT) as the table, weighted least cost to a node from all others, twice `none` for no path.
        kind: (2^k,) int64, number of the weight for each set of satisfied tasks.
        none: stands for no path in the table.
    """

    order: np.ndarray
    sizes: np.ndarray
    ends: np.ndarray
    active: np.ndarray
    kept: np.ndarray
    first: np.ndarray
    here: np.ndarray
    onward: np.ndarray
    steps: np.ndarray
    kind: np.ndarray
    none: int


def sweep(
    stages: Stages,
    tasks: Sequence[int],
    factors: np.ndarray,
    table: np.ndarray,
    *,
    layout: Layout | None = None,
    shift: int = 0,
    unit: int = 1,
) -> Callable[[np.ndarray], None]:
    """Return a function that fills a table for some tasks, given the flag (1,) bool that stops it.

    Args:
        stages: the product.
        tasks: (k,).
        factors: (2^k,) int64 >= 0, by which to multiply costs while a set of these tasks is satisfied.
        table: of a type in `MOST`.
        layout: of the table; None for all entries.
        shift: low bits that are left out of costs.
        unit: by which the sums in the table are divided.
    """
    members, none = np.array(tasks, dtype=np.int64), MOST[table.dtype]
    layout = layout or full_layout(stages, tasks)
    different, kind = np.unique(factors, return_inverse=True)
    least = np.where(stages.least < NO_EDGE, stages.least >> shift, NO_EDGE)
    steps = np.stack([_weighted(least, factor, unit, none) for factor in different.tolist()])
    after = stages.after[members]
    place = np.ascontiguousarray(layout.place.transpose(1, 2, 0))
    given = SweepInput(
        order=stages.order[members],
        sizes=stages.sizes[members],
        ends=stages.ends[members],
        active=bits_of(after != np.arange(after.shape[1])[None, :, None]),
        kept=bits_of(place >= 0),
        first=layout.first,
        here=place,
        onward=np.ascontiguousarray(np.take_along_axis(place, after.astype(np.int64), axis=1)),
        steps=steps.astype(table.dtype),
        kind=kind.reshape(-1).astype(np.int64),
        none=none,
    )
    return partial(fill, given, table)


def _weighted(least: np.ndarray, factor: int, unit: int, none: int) -> np.ndarray:
    """Return (S, NODE_LIMIT) least costs (S, S) times a factor, in units, to each node from all others."""
    most = (none - 1) * unit // factor if factor else 0
    costs = np.where(least > most, none - 1 if factor else 0, np.minimum(least, most) * factor // unit)
    steps = np.full((len(least), NODE_LIMIT), 2 * none)
    steps[:, : len(least)] = np.where(least < NO_EDGE, costs, 2 * none).T
    return steps


@kernel
def fill(sweep: SweepInput, table: np.ndarray, stop: np.ndarray) -> None:
    """Fill a table, each combination of automaton states after all its successors; return early once `stop` is set.

    Partial sums over the last tasks are kept, as the first task's state changes most often.
    """
    tasks, nodes, none = sweep.sizes.shape[0], sweep.first.shape[0], sweep.none
    here, onward = np.zeros((tasks + 1, nodes), dtype=np.int64), np.zeros((tasks + 1, nodes), dtype=np.int64)
    for v in range(nodes):
        here[tasks, v] = onward[tasks, v] = sweep.first[v]
    stops, kept = np.zeros(tasks + 1, dtype=np.uint64), np.zeros(tasks + 1, dtype=np.uint64)
    satisfied, finished = np.zeros(tasks + 1, dtype=np.int64), np.ones(tasks + 1, dtype=np.bool_)
    ranks, costs = np.zeros(tasks, dtype=np.int64), np.zeros(sweep.steps.shape[2], dtype=table.dtype)
    kept[tasks] = ~np.uint64(0)
    changed = tasks
    while not stop[0]:
        for i in range(changed - 1, -1, -1):
            q = sweep.order[i, ranks[i]]
            if i > 0:
                for v in range(nodes):
                    here[i, v] = here[i + 1, v] + sweep.here[i, q, v]
                    onward[i, v] = onward[i + 1, v] + sweep.onward[i, q, v]
            stops[i], kept[i] = stops[i + 1] | sweep.active[i, q], kept[i + 1] & sweep.kept[i, q]
            satisfied[i] = satisfied[i + 1] | ((q == sweep.ends[i, 0]) << i)
            finished[i] = finished[i + 1] and (q == sweep.ends[i, 0] or q == sweep.ends[i, 1])
        q = sweep.order[0, ranks[0]]
        _least_sums(sweep, sweep.kind[satisfied[0]], stops[0], onward[1], sweep.onward[0, q], table, costs)
        for v in range(nodes):
            if kept[0] >> np.uint64(v) & np.uint64(1):
                cost = 0 if finished[0] else costs[v]
                table[here[1, v] + sweep.here[0, q, v]] = none if cost >= 2 * none else min(cost, none - 1)
        changed = 1
        while ranks[changed - 1] + 1 == sweep.sizes[changed - 1]:
            ranks[changed - 1] = 0
            changed += 1
            if changed > tasks:
                return
        ranks[changed - 1] += 1


@inner_kernel
def _least_sums(
    sweep: SweepInput,
    kind: Integer,
    stops: Integer,
    others: np.ndarray,
    first: np.ndarray,
    table: np.ndarray,
    costs: np.ndarray,
) -> None:
    """Write the least sum from every node, through those whose label changes some automaton, one of the `stops`.

    It is twice `none` without a path. After reading a label, the index of node v's entry is others[v] + first[v].
    """
    none = sweep.none
    for u in range(costs.shape[0]):
        costs[u] = 2 * none
    for v in range(first.shape[0]):
        if stops >> np.uint64(v) & np.uint64(1):
            rest = table[others[v] + first[v]]
            if rest < none:
                step = sweep.steps[kind, v]
                # A loop of fixed length is vectorised: for 16 bits it becomes four instructions.
                for u in range(NODE_LIMIT):
                    cost = costs.dtype.type(step[u] + rest)
                    costs[u] = cost if cost < costs[u] else costs[u]
