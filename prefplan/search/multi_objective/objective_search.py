"""The search for any number of costs and preferences (`ltmoa_star`)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from operator import attrgetter, le
from typing import Any

import numpy as np

from prefplan.front import Stats
from prefplan.heuristics.prepare import Options, Prepared
from prefplan.limits import Limits
from prefplan.models.kernels import UNBOUNDED
from prefplan.product.product_automaton import Product
from prefplan.product.space import Space
from prefplan.product.starts import Start
from prefplan.search.driver import ROWS_AT_FIRST, Search
from prefplan.search.labels import AT, COL, END, States
from prefplan.search.multi_objective import ltmoa_star
from prefplan.search.multi_objective.entries import BOUND, KeyedLabels, Vector
from prefplan.search.multi_objective.entry_map import EntryMap
from prefplan.search.multi_objective.ltmoa_star import MORE_GOALS, MORE_VECTORS, Vectors
from prefplan.search.multi_objective.valuations import FALL, Valuations, ordered_number
from prefplan.search.result import Goal

VECTORS_MADE_AT_FIRST = 2**14


class ObjectiveSearch(Search):
    """LTMOA* over all objectives of a problem."""

    labels: KeyedLabels
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
        self.product, self.problem = product, product.problem
        self.entry_map = EntryMap.of(product)
        self._valuations = Valuations(self.entry_map)
        self.single = first is not None
        self.prepared = Prepared(product, options, max_bytes=max_bytes)
        graph, columns = self.prepared.graph, self.prepared.costs
        self._bounds = bounds
        self._numbered = not graph.contracted
        names = self.problem.objective_names
        order = sorted(range(len(names)), key=lambda o: names[o] != first)
        compared = self._compared(order)
        self.entries = self.entry_map.arrays(columns if self._numbered else [], order, compared)
        self.by_cost = order[0] == 0
        if self._numbered:
            # A successor then comes with the number of its edge, or the index of its costs, in place of a cost.
            numbers = np.where(columns[0] < 0, columns[0], np.arange(len(columns[0]), dtype=np.int64))
            self.prepared.space = _with_costs(self.prepared.space, numbers)
        self.limits = np.array([self._limit(names[o], o) for o in order])
        widths = self.entry_map.size, len(order), len(compared)
        self.scratch = Vector(*(np.zeros(width, np.int64) for width in widths))
        self.reset()

    def _compared(self, order: list[int]) -> list[int]:
        """Return the entries by which labels of a product state are compared; see `ltmoa_star`."""
        measures = [o.measure for o in self.problem.objectives]
        names = self.problem.objective_names
        if self.single and all(m.bi_objective and m.contract == "additive" for m in measures):
            return [o for o in order[1:] if names[o] in self._bounds]
        return [entry for entry in self.entry_map.compared if entry != order[0]]

    def _limit(self, name: str, o: int) -> int:
        """Return the inclusive limit of an objective, in units; a rounded value is checked when a goal is found."""
        if name not in self._bounds:
            return UNBOUNDED
        bound = self._bounds[name]
        if o < self.entry_map.costs:
            most = math.floor(bound / self.problem.cost_units[o])
            return self._up_to(most) if o == 0 else min(most, UNBOUNDED)
        objective = self.problem.objectives[o - self.entry_map.costs]
        rest = bound - objective.measure.constant
        if objective.measure.is_whole:
            return min(math.floor(rest / objective.units.mu), UNBOUNDED)
        return ordered_number(float(rest)) + FALL

    def _begin(self, start: Start) -> list[int]:
        return self.entry_map.begin(start, self.product.shift)

    def reset(self) -> None:
        """Forget everything but the bounds."""
        super().reset()
        counters = self.counters
        self.counters = np.zeros(len(AT) + 2, dtype=np.int64)
        self.counters[: len(AT)] = counters
        columns = BOUND + len(self.scratch.bound)
        self.states = States(np.empty((ROWS_AT_FIRST, columns), np.int64), self.states.slots)
        widths = len(self.entries.compared), len(self.scratch.bound) - 1
        self.vectors = Vectors(*(np.empty((VECTORS_MADE_AT_FIRST, width), np.int64) for width in widths))

    def _new_labels(self, count: int) -> KeyedLabels:
        rows, parents, steps = (np.empty(count, np.int32) for _ in range(3))
        return KeyedLabels(rows, parents, steps, np.empty((count, self.entry_map.size), np.int64))

    def _run(self, pops: int) -> int:
        what = self.prepared.space, self.entries, self._valuations.program, self.prepared.bounds
        end = int(ltmoa_star.run(*what, self.memory, self.vectors, self.scratch, pops))
        if end == END.FALLS:
            self._valuations.require_rise(self._objectives(int(self.counters[AT.PARENT])))
            raise OverflowError
        return end

    def _too_large(self) -> None:
        self._valuations.require_values()

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
        entries = self.labels.key[label].tolist()
        entries[0] >>= self.product.shift
        satisfied = int(self.states.known[self.labels.row[label], COL.SATISFIED])
        for entry, (cost, i) in enumerate(self.entry_map.frozen, self.entry_map.first_frozen):
            if not satisfied >> i & 1:
                entries[entry] = entries[cost]
        return self.entry_map.objectives(entries)

    def _accept(self, label: int, objectives: tuple[Any, ...]) -> bool:
        values = dict(zip(self.problem.objective_names, objectives, strict=True))
        if any(values[name] > bound for name, bound in self._bounds.items()):
            return False
        if self.single:
            least = int(self.labels.key[label, self.entries.order[0]])
            self.limits[0] = self._up_to(self._cost(label)) if self.by_cost else least
        return True

    def _points(self, goals: list[Goal]) -> list[Goal]:
        if all(o.measure.is_whole for o in self.problem.objectives):
            # Each was popped before all that it might dominate, which the kernel pruned.
            return goals
        points: list[Goal] = []
        for goal in sorted(goals, key=attrgetter("objectives")):
            if not any(all(map(le, other.objectives, goal.objectives)) for other in points):
                points.append(goal)
        return points


def _with_costs(space: Space, costs: np.ndarray) -> Space:
    """Return a product in which edges, or actions where states are generated, have other costs."""
    if space.generated is not None:
        return space._replace(generated=space.generated._replace(costs=costs))
    assert space.edges is not None
    return space._replace(edges=space.edges._replace(costs=costs))
