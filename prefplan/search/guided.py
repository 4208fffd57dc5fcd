"""Some plan soon, and better ones while there is time: weighted A*, before the exact search."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from prefplan.heuristics.preprocessing import Prepared
from prefplan.limits import Limits
from prefplan.search.driver import BiObjectiveSearch, Found
from prefplan.search.labels import EXPANDED, LOWEST, PAUSED

WEIGHTS = (1.0, 0.5, 0.45, 0.4, 0.35, 0.3)
"""Weights of the sum of what is left of each task. With 1 the search heads straight for a plan; with less it finds
better ones, as tasks share their ways (10 x 10 grid, 12 tasks: 115, 106, 82 for 1, 0.5, 0.4)."""

MOST_EXPANDED = 200_000
"""Labels that each weight may take: about half a second."""


def plans_soon(prepared: Prepared, limits: Limits, max_cost: float) -> Iterator[Found]:
    """Yield plans, each cheaper than the one before.

    Args:
        prepared: what to search; each task's own table guides the search.
        limits: of time and memory.
        max_cost: inclusive bound of the total cost, in units.
    """
    best = math.inf
    # How far these searches get proves nothing.
    limits = replace(limits)
    for weight in WEIGHTS:
        search = BiObjectiveSearch(prepared.guided(weight), cost_only=True)
        found = next(search.goals(limits, most_expanded=MOST_EXPANDED), None)
        if limits.ended:
            return
        if found is not None and found.cost < best and found.cost <= max_cost:
            best = found.cost
            yield found


def least_estimate(prepared: Prepared) -> int:
    """Return the bound of the start: no plan costs less, in units."""
    search = BiObjectiveSearch(prepared, cost_only=True)
    # A label is put back until all tables have been looked up for it.
    while search.counters[EXPANDED] == 0 and search._run(1) == PAUSED:
        pass
    return int(search.counters[LOWEST]) >> prepared.product.shift
