"""Cost-to-go tables for a few tasks K at a time on T x A_K, in compiled code: by `sweep` or Dijkstra's algorithm.

Tables of mu's least growth are filled likewise: an edge of cost w adds rate(S) w while S is the set of satisfied tasks.
"""

import math
from collections.abc import Sequence
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.sweep import stages_of, sweep
from prefplan.limits import check_limits, run_within_limits
from prefplan.models.kernels import UNREACHABLE, kernel
from prefplan.product.heap import heap_pop, heap_push
from prefplan.product.product_automaton import Product
from prefplan.product.space import Graph


class Incoming(NamedTuple):
    """The edges of S nodes by target: offsets: (S + 1,) int64, sources: (E,) int32, costs: (E,) int64."""

    offsets: np.ndarray
    sources: np.ndarray
    costs: np.ndarray


class Backward:
    """Fills cost-to-go tables of a product, backwards from the states in which tasks are satisfied.

    Attributes:
        sizes: (N,) int64, number of states of each automaton.
        stages: the product as input of `sweep`; None if it cannot be swept (`stages_of`), or is not to be.
        is_swept: whether tables are swept: `stages` exist, and no label makes a task impossible to satisfy.
    """

    def __init__(self, product: Product, graph: Graph, *, sweep: bool = True) -> None:
        """Take the product, and the graph that it is searched over; `sweep` as in `Options`."""
        self.sizes, self._product, self._graph = product.sizes, product, graph
        self.stages = stages_of(product, graph) if sweep else None
        self.is_swept = self.stages is not None and self.stages.is_safe

    def cost_to_go(self, tasks: Sequence[int], factors: np.ndarray | None = None) -> np.ndarray:
        """Return a table of the least cost, or growth of mu, until all of some tasks are satisfied or skipped.

        A swept table is a lower bound, not exact, if factors differ or a label makes an automaton's state worse.

        Args:
            tasks: (k,) the tasks.
            factors: (2^k,) int64 >= 0, growth of mu per unit of cost, by set of satisfied tasks; None for a table of
                costs, with their low bits.

        Returns:
            (S * Q_1 * ... * Q_k,) int32, indexed node + S * (q_1 + Q_1 * (q_2 + ...)); UNREACHABLE if there is no path.
            Larger costs are cut off at UNREACHABLE - 1.

        Raises:
            LimitError: a limit was reached.
        """
        entries, shift = self.entries_of(tasks), 0 if factors is None else self._graph.shift
        if factors is None:
            factors = np.ones(2 ** len(tasks), dtype=np.int64)
        check_limits(4 * entries)
        table = np.empty(entries, dtype=np.int32)
        if self.stages is not None and self.is_swept:
            run_within_limits(sweep(self.stages, tasks, factors, table, shift=shift), entries)
            return table
        readings, edges = readings_of(self._product, tasks), self._incoming
        for row, is_finished in zip(table.reshape(-1, self._graph.size), readings.finished, strict=True):
            row[:] = 0 if is_finished else UNREACHABLE
            check_limits()
        nodes, rows = np.flatnonzero(np.diff(edges.offsets)), np.flatnonzero(readings.finished)
        ends = (rows[:, None] * self._graph.size + nodes).ravel()[::-1].copy()
        edges = edges._replace(costs=edges.costs >> shift) if shift else edges
        arrays = self._graph.classes, readings, factors[readings.satisfied], ends, table
        run_within_limits(partial(dijkstra, edges, *arrays), entries)
        return table

    def entries_of(self, tasks: Sequence[int]) -> int:
        """Return the number of entries of a table for some tasks."""
        return self._graph.size * math.prod(int(self.sizes[i]) for i in tasks)

    @cached_property
    def _incoming(self) -> Incoming:
        graph = self._graph
        edges = Incoming(np.zeros_like(graph.offsets), np.empty_like(graph.targets), np.empty_like(graph.costs))
        run_within_limits(partial(turn, graph.offsets, graph.targets, graph.costs, edges), len(graph.targets))
        return edges


class Readings(NamedTuple):
    """The joint transitions of the automata of k tasks, over the J = Q_1 ... Q_k combinations q_1 + Q_1 (q_2 + ...).

    Attributes:
        first: (J * C + 1,) int64, offsets into `before` by combination and label class.
        before: (X,) int64, `before[first[j C + c] : first[j C + c + 1]]`: the predecessors of j on label class c.
        satisfied: (J,) int64, tasks satisfied in each combination, as bits.
        finished: (J,) bool, whether all tasks are satisfied or skipped.
    """

    first: np.ndarray
    before: np.ndarray
    satisfied: np.ndarray
    finished: np.ndarray


