"""Exact cost-to-go for a few tasks at a time on T x A_K (equation 4 for one task).

The growth of mu can be minimised in the same way: an edge of cost w adds rate(S) w while the tasks in S are satisfied.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, partial

import numpy as np

from prefplan.heuristics.backward_dijkstra import (
    ReverseView,
    dijkstra,
    restricted,
    reverse_view,
)
from prefplan.heuristics.sweep import never_lose, stages_of, sweep
from prefplan.limits import check_limits, run_within_limits
from prefplan.models.kernels import INFINITE, UNREACHABLE
from prefplan.product.contraction import Graph
from prefplan.product.product_automaton import Product

WATCHED_ENTRIES = 100_000
"""Limits and Ctrl-C can stop the filling of tables of at least this many entries; others take less than 0.1 s."""


class Backward:
    """Cost-to-go tables of a product, filled backwards from where tasks are satisfied.

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

    def tabulate(self, tasks: Sequence[int], table: np.ndarray) -> None:
        """Fill a table with the least cost until all of some tasks are satisfied or dropped.

        Args:
            tasks: which tasks.
            table: (S * Q_1 * ... * Q_k,) int32, indexed as that of `cost_to_go`, UNREACHABLE where there is no path;
                costs are cut off at UNREACHABLE - 1.

        Raises:
            LimitError: a limit was reached.
        """
        members, factors = np.array(tasks, dtype=np.int64), np.ones(2 ** len(tasks), dtype=np.int64)
        if self.stages is not None and self.is_swept:
            self._fill(table, sweep(self.stages, members, factors, 0, table, UNREACHABLE))
        else:
            enter_costs(self.cost_to_go(members, factors), table)

    def cost_to_go(self, tasks: np.ndarray, factors: np.ndarray, *, shift: int = 0) -> np.ndarray:
        """Return the least weighted cost until all of some tasks are satisfied or dropped; a lower bound if swept.

        Args:
            tasks: (k,) int64, which tasks.
            factors: (2^k,) int64 >= 0, by which costs are multiplied while a set of these tasks is satisfied.
            shift: low bits that are left out of costs.

        Returns:
            (S * Q_1 * ... * Q_k,) int64, indexed node + S * (q_1 + Q_1 * (q_2 + ...)); INFINITE where there is no path.

        Raises:
            LimitError: a limit was reached.
        """
        entries = self.nodes * int(np.prod(self.sizes[tasks]))
        check_limits(8 * entries)
        table: np.ndarray = np.full(entries, INFINITE)
        if self.stages is not None and self.is_swept:
            self._fill(table, sweep(self.stages, tasks, factors, shift, table, INFINITE))
        else:
            edges = restricted(self.reverse, tasks)
            edges = edges._replace(costs=edges.costs >> shift)
            self._fill(table, partial(dijkstra, edges, tasks, factors, table))
        return table

    def _fill(self, table: np.ndarray, fill: Callable[[np.ndarray], None]) -> None:
        """Fill a table within the limits; `fill` takes the flag that stops it."""
        check_limits()
        if len(table) < WATCHED_ENTRIES:
            fill(np.zeros(1, dtype=np.bool_))
        else:
            run_within_limits(fill)

    def nodes_of(self, tasks: Sequence[int]) -> int:
        """Return the number of nodes in the tables of some tasks."""
        return self.nodes

    def entries_of(self, tasks: Sequence[int]) -> int:
        """Return about how many entries a table of some tasks has."""
        return self.nodes * math.prod(int(self.sizes[i]) for i in tasks)

    @cached_property
    def reverse(self) -> ReverseView:
        """The reverse of the product."""
        return reverse_view(self._product, self._graph)


def enter_costs(costs: np.ndarray, table: np.ndarray) -> None:
    """Enter (entries,) int64 costs-to-go into a table of 32 bits, cut off at UNREACHABLE - 1."""
    table[:] = np.where(costs < INFINITE, np.minimum(costs, UNREACHABLE - 1), UNREACHABLE)
