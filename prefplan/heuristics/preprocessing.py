"""Preprocessing of a product for the search: contraction of its graph, and bounds of cost and preference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from prefplan.errors import LimitError
from prefplan.heuristics.abstraction import Projected
from prefplan.heuristics.cost_to_go import Backward
from prefplan.heuristics.lagrangian import Lagrangian, entries_of, lagrangian_table, weights_for
from prefplan.heuristics.landmarks import Landmarks, landmarks
from prefplan.heuristics.pattern_database import (
    Patterns,
    count_entries,
    levels_of_sets,
    patterns,
    projected_patterns,
    scaled,
)
from prefplan.heuristics.preference_bound import Blocks, blocks, no_blocks
from prefplan.heuristics.projections import Projections
from prefplan.product.contraction import Graph, contract, whole_graph
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.kernels import INFINITE
from prefplan.product.product_automaton import Product
from prefplan.product.space import space_of

DEEP_ENTRIES, DEEP_STAGED_ENTRIES = 60_000_000, 120_000_000
"""Most entries of all tables that a long search for one plan may fill, without and with stages."""

UNSTAGED, MONOTONE, EXPANSION, EXPANSION_EACH = 10, 0.08, 100, 1.5
"""Times to fill an entry without stages, to fill one by `monotone_sweep`, and to expand a label, in all and for each
set of tasks, in units of the time to fill an entry with stages, about 20 ns. With `monotone_sweep`, an entry takes a
third of that unit; but a label takes four times as long as these say, because of landmarks."""

COMBINATION = 2
"""A sixth of the time to fill the entries of a combination of all automata's states (`lagrangian`), in these units."""

DEEPENING_EFFORT = 1.0
"""How long a search must have taken before larger tables are filled for it, in terms of the time that this takes."""

LAGRANGIAN_EFFORT = 0.1
"""How long a search must have taken before a Lagrangian table is filled for it, in terms of the time that this takes.
The table saves nine labels in ten or more, so that it pays to fill it early."""

LANDMARK_EXPANSIONS = 300
"""Labels that a search for a single plan expands before landmarks are looked for, which takes as long as these."""

ENTRY_BYTES, LAGRANGIAN_ENTRY_BYTES = 8, 2

TABLES_SHARE = 0.5
"""Part of the memory that tables may take."""


@dataclass(frozen=True)
class Options:
    """How to search; the front is the same for all of them.

    Attributes:
        heuristic: tasks in each set of the pattern databases (1 is the paper's max-min heuristic, 0 none at all); None
            to choose.
        landmarks: whether to bound the cost-to-go by landmarks, too, once a search for a single plan is long.
        lagrangian: whether to bound cost and mu together, once a search for a front is long.
        preference_bound: whether to bound the growth of mu.
        contraction: whether to leave out states whose labels change no automaton, where at most 64 others remain.
        sweep: whether to fill tables in topological order, where automata allow it.
        generated: whether states of large manipulation models are generated as the search meets them, where they can
            be; else they are listed before.
        compiled: whether to search in compiled code where 64 bits will do; else in Python's integers.
        apart_entries: entries of a projection's table, by an upper bound, up to which no locations are alike where
            costs are measured.
    """

    heuristic: int | None = None
    landmarks: bool = True
    lagrangian: bool = True
    preference_bound: bool = True
    contraction: bool = True
    sweep: bool = True
    generated: bool = True
    compiled: bool = True
    apart_entries: int = 400_000


class Bounds(NamedTuple):
    """Lower bounds.

    Attributes:
        patterns: of the cost-to-go.
        blocks: of mu's growth.
        projections: of the model, which the tables are over; None where its states are listed.
        landmarks: of the cost-to-go, if there are any yet.
        lagrangian: of the cost-to-go, where the growth of mu is limited, if there is a table yet.
    """

    patterns: Patterns
    blocks: Blocks
    projections: Projections | None = None
    landmarks: Landmarks | None = None
    lagrangian: Lagrangian | None = None


