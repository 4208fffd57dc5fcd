"""The search for several costs and preferences: compiled (`ltmoa_star`), or in Python's integers (`exact_search`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain
from typing import Any

import numpy as np

from prefplan.front import Plan, Stats
from prefplan.heuristics.objective_bounds import objective_bounds
from prefplan.heuristics.preprocessing import Options, Prepared, bytes_to_prepare
from prefplan.limits import Limits
from prefplan.problem import Problem
from prefplan.product.generated_product import GeneratedProduct, unit_costs
from prefplan.product.product_automaton import Product
from prefplan.product.successors import INFINITE, UNBOUNDED, ProductView
from prefplan.search import ltmoa_star
from prefplan.search.driver import PRODUCT_LIMIT, ROWS_AT_FIRST, Found, Search
from prefplan.search.entry_map import EntryMap
from prefplan.search.exact_search import ExactSearch
from prefplan.search.labels import (
    CODE,
    COUNTERS,
    EXHAUSTED,
    EXPANDED,
    FOUND,
    GOAL,
    LOWEST,
    NONE,
    PAUSED,
    SATISFIED,
    States,
)
from prefplan.search.ltmoa_star import BOUND, MORE_GOALS, MORE_VECTORS, Entries, Paths, Vector, Vectors
from prefplan.search.plan_extraction import account, extract

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
            options: how.
            bounds: inclusive, of objectives by name, in the user's units.
            first: the one objective of which the least value is wanted; None for the whole front.
            max_bytes: memory that tables are to fit into.

        Raises:
            OverflowError: 64 bits may not be enough.
        """
        self.problem, self.entry_map = product.problem, EntryMap.of(product.problem)
        several = self.entry_map.costs > 1
        contraction = options.contraction and not several
        plain = Options(heuristic=0, landmarks=False, preference_bound=False, contraction=contraction)
        self.prepared = Prepared(product, plain, single=first is not None, max_bytes=max_bytes)
        self.product = product
        self.growth = self._growth()
        graph, view = self.prepared.graph, self.prepared.view
        columns = self._columns()
        views = [view, *(_with_costs(view, column)._replace(shift=0) for column in columns[1:])]
        self.bounds = objective_bounds(
            product, views, self.entry_map.additive, options, single=first is not None, max_bytes=max_bytes
        )
        self._bounds = bounds
        self._first = first if first is None or self._objective_entries()[first] is not None else None
        self._numbered = graph is None or not graph.contracted
        self.entries = self._entries(columns)
        if self._numbered:
            # A successor then comes with the edge that led to it, or the number of its costs.
            numbers = np.arange(len(columns[0]), dtype=np.int64)
            self.prepared.view = _with_costs(view, np.where(columns[0] < 0, columns[0], numbers))
        self.limits = self._limits()
        self.scratch = Vector(
            np.zeros(self.entry_map.count, np.int64),
            np.zeros(self.entry_map.count, np.int64),
            np.zeros(self.entry_map.costs + len(self.entry_map.additive), np.int64),
        )
        self.reset()

    def _columns(self) -> list[np.ndarray]:
        """Return each of the costs in units, (E,) int64 of the edges, or as `Moves` has them."""
        graph, product = self.prepared.graph, self.product
        if graph is None:
            assert isinstance(product, GeneratedProduct)
            found = [unit_costs(product.model, self.problem, d) for d in range(self.entry_map.costs)]
            if max(int(column.max()) for column in found) >= INFINITE:
                raise OverflowError
            return [column.astype(np.int64) for column in found]
        found = [graph.costs]
        for d, edges in enumerate(self.problem.edge_costs[1:], start=1):
            unit = self.problem.cost_units[d]
            counts = edges.costs // int(unit / edges.unit)
            if max(counts.tolist(), default=0) >= INFINITE:
                raise OverflowError
            found.append(counts.astype(np.int64))
        return found

    def _entries(self, columns: list[np.ndarray]) -> Entries:
        """Return what the kernel needs to know of the entries.

        Raises:
            OverflowError: what one step adds to an entry may exceed 64 bits.
        """
        at, tasks = self.entry_map, len(self.product.sizes)
        sets = 2**tasks
        late = [(a, term) for a, o in enumerate(at.additive) for term in o.measure.tardiness]
        units = [at.additive[a].units for a, _ in late]
        maximum = [o.measure.maximum_table(o.units.factor)[k] for o, k in at.maxima]
        slopes = [int(term.weight * unit.factor) for (_, term), unit in zip(late, units, strict=True)]
        offsets = [term.weight * term.by / unit.mu for (_, term), unit in zip(late, units, strict=True)]
        largest = [1] * at.costs
        for (a, _), slope in zip(late, slopes, strict=True):
            largest[at.additive[a].cost] = max(largest[at.additive[a].cost], slope)
        for (o, _), table in zip(at.maxima, maximum, strict=True):
            largest[o.cost] = max(largest[o.cost], int(table.max(initial=1)))
        self._require_64_bits(columns)
        violation = [[int(w * o.units.price / o.units.mu) for w in o.measure.violation_weights] for o in at.additive]
        numbered = self._numbered
        return Entries(
            edge_costs=np.stack(columns) if numbered else np.zeros((1, 0), np.int64),
            of=np.array([o.cost for o in at.additive], np.int64),
            rate=_table([o.measure.rate_table(o.units.factor) for o in at.additive], sets),
            violation=_table(violation, tasks),
            late=_table([(a, term.task) for a, term in late], 2),
            late_slope=np.array(slopes, np.int64),
            late_offset=np.array([min(int(offset), PRODUCT_LIMIT) for offset in offsets], np.int64),
            of_maximum=np.array([o.cost for o, _ in at.maxima], np.int64),
            maximum=_table(maximum, sets),
            frozen=_table(at.frozen, 2),
            paid=np.array(at.paid, np.int64),
            cost_limit=np.array([PRODUCT_LIMIT // most for most in largest], np.int64),
            order=self._order(),
        )

    def _require_64_bits(self, columns: list[np.ndarray]) -> None:
        """Prove that what one step adds to an entry stays below 2^60, as `preprocessing` does for one objective."""
        view = self.prepared.view
        nodes = len(view.classes) if view.macro else 1
        steps = [max(1, int(column.max(initial=0)) * nodes) for column in columns]
        price = max([1, *self.product.extra_price.tolist(), *(dfa.skip or 0 for dfa in self.product.automata)])
        growths = [Fraction(max(steps))]
        for o in self.problem.objectives:
            growth = o.measure.largest_rate() * o.units.factor * steps[o.cost]
            growth += sum(o.measure.violation_weights) * o.units.price / o.units.mu * price
            growth += sum((max(term.weights) * o.units.factor for term in o.measure.maxima), Fraction(0))
            growths.append(growth)
        if max(growths) >= INFINITE:
            raise OverflowError

    def _objective_entries(self) -> dict[str, int | None]:
        """Return the entry of each objective, by name, None where it is none by itself."""
        costs = dict(zip(self.problem.cost_names, range(self.entry_map.costs), strict=True))
        return costs | {o.name: self.entry_map.alone(o) for o in self.problem.objectives}

    def _order(self) -> np.ndarray:
        """Return the entries in the order of comparison: the wanted objective, the others, and what is none."""
        places = self._objective_entries()
        wanted = [] if self._first is None else [places[self._first]]
        ordered = chain(wanted, places.values(), range(self.entry_map.count))
        return np.array(list(dict.fromkeys(e for e in ordered if e is not None)), dtype=np.int64)

    def _limits(self) -> np.ndarray:
        """Return the largest bounds of the entries; what no entry is a bound of is looked at when a goal is found."""
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

    def reset(self) -> None:
        """Forget everything but the bounds."""
        super().reset()
        counters = self.counters
        self.counters = np.zeros(COUNTERS + 2, dtype=np.int64)
        self.counters[:COUNTERS] = counters
        columns = BOUND + len(self.scratch.growth)
        self.states = States(np.empty((ROWS_AT_FIRST, columns), np.int64), self.states.slots)
        width = self.entry_map.count - 1
        self.vectors = Vectors(
            np.empty((VECTORS_MADE_AT_FIRST, width), np.int64), np.empty((VECTORS_MADE_AT_FIRST, width), np.int64)
        )

    def _new_labels(self, count: int) -> Paths:
        rows, parents, steps = (np.empty(count, np.int32) for _ in range(3))
        return Paths(rows, parents, steps, np.empty((count, self.entry_map.count), np.int64))

    def _run(self, pops: int) -> int:
        memory, own = self.memory, (self.entries, self.bounds, self.labels, self.vectors, self.scratch)
        return int(ltmoa_star.run(memory, *own, pops))

    @property
    def work(self) -> Stats:
        """What was done so far."""
        stats = super().work
        held = stats.bytes + sum(array.nbytes for array in self.vectors)
        return Stats(stats.states, stats.expanded, stats.generated, held)

    def _make_room(self, end: int, limits: Limits) -> bool:
        if end not in (MORE_VECTORS, MORE_GOALS):
            return super()._make_room(end, limits)
        vectors = self.vectors[end - MORE_VECTORS]
        if max(self.work.bytes, limits.bytes_taken) + 2 * vectors.nbytes > limits.bytes:
            return False
        longer = np.concatenate([vectors, np.empty_like(vectors)])
        self.vectors = self.vectors._replace(**{Vectors._fields[end - MORE_VECTORS]: longer})
        return True

    def _accept(self, goal: Found) -> bool:
        return True

    def goals(self, limits: Limits, *, most_expanded: float = math.inf) -> Iterator[Found]:
        """Yield non-dominated goals by the first objective, then the others; stop early at a limit, as `Search`."""
        pending: list[Point] = []
        front: list[tuple[Any, ...]] = []
        by_cost = int(self.entries.order[0]) == 0
        while self.counters[EXPANDED] < most_expanded:
            end = self._run(self.pops)
            self._require_measured()
            lowest = int(self.counters[LOWEST]) >> (self.product.shift if by_cost else 0)
            limits.complete_below = lowest if by_cost else 0
            if pending and (end == EXHAUSTED or lowest > pending[0].order):
                yield from self._settled(pending, front)
                pending = []
            if end == EXHAUSTED:
                limits.complete_below = math.inf
                return
            if end == GOAL:
                pending += self._points(int(self.counters[FOUND]), lowest)
            elif end != PAUSED and not self._make_room(end, limits):
                limits.ended = "memory"
                return
            if limits.out_of_time:
                limits.ended = "time"
                return

    def _points(self, label: int, lowest: int) -> list[Point]:
        """Return a goal as a point, unless it exceeds a bound."""
        key = self.labels.key[label].tolist()
        spent = [key[0] >> self.product.shift, *key[1 : self.entry_map.costs]]
        known = self.states.known[self.labels.row[label]]
        for c, (cost, i) in enumerate(self.entry_map.frozen):
            if not known[SATISFIED] >> i & 1:
                key[len(key) - len(self.entry_map.paid) - len(self.entry_map.frozen) + c] = spent[cost]
        values = [self.entry_map.value(o, key, spent) for o in self.problem.objectives]
        costs = [units * count for units, count in zip(self.problem.cost_units, spent, strict=True)]
        vector = (*costs, *values)
        worth = dict(zip(self.problem.objective_names, vector, strict=True))
        if any(worth[name] > bound for name, bound in self._bounds.items()):
            return []
        if self._first is not None:
            entry = int(self.entries.order[0])
            self.limits[entry] = self._up_to(spent[0]) if entry == 0 else key[entry]
        return [Point(lowest, vector, label)]

    def _settled(self, pending: list[Point], front: list[tuple[Any, ...]]) -> Iterator[Found]:
        """Yield those of some goals that no other point dominates, and add them to the front."""
        if all(o.measure.bi_objective for o in self.problem.objectives):
            # What an earlier goal dominates the kernel leaves out.
            front.clear()
        for point in sorted(pending, key=lambda point: point.vector):
            if any(all(a <= b for a, b in zip(other, point.vector, strict=True)) for other in front):
                continue
            front.append(point.vector)
            yield self._found_at(point)

    def _found_at(self, point: Point) -> Found:
        labels, label = [], point.label
        while label != NONE:
            labels.append(label)
            label = int(self.labels.parent[label])
        labels.reverse()
        codes = self.states.known[self.labels.row[labels], CODE]
        steps, costs = self.labels.step[labels].tolist(), self.labels.key[labels, 0].tolist()
        start, graph = self._starts[steps[0]], self.prepared.graph
        path = self.waypoints(codes, costs)

        def plan() -> tuple[Plan, Any]:
            if graph is not None and self._numbered:
                return account(self.product, steps[1:], [at.automata for at in path], start)
            return extract(self.product, graph, path, start)

        return Found(costs[-1] >> self.product.shift, None, plan, point.vector)


@dataclass(frozen=True)
class Point:
    """A goal: what order it was found in, its exact objectives in the user's units, and its label."""

    order: int
    vector: tuple[Any, ...]
    label: int


def _with_costs(view: ProductView, costs: np.ndarray) -> ProductView:
    """Return a product in which edges, or actions where states are generated, have other costs."""
    return view._replace(costs=costs, moves=view.moves._replace(costs=costs) if view.generated else view.moves)


def _table(rows: Any, width: int) -> np.ndarray:
    """Return rows of a width, of which there may be none."""
    return np.array(list(rows), dtype=np.int64).reshape(-1, width)


def points(
    product: Product,
    listed: Callable[[], Product],
    options: Options,
    bounds: Mapping[str, Fraction],
    limits: Limits,
    first: str | None,
) -> Iterator[tuple[Search | ExactSearch, Found | None]]:
    """Yield the non-dominated points of a problem's objectives, and the search as it is then; at the end None.

    Args:
        product: what is searched.
        listed: returns the same with all states listed.
        options: how.
        bounds: inclusive, of objectives by name, in the user's units.
        limits: when to stop.
        first: an objective of which the least value is wanted; points of more need not be found.
    """
    yielded = set()
    for exact_numbers in (not options.compiled or not _can_compile(product.problem), True):
        try:
            if not exact_numbers and len(product.problem.cost_names) * bytes_to_prepare(product) > limits.bytes:
                limits.ended = "memory"
                return
            search: ObjectiveSearch | ExactSearch
            if exact_numbers:
                search = ExactSearch(listed(), bounds=bounds)
            else:
                search = ObjectiveSearch(product, options, bounds=bounds, first=first, max_bytes=limits.bytes)
            for found in search.goals(limits):
                if found.objectives not in yielded:
                    yielded.add(found.objectives)
                    yield search, found
            yield search, None
            return
        except OverflowError:
            if exact_numbers:
                raise
            # What 64 bits may not hold is searched again in Python's integers.
            limits.ended = None


def _can_compile(problem: Problem) -> bool:
    """Return whether whole numbers are enough to compare labels by."""
    formulas = [formula for objective in problem.objectives for formula in objective.measure.formulas]
    return all(formula.contract == "componentwise" for formula in formulas)
