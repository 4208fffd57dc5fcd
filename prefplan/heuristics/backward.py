"""Exact cost-to-go for a few tasks at a time on T x A_K, compiled (`cost_to_go` for one task).

The growth of mu can be minimised in the same way: an edge of cost w adds rate(S) w while the tasks in S are satisfied.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np

from prefplan.heuristics.backward_dijkstra import Incoming, dijkstra, incoming_edges, readings_of
from prefplan.heuristics.sweep import MOST, never_lose, stages_of, sweep
from prefplan.limits import check_limits, run_within_limits
from prefplan.models.kernels import INFINITE
from prefplan.product.contraction import Graph
from prefplan.product.product_automaton import Product

WATCHED_ENTRIES = 100_000
"""Limits and Ctrl-C can stop the filling of tables of at least this many entries; others take less than 0.1 s."""


class Backward:
    """Fills tables of a product's cost-to-go backwards from where tasks are satisfied.

    Attributes:
        nodes: number of nodes of the graph.
        sizes: (N,) int64, states of each automaton.
        shift: number of low bits of costs, which count actions and do not make mu grow.
        stages: the product, if its automata are acyclic up to self-loops, its graph is contracted, and it is to be
            swept; else None.
        is_swept: whether tables are swept: if, in addition, no label leads an automaton to a worse state.
    """

    def __init__(self, product: Product, graph: Graph, *, sweep: bool = True) -> None:
        """Take the product, and the graph that it is searched over; `sweep` as in `Options`."""
        self.nodes, self.sizes, self.shift = graph.size, product.sizes, graph.shift
        self._product, self._graph = product, graph
        self.stages = stages_of(product, graph) if sweep else None
        self.is_swept = self.stages is not None and never_lose(product)

    def cost_to_go(
        self,
        tasks: Sequence[int],
        factors: np.ndarray | None = None,
        *,
        shift: int = 0,
        dtype: type[np.signedinteger[Any]] = np.int64,
    ) -> np.ndarray:
        """Return a table of the least weighted cost until all of some tasks are satisfied or dropped.

        With unequal weights, sweeping gives a lower bound (`sweep`).

        Args:
            tasks: (k,) which tasks.
            factors: (2^k,) int64 >= 0, by which costs are multiplied while a set of these tasks is satisfied; None for
                ones.
            shift: low bits that are left out of costs.
            dtype: of the table, one in `MOST`, which says what stands for no path.

        Returns:
            (S * Q_1 * ... * Q_k,), indexed node + S * (q_1 + Q_1 * (q_2 + ...)).

        Raises:
            LimitError: a limit was reached.
        """
        entries, none = self.entries_of(tasks), MOST[np.dtype(dtype)]
        if factors is None:
            factors = np.ones(2 ** len(tasks), dtype=np.int64)
        check_limits(np.dtype(dtype).itemsize * entries)
        if self.stages is not None and self.is_swept:
            table = np.empty(entries, dtype=dtype)
            _run(sweep(self.stages, tasks, factors, table, shift=shift), entries)
            return table
        check_limits(8 * entries)
        readings, edges = readings_of(self._product, tasks), self._incoming
        costs = np.full((len(readings.finished), self.nodes), INFINITE)
        costs[readings.finished] = 0
        ends = np.flatnonzero((costs == 0) & (np.diff(edges.offsets) > 0))[::-1].copy()
        edges = edges._replace(costs=edges.costs >> shift)
        weights = factors[readings.satisfied]
        _run(partial(dijkstra, edges, self._graph.classes, readings, weights, ends, costs.ravel()), entries)
        return np.where(costs < INFINITE, np.minimum(costs, none - 1), none).astype(dtype).ravel()

    def growth(self, tasks: Sequence[int], factors: np.ndarray) -> np.ndarray:
        """Return the same as int32, UNREACHABLE where there is no path, of costs that do not count actions."""
        return self.cost_to_go(tasks, factors, shift=self.shift, dtype=np.int32)

    def nodes_of(self, tasks: Sequence[int]) -> int:
        """Return the number of nodes in the tables of some tasks."""
        return self.nodes

    def entries_of(self, tasks: Sequence[int]) -> int:
        """Return about how many entries a table of some tasks has."""
        return self.nodes * math.prod(int(self.sizes[i]) for i in tasks)

    @cached_property
    def _incoming(self) -> Incoming:
        return incoming_edges(self._graph)


def _run(fill: Callable[[np.ndarray], None], entries: int) -> None:
    """Fill a table within the limits, given what fills it until a flag is set."""
    check_limits()
    if entries < WATCHED_ENTRIES:
        fill(np.zeros(1, dtype=np.bool_))
    else:
        run_within_limits(fill)
