"""Least weighted cost-to-go for task subsets whose DFAs are acyclic up to self-loops (topological sweep).

The combinations of the states of acyclic automata are ordered so that reading a label leads to an earlier one or
changes nothing. From node s and automaton states q,

    h(s, q) = min over nodes v whose label changes q of d(s, v) + h(v, delta(q, L(v))),

where d are least costs in the whole graph; the labels on the path from s to v are ignored. This is a relaxation: h is a
lower bound, and consistent, since d(u, v) <= w(u, s) + d(s, v). h is exact if costs have equal weights, and no label
leads an automaton to a worse state, as for `F (a & F b)`: then the ignored labels do no harm. If a label may make a
task impossible to satisfy, h does not show this (`Stages.is_safe`).

For all nodes of a combination together, h is the minimum of a few rows of numbers: this takes a tenth of the time of
Dijkstra's algorithm in `backward`, or less.
"""

from collections.abc import Callable, Sequence
from functools import partial
from graphlib import CycleError, TopologicalSorter
from typing import NamedTuple

import numpy as np

from prefplan.limits import check_limits
from prefplan.models.kernels import NO_EDGE, UNREACHABLE, Integer, inner_kernel, kernel
from prefplan.product.contraction import NODE_LIMIT
from prefplan.product.product_automaton import Product
from prefplan.product.space import Graph, bits_of

MOST = {np.dtype(np.uint16): 20_000, np.dtype(np.int32): UNREACHABLE}
"""Entry for no path in tables of these types; larger sums are cut off at one less. Three times this still fits."""

ABSENT = -(2**50)
"""Place of an entry that a table does not have: every sum of places that includes it is negative."""


class Stages(NamedTuple):
    """A product over a contracted graph, whose automata are acyclic up to self-loops.

    Attributes:
        product: with N tasks, whose automata have at most Q states.
        graph: of S nodes.
        order: (N, Q) int64, states of each automaton, each after all its successors.
        is_safe: whether no label leads an automaton from a state that can reach an end to one that cannot.
    """

    product: Product
    graph: Graph
    order: np.ndarray
    is_safe: bool

    @property
    def after(self) -> np.ndarray:
        """(N, Q, S) int64, state after reading a node's label."""
        return self.product.tables.delta[: len(self.order), :, self.graph.classes].astype(np.int64)


def stages_of(product: Product, graph: Graph) -> Stages | None:
    """Return a product as stages; None if an automaton has a cycle, a task can be relaxed or nothing is contracted."""
    if not graph.contracted or len(product.tables.relaxed):
        return None
    order, is_safe = np.zeros((len(product.sizes), product.tables.delta.shape[1]), dtype=np.int64), True
    for i, size in enumerate(product.sizes.tolist()):
        check_limits()
        successors = {q: {*after} - {q} for q, after in enumerate(product.tables.delta[i, :size].tolist())}
        try:
            states = list(TopologicalSorter(successors).static_order())
        except CycleError:
            return None
        order[i, :size], live = states, set(product.tables.ends[i].tolist())
        for q in states:
            if q in live or not live.isdisjoint(successors[q]):
                live.add(q)
                is_safe &= live.issuperset(successors[q])
    return Stages(product, graph, order, is_safe)


class Layout(NamedTuple):
    """Where a table over S nodes and k tasks of at most Q automaton states has its entries.

    Attributes:
        place: (S, k, Q) int64: entry = sum_j place[node, j, q_j]; there is none where a place is ABSENT.
        entries: number of entries.
    """

    place: np.ndarray
    entries: int


def full_layout(stages: Stages, tasks: Sequence[int]) -> Layout:
    """Return the layout of a table with all entries: entry = node + S * (q_1 + Q_1 * (q_2 + ...))."""
    nodes, states = stages.graph.size, np.arange(stages.order.shape[1])
    strides = nodes * np.cumprod([1, *stages.product.sizes[list(tasks)]])
    place = np.tile(strides[:-1, None] * states, (nodes, 1, 1))
    place[:, 0] += np.arange(nodes)[:, None]
    return Layout(place, int(strides[-1]))


