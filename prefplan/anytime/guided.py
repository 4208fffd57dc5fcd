"""Some plan soon, and better ones while there is time: beam search, or weighted A*, beside the exact search."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from prefplan.anytime.beam import beam_search
from prefplan.heuristics.preprocessing import Options, Prepared
from prefplan.limits import Limits
from prefplan.product.product_automaton import Product
from prefplan.search.bi_objective_search import BiObjectiveSearch
from prefplan.search.driver import Found, Search, in_units
from prefplan.search.labels import AT, END

WIDER = 4
"""Factor by which the width of beams grows, and the number of labels that the exact search expands between them."""

WEIGHTS = (1.0, 0.5, 0.45, 0.4, 0.35, 0.3)
"""Weights of the sum of the tasks' own costs-to-go. With 1 the search heads straight for a plan; with smaller ones it
finds better plans, since tasks share paths."""

MOST_EXPANDED = 200_000
"""Most labels expanded for each weight: about half a second."""

DRAFT_WIDTHS, DRAFT_WEIGHTS = (1, 30), (0.0, 0.1, 0.5, 2.0, 1e6)
"""Widths of the beams for a draft of a front, and relative weights of mu for each: all take 0.1 s for 10 tasks."""


class CheapestSearch:
    """Search for a cheapest plan that knows some plan early, and better ones before it ends.

    Attributes:
        incumbent: the cheapest plan known.
        least_cost: lower bound of every plan's cost, in units.
    """

    def __init__(self, product: Product, options: Options, limits: Limits, max_cost: float) -> None:
        """Take what to search, and `max_cost`, an inclusive bound of the total cost, in units."""
        self._product, self._options, self._limits = product, options, limits
        self._max_cost = max_cost
        self._beams: BiObjectiveSearch | None = None
        self.incumbent: Found | None = None
        self.least_cost = 0.0

    def search(self) -> Search:
        """Find a cheapest plan, then return a search for the least mu among the cheapest plans.

        If no cheapest plan was found, the search for one is returned.
        """
        if len(self._product.problem.tasks) >= self._options.guided_tasks:
            self._find_some_plan()
        prepared = Prepared(self._product, self._options, single=True, max_bytes=self._limits.bytes)
        alone = BiObjectiveSearch(prepared, max_cost=self._max_cost, cost_only=True)
        cheapest = self._cheapest(alone)
        if cheapest is None:
            return alone
        self.incumbent, self.least_cost = cheapest, cheapest.cost
        preferred = BiObjectiveSearch(prepared, max_mu=Fraction(cheapest.mu), max_cost=cheapest.cost)
        preferred.adopt_states(alone)
        return preferred

    def _find_some_plan(self) -> None:
        options = replace(self._options, heuristic=1, preference_bound=False)
        light = Prepared(self._product, options, single=True, max_bytes=self._limits.bytes)
        # The bound of the start is a lower bound of every plan's cost.
        self.least_cost = int(begun(light, cost_only=True).counters[AT.LOWEST]) >> self._product.shift
        if len(light.bounds.landmarks.price):
            self._beams = BiObjectiveSearch(light.for_beams(), cost_only=True)
            for width in self._options.beam_widths:
                self._follow_beam(width)
        if self.incumbent is None:
            for found in weighted(light, self._limits, self._max_cost):
                self._improve(found)

    def _follow_beam(self, width: int) -> bool:
        """Look for a cheaper plan in a beam of some width, and return whether there is one."""
        most = self._max_cost + 1 if self.incumbent is None else self.incumbent.cost
        found = None if self._beams is None else beam_search(self._beams, width, most)
        if found is not None:
            self._improve(found)
        return found is not None

    def _improve(self, found: Found) -> None:
        self.incumbent, self._max_cost = found, found.cost

    def _cheapest(self, alone: BiObjectiveSearch) -> Found | None:
        """Return a cheapest plan, None if there is none or a limit was reached: A*, and ever wider beams."""
        expanded, width = self._options.first_expanded, self._options.beam_widths[-1]
        while True:
            most = math.inf if self._beams is None else expanded
            found = next(alone.goals(self._limits, most_expanded=most), None)
            if found is not None or self._limits.ended or self._limits.complete_below == math.inf:
                return found
            self.least_cost = max(self.least_cost, self._limits.complete_below)
            if self.incumbent is not None and self.least_cost >= self.incumbent.cost:
                return self.incumbent
            width, expanded = width * WIDER, expanded * WIDER
            if self._follow_beam(width):
                alone.bound_cost(self._max_cost)


def prepare_draft(product: Product, options: Options, max_bytes: float) -> Prepared:
    """Return the preprocessing for a draft of a front: a table for each single task, which takes little time.

    Raises:
        LimitError: a limit was reached.
    """
    return Prepared(product, replace(options, heuristic=1), single=False, max_bytes=max_bytes)


def draft(light: Prepared, max_cost: float) -> Iterator[Found]:
    """Yield plans, most of them close to the front: cheap ones, preferred ones, and some in between.

    Args:
        light: from `prepare_draft`.
        max_cost: inclusive bound of the total cost, in units.

    Raises:
        LimitError: a limit was reached.
    """
    beams = BiObjectiveSearch(light.for_beams())
    for width in DRAFT_WIDTHS:
        ratio = 0.0
        for weight in DRAFT_WEIGHTS:
            found = beam_search(beams, width, max_cost + 1, weight * ratio)
            if found is None:
                break
            yield found
            mu = float(in_units(light.product, Fraction(found.mu)))
            if mu <= 0:
                break
            ratio = ratio or found.cost / mu


def weighted(prepared: Prepared, limits: Limits, max_cost: float) -> Iterator[Found]:
    """Yield plans by weighted A*, each cheaper than the one before.

    Args:
        prepared: what to search; the tables of the single tasks guide the search.
        limits: of time and memory.
        max_cost: inclusive bound of the total cost, in units.
    """
    # These searches prove no bound, so the caller's `complete_below` must not change.
    limits = replace(limits)
    for weight in WEIGHTS:
        search = BiObjectiveSearch(prepared.guided(weight), cost_only=True)
        found = next(search.goals(limits, most_expanded=MOST_EXPANDED), None)
        if limits.ended:
            return
        if found is not None and found.cost <= max_cost:
            max_cost = found.cost - 1
            yield found


def begun(prepared: Prepared, *, cost_only: bool = False) -> BiObjectiveSearch:
    """Return a search that has expanded the start and nothing else."""
    search = BiObjectiveSearch(prepared, cost_only=cost_only)
    # A label is put back until all tables have been looked up for it.
    while search.counters[AT.EXPANDED] == 0 and search._run(1) == END.PAUSED:
        pass
    return search
