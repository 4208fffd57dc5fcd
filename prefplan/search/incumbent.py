"""Some plan for a search that may be stopped before it has found one: weighted A* beside the exact search.

The exact search and weighted A* take turns until the exact search has a plan; each turn may expand twice as many labels
as the one before. A search that finds its first goal early, as most do, never looks for another plan.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from prefplan.front import Stats
from prefplan.heuristics.preprocessing import Prepared
from prefplan.limits import Limits
from prefplan.search.bi_objective_search import BiObjectiveSearch
from prefplan.search.driver import Found

FIRST_EXPANDED = 100_000
"""Labels expanded in the first turn, about 0.5 s; most plans of 14 tasks are found with fewer."""

WEIGHTS = (1.0, 0.5, 0.45, 0.4, 0.35, 0.3)
"""Weights of the sum of the tasks' own costs-to-go. With 1 the search heads straight for a plan; with smaller ones it
finds better plans, since tasks share paths."""


class AnytimeSearch:
    """A search that knows some plan early, which need not be a point of the front."""

    def __init__(self, search: BiObjectiveSearch) -> None:
        """Take the exact search."""
        self.search, self.product, self._work = search, search.product, Stats()

    @property
    def work(self) -> Stats:
        """The work so far, that of finding some plan included."""
        return self._work + self.search.work

    def goals(self, limits: Limits) -> Iterator[Found]:
        """Yield the goals; while there is none, plans that need not be best, each cheaper than the one before."""
        expanded, most, weights = FIRST_EXPANDED, self.search.max_cost, list(WEIGHTS)
        found, light = False, None
        while weights and not found:
            for goal in self.search.goals(limits, most_expanded=expanded):
                found = True
                yield goal
            if limits.ended or limits.complete_below == math.inf:
                return
            light = light or self._with_single_tasks(limits)
            while weights and not found:
                guided = BiObjectiveSearch(light.guided(weights[0]), max_cost=most, cost_only=True)
                # This search proves no bound.
                plan = next(guided.goals(replace(limits), most_expanded=expanded), None)
                self._work += guided.work
                if plan is None and guided.work.expanded >= expanded:
                    break
                weights.pop(0)
                if plan is not None:
                    most = plan.cost - 1
                    yield replace(plan, least_cost=limits.complete_below)
            expanded *= 2
        yield from self.search.goals(limits)

    def _with_single_tasks(self, limits: Limits) -> Prepared:
        """Return the preprocessing with tables of the single tasks alone."""
        options = replace(self.search.prepared.options, heuristic=1, preference_bound=False)
        return Prepared(self.product, options, single=False, max_bytes=limits.bytes)


class CheapestSearch:
    """Search for a plan of least cost (A*), then for one of least mu among those."""

    def __init__(self, prepared: Prepared, max_cost: float) -> None:
        """Take what to search, and an inclusive bound of the total cost, in units."""
        self.product, self._prepared, self._before = prepared.product, prepared, Stats()
        self._search: AnytimeSearch | BiObjectiveSearch = AnytimeSearch(
            BiObjectiveSearch(prepared, max_cost=max_cost, cost_only=True)
        )

    @property
    def work(self) -> Stats:
        """The work of both searches so far."""
        return self._before + self._search.work

    def goals(self, limits: Limits) -> Iterator[Found]:
        """Yield the plan, after plans that may be dearer or have a greater mu."""
        alone = self._search
        assert isinstance(alone, AnytimeSearch)
        for goal in alone.goals(limits):
            if goal.least_cost is not None:
                yield goal
                continue
            yield replace(goal, least_cost=goal.cost)
            preferred = BiObjectiveSearch(self._prepared, max_mu=Fraction(goal.mu), max_cost=goal.cost)
            preferred.adopt_states(alone.search)
            self._before, self._search = self.work, preferred
            yield from preferred.goals(limits)