def bytes_to_prepare(product: Product) -> float:
    """Return about how much memory the reverse graph and the bounds of each task alone need."""
    largest = len(product.classes) * int(product.sizes.max())
    return 48 * len(product.targets) + 4 * len(product.classes) * int(product.sizes.sum()) + 2 * 60 * largest


class Prepared:
    """What all searches of a product share.

    Attributes:
        product: what is searched.
        graph: the graph that it is searched over.
        space: both as arrays for the kernels.
        bounds: of the cost-to-go and of mu's growth.
    """

    _backward: Backward | None = None
    _deeper: Sequence[list[tuple[int, ...]]] = ()
    _weighed = False
    _awaits_landmarks = False

    def __init__(self, product: Product, options: Options, *, single: bool, max_bytes: float = math.inf) -> None:
        """Contract the graph and build the bounds.

        Args:
            product: what is searched.
            options: how.
            single: whether one plan is wanted, not the front.
            max_bytes: memory that all is to fit into.

        Raises:
            OverflowError: if 64 bits may not be enough.
        """
        self.product, self.options = product, options
        if object in (product.costs.dtype, product.extra_price.dtype, product.tolls.dtype):
            raise OverflowError
        self._max_entries = TABLES_SHARE * max_bytes / ENTRY_BYTES
        # Under a general contract a detour through states that change nothing may be worth its cost.
        listed = not isinstance(product, GeneratedProduct)
        contraction = options.contraction and listed and product.problem.measure.contract != "general"
        self.graph = (contract(product) if contraction else None) or whole_graph(product)
        self.space = space_of(product, self.graph)
        require_64_bits(product, self.graph, [self.graph.costs])
        if isinstance(product, GeneratedProduct):
            self._project(product)
        else:
            self._look_back(single=single)

    def _look_back(self, *, single: bool) -> None:
        """Set the bounds of a product over a graph."""
        backward = self._backward = Backward(self.product, self.graph, sweep=self.options.sweep)
        wanted, most = self.options.heuristic, self._max_entries
        sets, *self._deeper = levels_of_sets(backward, wanted, single=single, max_entries=most)
        known = patterns(backward, sets)
        # Costs-to-go of all tasks together are exact.
        exact = any(len(members) == len(self.product.sizes) for members in sets)
        self._awaits_landmarks = self.options.landmarks and single and not exact
        self.bounds = Bounds(known, self._growths(backward, known))

    def _project(self, product: GeneratedProduct) -> None:
        """Set the bounds of a model whose states are generated."""
        backward = Projected(product, self.options.apart_entries)
        known = projected_patterns(backward, backward.groups() if self.options.heuristic != 0 else [])
        growths = self._growths(backward, known)
        self.bounds = Bounds(known, growths, backward.projections())

    def _growths(self, backward: Backward | Projected, known: Patterns) -> Blocks:
        measure = self.product.problem.measure
        if not (self.options.preference_bound and measure.bi_objective):
            return no_blocks(backward)
        return blocks(backward, measure, self.product.units.factor, known)

    def guided(self, weight: float) -> Prepared:
        """Return the same with the weighted sum of all tables in place of bounds.

        The larger the weight, the sooner best-first search has a plan, and the dearer the plan may be (weighted A*:
        I. Pohl, "Heuristic search viewed as path finding in a graph", 1970).
        """
        guided = copy(self)
        guided._deeper, guided._awaits_landmarks = (), False
        guided.bounds = self.bounds._replace(patterns=scaled(self.bounds.patterns, weight))
        return guided

    def tables_wait(self, *, cost_only: bool) -> float:
        """Return after how many expansions more tables are worth filling; infinite if there are to be none.

        Args:
            cost_only: for a search for the cheapest plan (`deepen`), else for one for a front (`weigh`).
        """
        return self._deepening if cost_only else self._weighing

    @property
    def _deepening(self) -> float:
        if self._awaits_landmarks:
            return LANDMARK_EXPANSIONS
        if self._backward is None or not self._deeper:
            return math.inf
        staged = self._backward.stages is not None
        each = MONOTONE if self._backward.monotone else 1 if staged else UNSTAGED
        entries = count_entries(self._backward, self._deeper[0])
        if entries > min(DEEP_STAGED_ENTRIES if staged else DEEP_ENTRIES, self._max_entries):
            return math.inf
        return DEEPENING_EFFORT * entries * each / self._expansion

    @property
    def _weighing(self) -> float:
        stages = self._backward.stages if self._backward else None
        wanted = self.options.lagrangian and self.product.problem.measure.bi_objective and self.product.rates.any()
        if stages is None or not wanted or self._weighed or not self.product.starts:
            return math.inf
        combinations = math.prod(self.product.sizes.tolist())
        most = self._max_entries * ENTRY_BYTES / LAGRANGIAN_ENTRY_BYTES
        if combinations > most or entries_of(stages) > most:
            return math.inf
        return LAGRANGIAN_EFFORT * combinations * COMBINATION / self._expansion

    @property
    def _expansion(self) -> float:
        """Time to expand a label, in units of the time to fill an entry with stages."""
        return EXPANSION + EXPANSION_EACH * len(self.bounds.patterns.base)

    def deepen(self) -> None:
        """Look for landmarks; the next time, fill tables of larger sets in place of the others."""
        if self._awaits_landmarks:
            self._awaits_landmarks = False
            self.bounds = self.bounds._replace(landmarks=landmarks(self.product, self.graph))
            return
        assert self._backward is not None
        sets, *self._deeper = self._deeper
        self.bounds = self.bounds._replace(patterns=patterns(self._backward, sets))

    def weigh(self) -> None:
        """Fill the Lagrangian table, unless memory does not suffice: the search may fit into it without."""
        assert self._backward is not None and self._backward.stages is not None
        self._weighed = True
        weights = weights_for(self.product.rates, self._likely_cost)
        if weights is None:
            return
        try:
            table = lagrangian_table(self._backward.stages, self.product.rates, self.graph.shift, weights)
        except LimitError as error:
            if error.ended != "memory":
                raise
        else:
            self.bounds = self.bounds._replace(lagrangian=table)

    @property
    def _likely_cost(self) -> int:
        """About what a plan costs, in units: the largest cost of finishing some tasks, and as much for all others."""
        known, tasks = self.bounds.patterns, len(self.product.sizes)
        automata = np.array(self.product.starts[0].automata)
        entries = known.base + self.graph.start + (known.sets.strides * automata[known.sets.tasks]).sum(axis=1)
        largest = int(known.table[entries].max(initial=1)) >> self.graph.shift
        return largest * max(1, tasks - known.sets.tasks.shape[1] + 1)


def require_64_bits(product: Product, graph: Graph, costs: Sequence[np.ndarray]) -> None:
    """Prove that what one step adds to a cost, or to a preference that counts in it, stays below 2^60.

    Labels and tables hold no larger numbers either (a search that meets one stops), so that no sum overflows int64.

    Args:
        product: what is searched.
        graph: the graph that it is searched over.
        costs: the first of the costs, or several, of its edges or actions.

    Raises:
        OverflowError: if that is not so.
    """
    nodes = graph.size if graph.contracted else 1
    steps = [max(1, int(each.max(initial=0)) * nodes) for each in costs]
    skips = (dfa.skip or 0 for dfa in product.automata)
    price = max([1, *product.extra_price.tolist(), *skips, int(product.tolls.max(initial=0))])
    growths = [Fraction(max(steps))]
    for o in product.problem.objectives:
        if o.cost < len(steps):
            growth = o.measure.largest_rate() * o.units.factor * steps[o.cost]
            growth += sum(o.measure.violation_weights) * o.units.price / o.units.mu * price
            growth += sum((max(term.weights) * o.units.factor for term in o.measure.maxima), Fraction(0))
            growths.append(growth)
    if max(growths) >= INFINITE:
        raise OverflowError
