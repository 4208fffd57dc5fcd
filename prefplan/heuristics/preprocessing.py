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
from prefplan.heuristics.pattern_database import Patterns, patterns, projected_patterns, scaled, sets_of_tasks
from prefplan.heuristics.preference_bound import Blocks, blocks, no_blocks
from prefplan.heuristics.projections import Projections
from prefplan.models.kernels import INFINITE
from prefplan.product.contraction import Graph, contract, whole_graph
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.product_automaton import Product
from prefplan.product.space import space_of

COMBINATIONS_EACH = 500
"""A Lagrangian table is filled once a search has expanded a label for so many combinations of automaton states, which
takes a tenth as long as filling the table: it saves nine labels in ten or more, so that it pays to fill it early."""

ENTRIES_EACH = 1_400
"""Larger tables are filled once a search for a single plan has expanded a label for so many entries, which takes as
long as filling them."""

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
    """

    heuristic: int | None = None
    landmarks: bool = True
    lagrangian: bool = True
    preference_bound: bool = True
    contraction: bool = True
    sweep: bool = True
    generated: bool = True
    compiled: bool = True


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
    _weighed = False
    _awaits_landmarks = False
    _deeper: Sequence[tuple[int, ...]] = ()

    def __init__(self, product: Product, options: Options, *, max_bytes: float = math.inf) -> None:
        """Contract the graph and build the bounds.

        Args:
            product: what is searched.
            options: how.
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
            self._look_back()

    def _look_back(self) -> None:
        """Set the bounds of a product over a graph."""
        backward = self._backward = Backward(self.product, self.graph, sweep=self.options.sweep)
        sets = sets_of_tasks(backward, self.options.heuristic, self._max_entries)
        known = patterns(backward, sets)
        deeper = sets_of_tasks(backward, self.options.heuristic, self._max_entries, deep=True)
        self._deeper = deeper if deeper != sets else ()
        # Costs-to-go of all tasks together are exact.
        exact = any(len(members) == len(self.product.sizes) for members in sets)
        self._awaits_landmarks = self.options.landmarks and not exact
        self.bounds = Bounds(known, self._growths(backward, known))

    def _project(self, product: GeneratedProduct) -> None:
        """Set the bounds of a model whose states are generated."""
        backward = Projected(product)
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

    def bounds_wait(self, *, cost_only: bool) -> float:
        """Return after how many expansions further bounds are worth making; infinite if there are to be none.

        Args:
            cost_only: for a search for the cheapest plan (`deepen`), else for one for a front (`weigh`).
        """
        if not cost_only:
            return self._weighing
        if self._awaits_landmarks:
            return LANDMARK_EXPANSIONS
        if self._backward is None or not self._deeper:
            return math.inf
        return sum(map(self._backward.entries_of, self._deeper)) / ENTRIES_EACH

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
        return combinations / COMBINATIONS_EACH

    def deepen(self) -> None:
        """Bound the cost-to-go by landmarks, too; the next time, by tables of larger sets."""
        if self._awaits_landmarks:
            self._awaits_landmarks = False
            self.bounds = self.bounds._replace(landmarks=landmarks(self.product, self.graph))
            return
        assert self._backward is not None
        self.bounds = self.bounds._replace(patterns=patterns(self._backward, self._deeper))
        self._deeper = ()

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
