"""Approximate fronts of ever smaller tolerances, and what is proven of a front whose search was stopped.

With a tolerance of p percent a label is pruned if a known goal costs at most 1 + p/100 times the label's bound of cost,
and the same holds for mu. Labels are popped by cost + (1 + p/100) * bound of the cost-to-go (weighted A*, I. Pohl,
1970): no label that is open when a goal is popped leads to a goal that costs less than the popped one by more than p
percent. So every point of the exact front is within p percent of a goal found, or still ahead of an open label. Labels
of a product state are compared as in the exact search; those that A*pex would merge (H. Zhang et al., "A*pex: Efficient
approximate multi-objective search on graphs", ICAPS 2022) are few in products, where most states have one label.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from prefplan.front import Stats
from prefplan.heuristics.pattern_database import COST_BOUND
from prefplan.heuristics.preprocessing import Prepared
from prefplan.limits import Limits, Percent
from prefplan.product.kernels import INFINITE
from prefplan.search.bi_objective_search import BiObjectiveSearch
from prefplan.search.boa_star import DOMINATED
from prefplan.search.driver import Found
from prefplan.search.labels import AT, COL, NONE
from prefplan.search.vector_search import VectorSearch

PARTS_OF_PERCENT = 10
"""Proven percentages are rounded up to the next tenth."""

MARGIN = 1e-6
"""Excess over a whole number of tenths, in tenths, that is taken for a floating-point error."""


OpenSearch = BiObjectiveSearch | VectorSearch
"""Searches whose open labels bound what may still be found."""


class NarrowingSearch:
    """Searches for fronts within ever smaller percentages; each leaves out what earlier plans approximate."""

    def __init__(self, prepared: Prepared, tolerance: Percent, *, max_cost: float, drafted: Sequence[Found]) -> None:
        """Make the search ready; arguments are those of `BiObjectiveSearch`."""
        self._drafted = drafted
        self.prepared, self.product = prepared, prepared.product
        self._tolerance, self._max_cost = tolerance, max_cost
        self._known: list[Found] = []
        self._done = Stats()
        self._search: BiObjectiveSearch | None = None
        self._reached: Fraction | None = None

    def goals(self, limits: Limits) -> Iterator[Found]:
        """Yield goals, some of which may dominate earlier ones; stop early, with `limits.ended` set, at a limit."""
        for tolerance in self._tolerance.rounds:
            self._search = BiObjectiveSearch(
                self.prepared, max_cost=self._max_cost, tolerance=tolerance, known=self._known, drafted=self._drafted
            )
            known = list(self._known)
            for found in self._search.goals(limits):
                known.append(found)
                yield found
            self._known = known
            if limits.ended:
                return
            self._done, self._reached = self.work, tolerance.value

    @property
    def work(self) -> Stats:
        """The work of all searches so far; memory is that of the last."""
        if self._search is None:
            return self._done
        now, before = self._search.work, self._done
        return replace(
            now,
            states=max(now.states, before.states),
            expanded=now.expanded + before.expanded,
            generated=now.generated + before.generated,
        )

    def proven(self, points: Sequence[tuple[Fraction, Fraction]]) -> Fraction | None:
        """Return the tolerance that these points are proven to meet; see `proven_percent`."""
        known = [self._reached] if self._reached is not None else []
        if self._search is not None:
            now = proven_percent(self._search, points)
            known += [] if now is None else [now]
        return min(known, default=None)


def proven_percent(search: OpenSearch, points: Sequence[tuple[Fraction, Fraction]]) -> Fraction | None:
    """Return within what percentage of some points every point of the front is, as far as a stopped search proves it.

    Args:
        search: the search. What it pruned because of its last goal, which may be none of the points, counts as open.
        points: (cost, mu) of plans that were found, in the user's units.

    Returns:
        The smallest percentage that follows from the open labels, rounded up; None if no percentage does.
    """
    if not points:
        return None
    units = search.product.units
    corners = _open_corners(search)
    worst = np.full(len(corners), np.inf)
    for cost, mu in points:
        cost_ratio = _ratio(float(cost / units.cost), corners[:, 0])
        np.minimum(worst, np.maximum(cost_ratio, _ratio(float(mu / units.mu), corners[:, 1])), out=worst)
    gap = 100 * (float(worst.max(initial=1)) - 1)
    if not math.isfinite(gap):
        return None
    # The margin is far larger than the floating-point errors here.
    return max(search.tolerance.value, Fraction(max(0, math.ceil(PARTS_OF_PERCENT * gap - MARGIN)), PARTS_OF_PERCENT))


def _ratio(worth: float, bounds: np.ndarray) -> np.ndarray:
    """Return (n,) the factors by which a value may exceed lower bounds (n,); infinite for a bound of 0."""
    if worth <= 0:
        return np.ones(len(bounds))
    return np.divide(worth, bounds, out=np.full(len(bounds), np.inf), where=bounds > 0)


def _open_corners(search: OpenSearch) -> np.ndarray:
    """Return (n, 2) lower bounds of cost and mu, in units: every goal still to be found is bounded by one of them."""
    counters, labels, known = search.counters, search.labels, search.states.known
    ahead = search.queue.items[: counters[AT.OPEN]]
    if counters[AT.NEXT] < counters[AT.COUNT]:
        if counters[AT.PARENT] == NONE:
            return np.zeros((1, 2))
        ahead = np.append(ahead, counters[AT.PARENT])
    rows = labels.row[ahead]
    rest, mu = known[rows, COST_BOUND], labels.mu[ahead] + known[rows, COL.GROWTH_BOUND]
    cost = labels.cost[ahead] + rest
    kept = (rest < INFINITE) & (cost <= search.limits[1]) & (labels.mu[ahead] < DOMINATED) & ~search.left_out(cost, mu)
    shift, constant = search.product.shift, search.product.problem.measure.constant / search.product.units.mu
    corners = np.stack([cost[kept] >> shift, mu[kept] + float(constant)], axis=1).astype(np.float64)
    last = counters[AT.FOUND]
    if last == NONE:
        return corners
    goal = np.array([[labels.cost[last] >> shift, labels.mu[last] + float(constant)]])
    return np.concatenate([corners, goal / float(search.tolerance.factor)])
