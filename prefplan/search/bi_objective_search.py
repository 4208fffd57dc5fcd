"""The search for one cost and one preference (`boa_star`), for measures whose label key is (g, mu)."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from prefplan.heuristics.preprocessing import Prepared
from prefplan.models.kernels import UNBOUNDED
from prefplan.search import boa_star
from prefplan.search.driver import Search, in_units
from prefplan.search.labels import AT, COL, NONE, growth_of


class BiObjectiveSearch(Search):
    """BOA*, for measures whose label key is (g, mu).

    Attributes:
        max_cost: inclusive bound of the total cost, in units.
    """

    def __init__(
        self,
        prepared: Prepared,
        *,
        max_mu: Fraction | None = None,
        max_cost: float = math.inf,
        cost_only: bool = False,
        single: bool = False,
    ) -> None:
        """Make the search ready.

        Args:
            prepared: what to search.
            max_mu: inclusive bound of mu, in the user's units.
            max_cost: inclusive bound of the total cost, in units.
            cost_only: find one cheapest goal, whatever its mu (A*).
            single: find the first goal of the front only.
        """
        self.max_cost = max_cost
        self._max_mu = UNBOUNDED if max_mu is None else math.floor(in_units(prepared.product, max_mu))
        self._cost_only, self.single = cost_only, single
        self._growth = growth_of(prepared.product)
        super().__init__(prepared, max_cost)

    def reset(self) -> None:
        """Forget everything but the bounds."""
        self.limits[0] = min(self._max_mu + 1, UNBOUNDED)
        super().reset()

    def _new_labels(self, count: int) -> boa_star.Labels:
        kinds = (np.int32, np.int64, np.int64, np.int32, np.int32)
        return boa_star.Labels(*(np.empty(count, kind) for kind in kinds))

    def _run(self, pops: int) -> int:
        wait = self.prepared.bounds_wait(cost_only=self._cost_only) - self.counters[AT.EXPANDED]
        if wait <= 0:
            if self._cost_only:
                self.prepared.deepen()
                self.reset()
            else:
                self.prepared.weigh()
        elif wait < pops:
            pops = math.ceil(wait)
        space, bounds, cost_only = self.prepared.space, self.prepared.bounds, self._cost_only
        memory = self.states, self.labels, self.queue, self.counters, self.limits, self.begin, self.buffer
        return int(boa_star.run(space, self._growth, bounds, *memory, cost_only, pops))

    def _objectives(self, label: int) -> tuple[Fraction, Fraction]:
        units, constant = self.product.units, self.product.problem.measure.constant
        return self._cost(label) * units.cost, int(self.labels.mu[label]) * units.mu + constant

    def adopt_states(self, other: Search) -> None:
        """Take over the product states, with their bounds, of another search of the same product."""
        self.states, self.counters[AT.ROWS] = other.states, other.counters[AT.ROWS]
        self.states.known[: other.counters[AT.ROWS], COL.HEAD] = NONE

    def _accept(self, label: int, objectives: tuple[Any, ...]) -> bool:
        if self._cost_only:
            self.counters[[AT.OPEN, AT.NEXT, AT.COUNT]] = 0
        elif self.single:
            self.limits[1] = self._up_to(self._cost(label))
        return True