class SweepInput(NamedTuple):
    """Input for filling a table of S nodes and k tasks of at most Q automaton states, with F different weights.

    Attributes:
        order: (k, Q) int64, as in `Stages`.
        sizes: (k,) int64, as in `Product`.
        ends: (k, 2) int32, as in `Automata`.
        active: (k, Q) uint64, as bits, nodes whose label changes an automaton state.
        here: (k, Q, S) int64, what an automaton state adds to the index of a node's entry.
        onward: (k, Q, S) int64, the same for the state after reading the node's label.
        steps: (F, S, NODE_LIMIT) as the table, weighted least cost to a node from all others, twice `none` for no path.
        kind: (2^k,) int64, number of the weight for each set of satisfied tasks.
        none: stands for no path in the table.
    """

    order: np.ndarray
    sizes: np.ndarray
    ends: np.ndarray
    active: np.ndarray
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
        tasks: (k,) the tasks.
        factors: (2^k,) int64 >= 0, by which to multiply costs while a set of these tasks is satisfied.
        table: the table, of a type in `MOST`.
        layout: layout of the table; None for all entries.
        shift: number of low bits that are left out of costs.
        unit: divisor of weighted costs.
    """
    members, none = np.array(tasks, dtype=np.int64), MOST[table.dtype]
    layout = layout or full_layout(stages, tasks)
    different, kind = np.unique(factors, return_inverse=True)
    least = np.where(stages.graph.least < NO_EDGE, stages.graph.least >> shift, NO_EDGE)
    steps = np.stack([_weighted(least, factor, unit, none) for factor in different.tolist()])
    after = stages.after[members]
    place = np.ascontiguousarray(layout.place.transpose(1, 2, 0))
    given = SweepInput(
        order=stages.order[members],
        sizes=stages.product.sizes[members],
        ends=stages.product.tables.ends[members],
        active=bits_of(after != np.arange(after.shape[1])[None, :, None]),
        here=place,
        onward=np.ascontiguousarray(np.take_along_axis(place, after, axis=1)),
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
    tasks, nodes, none = sweep.sizes.shape[0], sweep.here.shape[2], sweep.none
    here, onward = np.zeros((tasks + 1, nodes), dtype=np.int64), np.zeros((tasks + 1, nodes), dtype=np.int64)
    stops, satisfied = np.zeros(tasks + 1, dtype=np.uint64), np.zeros(tasks + 1, dtype=np.int64)
    finished, ranks = np.ones(tasks + 1, dtype=np.bool_), np.zeros(tasks, dtype=np.int64)
    costs = np.zeros(sweep.steps.shape[2], dtype=table.dtype)
    changed = tasks
    while not stop[0]:
        for i in range(changed - 1, -1, -1):
            q = sweep.order[i, ranks[i]]
            if i > 0:
                for v in range(nodes):
                    here[i, v] = here[i + 1, v] + sweep.here[i, q, v]
                    onward[i, v] = onward[i + 1, v] + sweep.onward[i, q, v]
            stops[i] = stops[i + 1] | sweep.active[i, q]
            satisfied[i] = satisfied[i + 1] | ((q == sweep.ends[i, 0]) << i)
            finished[i] = finished[i + 1] and (q == sweep.ends[i, 0] or q == sweep.ends[i, 1])
        q = sweep.order[0, ranks[0]]
        _least_sums(sweep, sweep.kind[satisfied[0]], stops[0], onward[1], sweep.onward[0, q], table, costs)
        for v in range(nodes):
            entry = here[1, v] + sweep.here[0, q, v]
            if entry >= 0:
                cost = 0 if finished[0] else costs[v]
                table[entry] = none if cost >= 2 * none else min(cost, none - 1)
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
    """Write the least sum from every node, through one of the `stops`: nodes whose label changes some automaton.

    It is twice `none` without a path. After reading node v's label, the index of v's entry is others[v] + first[v].
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