def readings_of(product: Product, tasks: Sequence[int]) -> Readings:
    """Return the joint transitions of some tasks' automata."""
    classes = product.tables.delta.shape[2]
    label, before, after = np.arange(classes), np.zeros(classes, dtype=np.int64), np.zeros(classes, dtype=np.int64)
    satisfied, finished = np.zeros(1, dtype=np.int64), np.ones(1, dtype=bool)
    for j, i in enumerate(tasks):
        read, q, onto = steps_of(product, i)
        counts = np.bincount(read, minlength=classes)
        # Join every step so far with every step of this automaton on the same label class.
        times = counts[label]
        joined = np.repeat(np.arange(len(label)), times)
        number = np.arange(len(joined)) - np.repeat(np.cumsum(times) - times, times)
        label, stride = label[joined], len(finished)
        step = (np.cumsum(counts) - counts)[label] + number
        before, after = before[joined] + stride * q[step], after[joined] + stride * onto[step]
        states, ends = np.arange(product.sizes[i]), product.tables.ends[i]
        satisfied = (((states == ends[0]) << j)[:, None] | satisfied).ravel()
        finished = (np.isin(states, ends)[:, None] & finished).ravel()
    cell = after * classes + label
    order = np.argsort(cell, kind="stable")
    first = np.searchsorted(cell[order], np.arange(len(finished) * classes + 1)).astype(np.int64)
    return Readings(first, before[order], satisfied, finished)


def steps_of(product: Product, i: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return all steps of an automaton, relaxed ones too, by label class: (X,) class, state before and state after."""
    tables, classes, size = product.tables, product.tables.delta.shape[2], int(product.sizes[i])
    first = tables.first_relaxed[i, :size]
    q, label = np.divmod(np.arange(size * classes), classes)
    relaxed = np.repeat(np.arange(size * classes), np.diff(first, axis=1).ravel())
    read, before = np.concatenate([label, label[relaxed]]), np.concatenate([q, q[relaxed]])
    after = np.concatenate([tables.delta[i, :size].ravel(), tables.relaxed[first[0, 0] : first[-1, -1], 0]])
    order = np.argsort(read, kind="stable")
    return read[order], before[order], after[order].astype(np.int64)


@kernel
def turn(offsets: np.ndarray, targets: np.ndarray, costs: np.ndarray, incoming: Incoming, stop: np.ndarray) -> None:
    """Write the edges of a graph to `incoming`, by target and then by source; return early once `stop` is set."""
    for target in targets:
        incoming.offsets[target + 1] += 1
    for node in range(offsets.shape[0] - 1):
        incoming.offsets[node + 1] += incoming.offsets[node]
    entered = incoming.offsets[:-1].copy()
    for node in range(offsets.shape[0] - 1):
        if stop[0]:
            return
        for edge in range(offsets[node], offsets[node + 1]):
            place = entered[targets[edge]]
            entered[targets[edge]] += 1
            incoming.sources[place], incoming.costs[place] = node, costs[edge]


@kernel
def dijkstra(
    edges: Incoming,
    classes: np.ndarray,
    readings: Readings,
    factors: np.ndarray,
    items: np.ndarray,
    table: np.ndarray,
    stop: np.ndarray,
) -> None:
    """Fill a table with least weighted costs (Dijkstra's algorithm); return early once `stop` is set.

    Costs of UNREACHABLE and more are entered as UNREACHABLE - 1, still a lower bound. Cells whose node has no incoming
    edge have no predecessors, and need not enter the open list.

    Node v has label class classes[v]; a step from combination j costs factors[j] times its edge. The `table` (S J,) is
    0 where all tasks are finished, else UNREACHABLE; `items` are its cells of cost 0 with predecessors, the last first.
    """
    nodes, labels = classes.shape[0], (readings.first.shape[0] - 1) // readings.finished.shape[0]
    keys, count = np.zeros(items.shape[0], dtype=np.int64), items.shape[0]
    while count > 0 and not stop[0]:
        cost, cell = keys[0], items[0]
        count = heap_pop(keys, items, count, None)
        if table[cell] < cost:
            continue
        node = cell % nodes
        read = cell // nodes * labels + classes[node]
        for reading in range(readings.first[read], readings.first[read + 1]):
            before = readings.before[reading]
            for edge in range(edges.offsets[node], edges.offsets[node + 1]):
                source = edges.sources[edge]
                new, there = min(cost + factors[before] * edges.costs[edge], UNREACHABLE - 1), source + nodes * before
                if new < table[there]:
                    table[there] = new
                    if edges.offsets[source] < edges.offsets[source + 1]:
                        if count == keys.shape[0]:
                            keys, items = _twice(keys), _twice(items)
                        count = heap_push(keys, items, count, new, there, None)


@kernel
def _twice(array: np.ndarray) -> np.ndarray:
    longer: np.ndarray = np.empty(2 * array.shape[0], dtype=np.int64)
    for k in range(array.shape[0]):
        longer[k] = array[k]
    return longer
