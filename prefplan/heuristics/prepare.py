"""Preprocessing of a product for the search: contraction of its graph, and bounds of cost and preference."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.backward import Backward
from prefplan.heuristics.lagrangian import NO_ENTRIES, Lagrangian, lagrangian_table, sparse_layout, weights_for
from prefplan.heuristics.landmarks import NO_LANDMARKS, Landmarks, landmarks
from prefplan.heuristics.pattern_database import (
    TableOf,
    Tables,
    growth_tables,
    joined_tables,
    scaled,
    sets_of_tasks,
)
from prefplan.heuristics.projected_backward import ProjectedBackward
from prefplan.heuristics.sweep import Stages
from prefplan.limits import check_limits, left
from prefplan.models.kernels import INFINITE
from prefplan.product.contraction import contract
from prefplan.product.product_automaton import Product
from prefplan.product.reduction import GeneratedProduct
from prefplan.product.space import space_of

COMBINATIONS_EACH = 500
"""Combinations of automaton states for each label that a search expands before it fills a Lagrangian table. Expanding
them takes a tenth as long as filling the table, which saves nine labels in ten or more: it pays to fill it early."""

ENTRIES_EACH = 1_400
"""Entries of the larger tables for each label that a search for a single plan expands before it fills them: expanding
these labels takes as long as filling the tables."""

LIKELY = 2
"""Most plans of a front cost at most this times the least cost still possible when a Lagrangian table is filled."""

ENTRY_BYTES, LAGRANGIAN_ENTRY_BYTES = 8, 2

TABLES_SHARE = 0.5
"""Part of the memory that tables may take."""


@dataclass(frozen=True)
class Options:
    """Options of a search; none of them changes the front.

    Attributes:
        heuristic: number of tasks in each set of the pattern databases (1: the paper's max-min heuristic, 0: no
            heuristic); None to choose.
        landmarks: whether to bound the cost-to-go by landmarks, too, in a search for a single plan.
        lagrangian: whether to bound cost and mu together, once a search for a front is long.
        preference_bound: whether to bound the growth of mu.
        contraction: whether to leave out states whose labels change no automaton, where at most 64 others remain.
        sweep: whether to fill tables in topological order, where automata allow it.
    """

    heuristic: int | None = None
    landmarks: bool = True
    lagrangian: bool = True
    preference_bound: bool = True
    contraction: bool = True
    sweep: bool = True


class Bounds(NamedTuple):
    """Lower bounds; `landmarks` and `lagrangian` are None unless the graph is contracted.

    Attributes:
        tables: bounds of the cost-to-go, and of the growth of preferences.
        landmarks: bound of the cost-to-go in a search for a single plan; NO_LANDMARKS for a front.
        lagrangian: bound of the cost-to-go if the growth of mu is limited; NO_ENTRIES until there is a table.
    """

    tables: Tables
    landmarks: Landmarks | None = None
    lagrangian: Lagrangian | None = None


class Prepared:
    """A product, made ready for a search.

    Attributes:
        product: what is searched.
        graph: the graph that it is searched over.
        space: both as arrays for the kernels.
        costs: for each cost, in units, (E,) int64 of the graph's edges, or (4 H H,) by price; the first counts actions
            in its low bits.
        bounds: lower bounds of the cost-to-go and of mu's growth.
        improved_after: number of expanded labels after which `improve` pays; infinite if it cannot improve the bounds.
    """

    def __init__(self, product: Product, options: Options, *, single: bool = False) -> None:
        """Contract the graph and build the bounds, for one cheapest plan or for the front.

        Raises:
            LimitError: a limit was reached, or the reverse graph and the tables of single tasks would not fit into the
                memory limit.
            OverflowError: 64 bits may not be enough.
        """
        self.product, self.options, problem = product, options, product.problem
        entries = product.graph.size * product.sizes
        needed = 48 * len(product.graph.targets) + 4 * entries.sum() + 120 * entries.max()
        check_limits(len(problem.cost_names) * needed)
        listed, several = not isinstance(product, GeneratedProduct), len(problem.cost_names) > 1
        # Contraction leaves out detours, which may be worth their cost if a contract is general.
        contraction = options.contraction and listed and not several and not problem.is_general
        self.graph = (contract(product) if contraction else None) or product.graph
        self.space = space_of(product.tables, self.graph, product.generated)
        self.costs = [self.graph.costs, *product.more_costs]
        self._require_64_bits()
        self.bounds: Bounds
        self.improved_after = math.inf
        self._improved: Callable[[int], Bounds]
        if isinstance(product, GeneratedProduct):
            projected = ProjectedBackward(product)
            sets = projected.groups if options.heuristic != 0 else []
            self.bounds = Bounds(self._tables([projected.with_costs(costs) for costs in self.costs], sets))
        else:
            self._look_back(single)

    def _require_64_bits(self) -> None:
        """Check that every price, and what one step adds to a cost or a preference, is below 2^60.

        Labels and tables hold no larger numbers either (a search that meets one stops), so that no sum overflows int64.

        Raises:
            OverflowError: one of them may be larger.
        """
        tables, nodes = self.product.tables, self.graph.size if self.graph.contracted else 1
        steps = [max(1, int(each.max(initial=0)) * nodes) for each in self.costs]
        skips = (dfa.skip or 0 for dfa in self.product.automata)
        price = max([1, *tables.relaxed[:, 1].tolist(), *skips, int(tables.tolls.max(initial=0))])
        growths = [Fraction(max(price, *steps))]
        for o in self.product.problem.objectives:
            growth = o.largest_rate * o.factor * steps[o.cost]
            growth += sum(o.violation_weights) * o.price_unit / o.unit * price
            growth += sum((max(term.weights) * o.factor for term in o.maxima), Fraction(0))
            growths.append(growth)
        if max(growths) >= INFINITE:
            raise OverflowError

    def _look_back(self, single: bool) -> None:
        """Build the bounds of a product over a graph, and set which are made later."""
        graphs = [self.graph, *(replace(self.graph, costs=costs, shift=0) for costs in self.costs[1:])]
        backwards = [Backward(self.product, graph, sweep=self.options.sweep) for graph in graphs]
        wanted, entries = self.options.heuristic, TABLES_SHARE * left()[1] / ENTRY_BYTES / len(self.costs)
        sets = sets_of_tasks(backwards[0], wanted, entries)
        self.bounds = Bounds(self._tables(backwards, sets))
        if self.graph.contracted:
            # A table of all tasks together needs no landmarks: it is exact, but for what `sweep` leaves out.
            are_exact = any(len(members) == len(self.product.sizes) for members in sets)
            marked = single and self.options.landmarks and not are_exact
            marks = landmarks(self.product, self.graph) if marked else NO_LANDMARKS
            self.bounds = self.bounds._replace(landmarks=marks, lagrangian=NO_ENTRIES)
        if single:
            deeper = sets_of_tasks(backwards[0], wanted, entries, deep=True)
            if deeper != sets:
                self.improved_after = sum(map(backwards[0].entries_of, deeper)) / ENTRIES_EACH
                self._improved = lambda _: self.bounds._replace(tables=self._tables(backwards, deeper))
            return
        measure = self.product.problem.measure
        stages = backwards[0].stages if self.options.lagrangian and self.product.starts else None
        if stages is not None and measure.bi_objective and (rates := measure.rates(measure.rate_terms)).any():
            self.improved_after = math.prod(self.product.sizes.tolist()) / COMBINATIONS_EACH
            self._improved = partial(self._with_lagrangian, stages, rates)

    def _tables(self, backwards: Sequence[Backward | ProjectedBackward], sets: Sequence[tuple[int, ...]]) -> Tables:
        """Return tables of the costs for some sets of tasks, and of how preferences grow."""
        costs = enumerate(backwards)
        tables = [TableOf(d, tasks, backward.cost_to_go(tasks)) for d, backward in costs for tasks in sets]
        for e, o in enumerate(self.product.problem.objectives, len(backwards)):
            if self.options.preference_bound and o.is_whole:
                tables += growth_tables(e, o, backwards[o.cost])
        return joined_tables(backwards, tables)

    def guided(self, weight: float) -> Prepared:
        """Return a copy that has the weighted sum of all tables in place of bounds.

        The larger the weight, the sooner best-first search has a plan, and the dearer the plan may be (weighted A*:
        I. Pohl, "Heuristic search viewed as path finding in a graph", 1970).
        """
        guided = copy(self)
        guided.bounds, guided.improved_after = Bounds(scaled(self.bounds.tables, weight)), math.inf
        return guided

    def improve(self, lowest: int) -> None:
        """Enlarge the bounds, for a search whose further plans cost at least `lowest`, without low bits."""
        self.improved_after, self.bounds = math.inf, self._improved(lowest)

    def _with_lagrangian(self, stages: Stages, rates: np.ndarray, lowest: int) -> Bounds:
        """Return the bounds with a Lagrangian table; without, if mu does not grow with cost or memory is too small."""
        weights, layout = weights_for(rates, LIKELY * lowest), sparse_layout(stages)
        if weights is None or layout.entries * LAGRANGIAN_ENTRY_BYTES > TABLES_SHARE * left()[1]:
            return self.bounds
        table = lagrangian_table(stages, layout, rates, weights)
        return self.bounds._replace(lagrangian=table)
