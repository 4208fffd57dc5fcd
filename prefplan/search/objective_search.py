"""The search for any number of costs and preferences (`ltmoa_star`)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import chain, groupby
from operator import attrgetter, le
from typing import Any

import numpy as np

from prefplan.front import Stats
from prefplan.heuristics.objective_bounds import objective_bounds
from prefplan.heuristics.preprocessing import Options, Prepared, require_64_bits
from prefplan.limits import Limits
from prefplan.product.generated_product import GeneratedProduct, unit_costs
from prefplan.product.kernels import INFINITE, UNBOUNDED
from prefplan.product.product_automaton import Product
from prefplan.product.space import Space
from prefplan.product.starts import Start
from prefplan.search import ltmoa_star
from prefplan.search.driver import ROWS_AT_FIRST, Search
from prefplan.search.entries import BOUND, EntryMap, Paths
from prefplan.search.labels import AT, COL, States, growth_of
from prefplan.search.ltmoa_star import MORE_GOALS, MORE_VECTORS, Vector, Vectors
from prefplan.search.result import Goal

VECTORS_MADE_AT_FIRST = 2**14


class ObjectiveSearch(Search):
    """LTMOA* over all objectives of a problem."""

    labels: Paths
    pops = 2_000

    def __init__(
        self,
        product: Product,
        options: Options,
        *,
        bounds: Mapping[str, Fraction],
        first: str | None = None,
        max_bytes: float = math.inf,
    ) -> None:
        """Make the search ready.

        Args:
            product: what is searched.
            options: how to search.
            bounds: inclusive, of objectives by name, in the user's units.
            first: the objective whose least value is wanted; None for the whole front.
            max_bytes: memory that tables must fit into.

        Raises:
            OverflowError: 64 bits may not be enough.
        """
        self.problem, self.entry_map = product.problem, EntryMap.of(product.problem)
        several = self.entry_map.costs > 1
        contraction = options.contraction and not several
        plain = replace(options, heuristic=0, landmarks=False, preference_bound=False, contraction=contraction)
        self.prepared = Prepared(product, plain, max_bytes=max_bytes)
        self.product = product
        self.growth = growth_of(product)
        graph, space, columns = self.prepared.graph, self.prepared.space, self._columns()
        graphs = [graph, *(replace(graph, costs=column, shift=0) for column in columns[1:])]
        self.bounds = objective_bounds(product, graphs, self.entry_map.additive, options, max_bytes=max_bytes)
        self._bounds = bounds
        self._first = first if first is None or self._objective_entries()[first] is not None else None
        self.single = self._first is not None
        self._numbered = not graph.contracted
        require_64_bits(product, graph, columns)
        order = self._order()
        self.entries = self.entry_map.arrays(columns, order, self._compared(order), numbered=self._numbered)
        self.by_cost = int(self.entries.order[0]) == 0
        if self._numbered:
            # A successor then comes with the number of its edge, or the index of its costs, in place of a cost.
            numbers = np.arange(len(columns[0]), dtype=np.int64)
            self.prepared.space = _with_costs(space, np.where(columns[0] < 0, columns[0], numbers))
        self.limits = self._limits()
        self.scratch = Vector(
            np.zeros(self.entry_map.count, np.int64),
            np.zeros(self.entry_map.count, np.int64),
            np.zeros(self.entry_map.costs + len(self.entry_map.additive), np.int64),
        )
        self.reset()

    def _columns(self) -> list[np.ndarray]:
        """Return each of the costs, in units: (E,) int64 of the edges, or (4 H H,) by price."""
        product = self.product
        if isinstance(product, GeneratedProduct):
            found = [unit_costs(product.model, self.problem, d) for d in range(self.entry_map.costs)]
            if max(int(column.max()) for column in found) >= INFINITE:
                raise OverflowError
            return [column.astype(np.int64) for column in found]
        found = [self.prepared.graph.costs]
        for d, edges in enumerate(self.problem.system.listed.edge_costs[1:], start=1):
            unit = self.problem.cost_units[d]
            counts = edges.counts(unit)
            if max(counts.tolist(), default=0) >= INFINITE:
                raise OverflowError
            found.append(counts.astype(np.int64))
        return found

    def _objective_entries(self) -> dict[str, int | None]:
        """Return the entry that gives each objective, by name; None where no single entry does."""
        costs = dict(zip(self.problem.cost_names, range(self.entry_map.costs), strict=True))
        return costs | {o.name: self.entry_map.alone(o) for o in self.problem.objectives}

    def _order(self) -> list[int]:
        """Return the entries in the order of comparison: the wanted objective, other objectives, then the rest."""
        places = self._objective_entries()
        wanted = [] if self._first is None else [places[self._first]]
        ordered = chain(wanted, places.values(), range(self.entry_map.count))
        return list(dict.fromkeys(e for e in ordered if e is not None))

    def _compared(self, order: list[int]) -> list[int]:
        """Return the entries by which labels of a product state are compared; see `ltmoa_star`."""
        measures = [o.measure for o in self.problem.objectives]
        if self._first is None or not all(m.bi_objective and m.contract == "additive" for m in measures):
            return order[1:]
        places = self._objective_entries()
        bounded = {places[name] for name in self._bounds}
        return [entry for entry in order[1:] if entry in bounded]

    def _limits(self) -> np.ndarray:
        """Return (K,) inclusive limits of the entries; bounds on other objectives are checked when a goal is found."""
        limits = np.full(self.entry_map.count, UNBOUNDED)
        for name, entry in self._objective_entries().items():
            if entry is None or name not in self._bounds:
                continue
            if entry < self.entry_map.costs:
                most = math.floor(self._bounds[name] / self.problem.cost_units[entry])
                limits[entry] = self._up_to(most) if entry == 0 else min(most, UNBOUNDED)
            else:
                o = next(o for o in self.problem.objectives if o.name == name)
                limits[entry] = min(math.floor((self._bounds[name] - o.measure.constant) / o.units.mu), UNBOUNDED)
        return limits

    def _begin(self, start: Start) -> list[int]:
        return self.entry_map.begin(start, self.product.shift)

    def reset(self) -> None:
        """Forget everything but the bounds."""
        super().reset()
        counters = self.counters
        self.counters = np.zeros(len(AT) + 2, dtype=np.int64)
        self.counters[: len(AT)] = counters
        columns = BOUND + len(self.scratch.growth)
        self.states = States(np.empty((ROWS_AT_FIRST, columns), np.int64), self.states.slots)
        width = len(self.entries.compared)
        self.vectors = Vectors(
            np.empty((VECTORS_MADE_AT_FIRST, width), np.int64), np.empty((VECTORS_MADE_AT_FIRST, width), np.int64)
        )

    def _new_labels(self, count: int) -> Paths:
        rows, parents, steps = (np.empty(count, np.int32) for _ in range(3))
        return Paths(rows, parents, steps, np.empty((count, self.entry_map.count), np.int64))

    def _run(self, pops: int) -> int:
        space, entries, bounds = self.prepared.space, self.entries, self.bounds
        memory = (self.states, self.labels, self.queue, self.counters, self.limits, self.begin, self.buffer)
        return int(ltmoa_star.run(space, entries, bounds, *memory, self.vectors, self.scratch, pops))

    @property
    def work(self) -> Stats:
        """The work so far."""
        stats = super().work
        held = stats.bytes + sum(array.nbytes for array in self.vectors)
        return Stats(stats.states, stats.expanded, stats.generated, held)

    def _grow(self, end: int, limits: Limits) -> bool:
        if end not in (MORE_VECTORS, MORE_GOALS):
            return super()._grow(end, limits)
        vectors = self.vectors[end - MORE_VECTORS]
        if max(self.work.bytes, limits.bytes_taken) + 2 * vectors.nbytes > limits.bytes:
            return False
        longer = np.concatenate([vectors, np.empty_like(vectors)])
        self.vectors = self.vectors._replace(**{Vectors._fields[end - MORE_VECTORS]: longer})
        return True

    def _edges(self, labels: np.ndarray) -> np.ndarray | None:
        return self.labels.step[labels].astype(np.int64) if self._numbered else None

    def _costs(self, labels: np.ndarray) -> np.ndarray:
        return self.labels.key[labels, 0]

    def _start_of(self, label: int, automata: tuple[int, ...]) -> Start:
        return self._starts[self.labels.step[label]]

    def _objectives(self, label: int) -> tuple[Any, ...]:
        """Return the exact objectives of a goal, in the user's units."""
        key = self.labels.key[label].tolist()
        spent = [key[0] >> self.product.shift, *key[1 : self.entry_map.costs]]
        known = self.states.known[self.labels.row[label]]
        for c, (cost, i) in enumerate(self.entry_map.frozen):
            if not known[COL.SATISFIED] >> i & 1:
                key[len(key) - len(self.entry_map.paid) - len(self.entry_map.frozen) + c] = spent[cost]
        values = [self.entry_map.value(o, key, spent) for o in self.problem.objectives]
        return (*(units * count for units, count in zip(self.problem.cost_units, spent, strict=True)), *values)

    def _accept(self, label: int, objectives: tuple[Any, ...]) -> bool:
        values = dict(zip(self.problem.objective_names, objectives, strict=True))
        if any(values[name] > bound for name, bound in self._bounds.items()):
            return False
        if self._first is not None:
            entry = int(self.entries.order[0])
            self.limits[entry] = self._up_to(self._cost(label)) if entry == 0 else int(self.labels.key[label, entry])
        return True

    def _points(self, goals: list[Goal]) -> list[Goal]:
        # What a cheaper goal dominates is pruned by the kernel, but for values that only a goal's label shows.
        pruned = all(o.measure.bi_objective for o in self.problem.objectives)
        if pruned and self.product.shift == 0:
            # Then the first objective has no low bits, and each goal was popped before all that it might dominate.
            return goals
        ordered = sorted(goals, key=attrgetter("objectives"))
        points: list[Goal] = []
        for _, group in groupby(ordered, key=lambda goal: goal.cost if pruned else 0):
            kept: list[Goal] = []
            for goal in group:
                if not any(all(map(le, other.objectives, goal.objectives)) for other in kept):
                    kept.append(goal)
            points += kept
        return points


def _with_costs(space: Space, costs: np.ndarray) -> Space:
    """Return a product in which edges, or actions where states are generated, have other costs."""
    if space.generated is not None:
        return space._replace(generated=space.generated._replace(costs=costs))
    assert space.edges is not None
    return space._replace(edges=space.edges._replace(costs=costs))
