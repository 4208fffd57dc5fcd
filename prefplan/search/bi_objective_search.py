"""The search for one cost and one preference (`boa_star`), for measures whose label key is (g, mu)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from prefplan.errors import LimitError
from prefplan.heuristics.lagrangian import least_sum, weights_along
from prefplan.heuristics.preprocessing import Prepared
from prefplan.limits import EXACT, Percent
from prefplan.product.kernels import UNBOUNDED
from prefplan.product.product_automaton import Product
from prefplan.search import boa_star
from prefplan.search.driver import Found, Search, in_units
from prefplan.search.labels import AT, COL, NONE


class BiObjectiveSearch(Search):
    """BOA*, for measures whose label key is (g, mu)."""

    def __init__(
        self,
        prepared: Prepared,
        *,
        max_mu: Fraction | None = None,
        max_cost: float = math.inf,
        cost_only: bool = False,
        first_only: bool = False,
        tolerance: Percent = EXACT,
        known: Sequence[Found] = (),
        drafted: Sequence[Found] = (),
    ) -> None:
        """Make the search ready.

        Args:
            prepared: what to search.
            max_mu: inclusive bound of mu, in the user's units.
            max_cost: inclusive bound of the total cost, in units.
            cost_only: find one cheapest goal, whatever its mu (A*).
            first_only: find the first goal of the front only.
            tolerance: percentage; goals are left out that a known or found one approximates within it.
            known: goals found by other searches; points that these approximate are left out.
            drafted: plans close to the front, by which Lagrangian tables are chosen.
        """
        self._max_mu = UNBOUNDED if max_mu is None else math.floor(in_units(prepared.product, max_mu))
        self._cost_only, self._first_only = cost_only, first_only or cost_only
        product = prepared.product
        self.tolerance = tolerance
        self._left_out = boa_star.Tolerance(
            tolerance.inflation,
            np.array([tolerance.least_cost(goal.cost) << product.shift for goal in known], dtype=np.int64),
            np.array([self._least_mu(product, goal) for goal in known], dtype=np.int64),
        )
        super().__init__(prepared, max_cost, tolerance)
        self._met = [self._worth(goal) for goal in (*known, *drafted)]
        self._reached: tuple[int, int] | None = None
        self._next_table = prepared.lagrangian_expansions if self._met else math.inf

    def _worth(self, goal: Found) -> tuple[int, int]:
        """Return cost and mu of a plan, in units."""
        return goal.cost, math.floor(in_units(self.prepared.product, Fraction(goal.mu)))

    def reset(self) -> None:
        """Forget everything but the bounds."""
        self.limits[0] = min(self._max_mu + 1, UNBOUNDED)
        super().reset()

    def _new_labels(self, count: int) -> boa_star.Labels:
        kinds = (np.int32, np.int64, np.int64, np.int32, np.int32)
        return boa_star.Labels(*(np.empty(count, kind) for kind in kinds))

    def _run(self, pops: int) -> int:
        if self._cost_only and self.counters[AT.EXPANDED] > self.prepared.deepening_expansions:
            self.prepared.deepen()
            self.reset()
        if not self._cost_only and self.counters[AT.EXPANDED] >= self._next_table:
            self._tabulate_ahead()
        return int(boa_star.run(self.memory, self.labels, self._cost_only, self._left_out, pops))

    def _tabulate_ahead(self) -> None:
        """Fill a Lagrangian table for the rest of the front, if it is known roughly where that ends."""
        begin, end = self._reached or min(self._met), self._likely_end()
        weights = None if end is None else weights_along(begin, end)
        if weights is not None and list(weights) not in self.prepared.bounds.lagrangian.weights.tolist():
            try:
                self.prepared.weigh(weights)
            except LimitError as error:
                if error.ended != "memory":
                    raise
                # The search may still fit into memory without the table.
                self._next_table = math.inf
                return
        self._next_table = self.counters[AT.EXPANDED] + self.prepared.lagrangian_expansions

    def _likely_end(self) -> tuple[int, int] | None:
        """Return an estimate of cost and mu at the end of the front, in units; None if there is nothing to go by."""
        tables, open_labels = self.prepared.bounds.lagrangian, self.queue.items[: self.counters[AT.OPEN]]
        labels = open_labels[self.labels.mu[open_labels] < self.limits[0]]
        if not len(tables.weights) or not len(labels):
            ahead = [plan for plan in self._met if plan[1] < self.limits[0]]
            return min(ahead, key=lambda plan: (plan[1], plan[0]), default=None)
        known, mus = self.states.known[self.labels.row[labels]], self.labels.mu[labels]
        view, costs = self.prepared.view, self.labels.cost[labels] >> self.product.shift
        sizes = self.product.sizes
        automata = known[:, COL.CODE, None] // view.strides[: len(sizes)] % sizes
        total = least_sum(tables, len(tables.weights) - 1, known[:, COL.CODE] % view.nodes, automata, costs, mus)
        if total is None:
            return None
        # A lower bound of the cost of a plan with the least mu that any may have.
        mu = int((mus + known[:, COL.GROWTH_BOUND]).min())
        return (total - int(tables.weights[-1, 1]) * mu) // int(tables.weights[-1, 0]), mu

    def _exact_mu(self, label: int) -> int:
        return int(self.labels.mu[label])

    def bound_cost(self, most: float) -> None:
        """Look only for goals that cost at most this much, in units."""
        self.limits[1] = min(self.limits[1], self._up_to(most))

    def adopt_states(self, other: Search) -> None:
        """Take over the product states, with their bounds, of another search of the same product."""
        self.states, self.counters[AT.ROWS] = other.states, other.counters[AT.ROWS]
        self.states.known[: other.counters[AT.ROWS], COL.HEAD] = NONE

    def _accept(self, goal: Found) -> bool:
        self._reached = goal.cost, int(self.limits[0])
        if self._cost_only:
            self.limits[1] = -1
        elif self._first_only:
            self.limits[1] = self._up_to(goal.cost)
        elif self.tolerance.value:
            self.limits[0] = min(self.limits[0], self._least_mu(self.product, goal))
        return True

    def left_out(self, cost: np.ndarray, mu: np.ndarray) -> np.ndarray:
        """Return (n,) whether labels with these bounds of cost (n,) and mu (n,) are pruned."""
        out: np.ndarray = mu >= self.limits[0]
        for least_cost, least_mu in zip(self._left_out.cost, self._left_out.mu, strict=True):
            out |= (cost >= least_cost) & (mu >= least_mu)
        return out

    def _least_mu(self, product: Product, goal: Found) -> int:
        """Return the least mu, in units, of goals that this one approximates."""
        return math.ceil(in_units(product, self.tolerance.least(Fraction(goal.mu))))
