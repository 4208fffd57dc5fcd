"""Searches: memory for a compiled kernel, run in slices so that it can be limited and interrupted."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from prefplan.errors import LimitError
from prefplan.front import Plan, Stats
from prefplan.heuristics.lagrangian import least_sum, weights_along
from prefplan.heuristics.preprocessing import Prepared
from prefplan.limits import EXACT, Limits, Percent
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.moves import scratch_digits
from prefplan.product.product_automaton import Product, Start
from prefplan.product.successors import UNBOUNDED, Successors
from prefplan.search import boa_star
from prefplan.search.labels import (
    CODE,
    COLUMNS,
    COUNT,
    COUNTERS,
    EXHAUSTED,
    EXPANDED,
    FOUND,
    GOAL,
    GROWTH_BOUND,
    HEAD,
    LABELS,
    LOWEST,
    MORE_LABELS,
    MORE_ROWS,
    NEXT,
    NONE,
    OPEN,
    PARENT,
    PAUSED,
    ROWS,
    TOO_LARGE,
    Growth,
    Memory,
    Queue,
    States,
    rehash,
)
from prefplan.search.plan_extraction import Waypoint, extract

PRODUCT_LIMIT = 2**61
"""Products of a cost and a weight stay below this."""

ROWS_AT_FIRST, LABELS_AT_FIRST = 2**14, 2**15


@dataclass(frozen=True)
class Found:
    """A non-dominated goal.

    Attributes:
        cost: total cost, units.
        label_mu: units of mu that the search counted; None where it knows only a bound.
        objectives: exact values in the user's units, where there are several costs or preferences.
    """

    cost: int
    label_mu: int | None
    _extract: Callable[[], tuple[Plan, Any]]
    objectives: tuple[Any, ...] | None = None

    @cached_property
    def _extracted(self) -> tuple[Plan, Any]:
        return self._extract()

    @property
    def plan(self) -> Plan:
        """How to get there."""
        return self._extracted[0]

    @property
    def mu(self) -> Any:
        """Exact preference value in the user's units: a fraction, or a float where a Python function gave it."""
        return self._extracted[1]


def in_units(product: Product, mu: Fraction) -> Fraction:
    """Return a preference value, its constant part left out, in units of mu."""
    return (mu - product.problem.measure.constant) / product.units.mu


class Search(ABC):
    """What all searches have in common: product states, the open list, and the loop around the kernel.

    Attributes:
        pops: labels popped between two looks at the clock; they take a few tens of milliseconds.
    """

    labels: Any
    pops = 10_000

    def __init__(self, prepared: Prepared, max_cost: float, tolerance: Percent = EXACT) -> None:
        """Make the first labels; `max_cost` is an inclusive bound in units."""
        self.prepared, self.tolerance = prepared, tolerance
        self.product = prepared.product
        self.growth = self._growth()
        self.limits = np.array([UNBOUNDED, self._up_to(max_cost)], dtype=np.int64)
        self.reset()

    @property
    def memory(self) -> Memory:
        """What the kernel works on."""
        p = self.prepared
        fixed = p.view, self.growth, p.bounds
        return Memory(*fixed, self.states, self.queue, self.counters, self.limits, self.buffer)

    def _up_to(self, cost: float) -> int:
        """Return the largest label cost that is worth at most some units."""
        shift = self.product.shift
        return (int(min(cost, (UNBOUNDED >> shift) - 1)) + 1 << shift) - 1

    @abstractmethod
    def _new_labels(self, count: int) -> Any:
        """Return memory for labels."""

    @abstractmethod
    def _run(self, pops: int) -> int:
        """Run the kernel until so many labels are popped or something happens, and return what."""

    def _growth(self) -> Growth:
        measure, units = self.product.problem.measure, self.product.units
        late, maximum = measure.tardiness, measure.maximum_table(units.factor)
        slopes = [int(term.weight * units.factor) for term in late]
        offsets = [min(int(term.weight * term.by / units.mu), PRODUCT_LIMIT) for term in late]
        prices = [int(weight * units.price / units.mu) for weight in measure.violation_weights]
        return Growth(
            rate=self.product.rates,
            maximum=maximum,
            late_task=np.array([term.task for term in late], dtype=np.int64),
            late_slope=np.array(slopes, dtype=np.int64),
            late_offset=np.array(offsets, dtype=np.int64),
            violation=np.array(prices, dtype=np.int64),
            cost_limit=PRODUCT_LIMIT // max(1, *slopes, int(maximum.max(initial=0))),
        )

    def reset(self) -> None:
        """Forget everything and hand the start states to the kernel, as the successors of no label."""
        self.counters = np.zeros(COUNTERS, dtype=np.int64)
        self.counters[FOUND] = NONE
        self.states = States(
            np.empty((ROWS_AT_FIRST, COLUMNS), np.int64),
            np.full(2 * ROWS_AT_FIRST, NONE, np.int32),
        )
        self.labels = self._new_labels(LABELS_AT_FIRST)
        self.queue = Queue(*np.empty((2, LABELS_AT_FIRST), np.int64))
        self.buffer = self._buffer()
        view, node = self.prepared.view, self.prepared.start_node
        weights = self.growth.violation
        self._starts = sorted(
            self.product.starts, key=lambda start: int(weights @ np.array(start.violations, dtype=np.int64))
        )
        for k, start in enumerate(self._starts):
            _, automata = self.product.decode(start.code)
            self.buffer.code[k] = node + sum(int(d) * q for d, q in zip(view.strides, automata, strict=True))
            self.buffer.cost[k] = 0
            self.buffer.violation[k] = start.violations
        self.counters[[PARENT, NEXT, COUNT]] = NONE, 0, len(self._starts)

    def _buffer(self) -> Successors:
        view = self.prepared.view
        nodes, tasks = len(view.classes), len(view.sizes)
        most = nodes if view.macro else int(np.diff(view.offsets).max(initial=0))
        if view.generated:
            most = len(view.moves.capacity) + len(view.moves.fixed) + 1
        if view.relaxed:
            readings = np.diff(view.extra_first, axis=2).max(axis=1) + 1
            most *= int(readings.prod(axis=0).max())
        most = max(most, len(self.product.starts))
        scratch = nodes if view.macro else 1
        return Successors(
            code=np.empty(most, np.int64),
            cost=np.empty(most, np.int64),
            violation=np.zeros((most, tasks), np.int64),
            automata=np.empty(tasks, np.int64),
            distance=np.empty(scratch, np.int64),
            via=np.empty(scratch, np.int64),
            choice=np.empty(tasks, np.int64),
            digits=scratch_digits(view.moves),
        )

    def goals(self, limits: Limits, *, most_expanded: float = math.inf) -> Iterator[Found]:
        """Yield non-dominated goals in order of cost; stop early, with `limits.ended` set, at a limit.

        Args:
            limits: of time and memory.
            most_expanded: labels after which to stop without more ado; another call goes on from there.
        """
        pending: Found | None = None
        while pending or self.counters[EXPANDED] < most_expanded:
            end = self._run(self.pops)
            self._require_measured()
            limits.complete_below = int(self.counters[LOWEST]) >> self.product.shift
            if pending and (end == EXHAUSTED or limits.complete_below > pending.cost):
                yield pending
                pending = None
            if end == EXHAUSTED:
                limits.complete_below = math.inf
                return
            if end == GOAL:
                goal = self._found(int(self.counters[FOUND]))
                if self._accept(goal):
                    pending = goal
            elif end != PAUSED and not self._make_room(end, limits):
                limits.ended = "memory"
                return
            if limits.out_of_time:
                limits.ended = "time"
                return

    def _require_measured(self) -> None:
        """Raise ModelError if an action was met that was not measured."""
        state = int(self.buffer.digits.unmeasured[0])
        if state >= 0:
            assert isinstance(self.product, GeneratedProduct)
            self.product.model.generator.require_measured(state)

    def _exact_mu(self, label: int) -> int | None:
        """Return a label's mu in units, None where that is only a bound."""
        return None

    def left_out(self, cost: np.ndarray, mu: np.ndarray) -> np.ndarray:
        """Return of bounds of labels' costs (n,) and of mu (n,) whether nothing that they admit is looked for.

        Unless a search leaves more out, all is looked for.
        """
        return np.zeros(len(cost), dtype=bool)

    @abstractmethod
    def _accept(self, goal: Found) -> bool:
        """Take note of a goal; return whether it is one, by its exact mu."""

    def _found(self, label: int) -> Found:
        mu, labels = self._exact_mu(label), []
        last = label
        while label != NONE:
            labels.append(label)
            label = int(self.labels.parent[label])
        labels.reverse()
        codes, costs = self.states.known[self.labels.row[labels], CODE], self.labels.cost[labels]
        path = self.waypoints(codes, costs.tolist())
        start = self._start_of(labels[0], path[0])
        return Found(
            int(self.labels.cost[last]) >> self.product.shift,
            mu,
            lambda: extract(self.product, self.prepared.graph, path, start),
        )

    def waypoints(self, codes: np.ndarray, costs: Sequence[int]) -> tuple[Waypoint, ...]:
        """Return product states (n,) on a path, and the costs of getting there, as waypoints."""
        view = self.prepared.view
        automata = (codes[:, None] // view.strides % self.product.sizes).tolist()
        nodes = (codes % view.nodes).tolist()
        return tuple(Waypoint(*at) for at in zip(nodes, map(tuple, automata), costs, strict=True))

    def _start_of(self, label: int, at: Waypoint) -> Start:
        """Return how a label without parent begins: of the starts that lead to its state the one of its mu."""
        weights = self.growth.violation
        starts = [start for start in self._starts if self.product.decode(start.code)[1] == at.automata]
        return min(starts, key=lambda start: int(weights @ np.array(start.violations, dtype=np.int64)))

    @property
    def work(self) -> Stats:
        """What was done so far."""
        c = self.counters
        held = sum(array.nbytes for arrays in (self.states, self.labels, self.queue) for array in arrays)
        return Stats(int(c[ROWS]), int(c[EXPANDED]), int(c[LABELS]), held)

    def _make_room(self, end: int, limits: Limits) -> bool:
        """Grow what the kernel ran out of; return False if that would exceed the memory."""
        if end == TOO_LARGE:
            self._too_large()
            raise OverflowError
        more = {MORE_ROWS: self.states, MORE_LABELS: (*self.labels, *self.queue)}[end]
        if max(self.work.bytes, limits.bytes_taken) + 2 * sum(array.nbytes for array in more) > limits.bytes:
            return False
        if end == MORE_ROWS:
            slots = np.full(2 * len(self.states.slots), NONE, np.int32)
            self.states = States(_longer(self.states.known), slots)
            rehash(self.states, int(self.counters[ROWS]))
        else:
            self.labels = type(self.labels)(*map(_longer, self.labels))
            self.queue = Queue(*map(_longer, self.queue))
        return True

    def _too_large(self) -> None:
        """Take note of a number that 64 bits do not hold."""
        return None


class BiObjectiveSearch(Search):
    """BOA*, for measures whose label key is (g, mu)."""

    def __init__(
        self,
        prepared: Prepared,
        *,
        max_mu: Fraction | None = None,
        max_cost: float = math.inf,
        cost_only: bool = False,
        first_only: bool = False,
        tolerance: Percent = EXACT,
        known: Sequence[Found] = (),
        drafted: Sequence[Found] = (),
    ) -> None:
        """Make the search ready.

        Args:
            prepared: what to search.
            max_mu: inclusive bound in the user's units.
            max_cost: inclusive bound, units of cost.
            cost_only: find a cheapest goal, whatever its mu (A*).
            first_only: find the first goal of the front only.
            tolerance: goals are left out that one of those found, or known, is within so many percent of.
            known: goals found by other searches, that leave out what they are good enough for.
            drafted: plans close to the front, or some of them.
        """
        self._max_mu = UNBOUNDED if max_mu is None else math.floor(in_units(prepared.product, max_mu))
        self._cost_only, self._first_only = cost_only, first_only or cost_only
        product = prepared.product
        self.tolerance = tolerance
        self._left_out = boa_star.Tolerance(
            tolerance.inflation,
            np.array([tolerance.least_cost(goal.cost) << product.shift for goal in known], dtype=np.int64),
            np.array([self._least_mu(product, goal) for goal in known], dtype=np.int64),
        )
        super().__init__(prepared, max_cost, tolerance)
        self._met = [self._worth(goal) for goal in (*known, *drafted)]
        self._reached: tuple[int, int] | None = None
        self._next_table = prepared.lagrangian_expansions if self._met else math.inf

    def _worth(self, goal: Found) -> tuple[int, int]:
        """Return cost and mu of a plan in units."""
        return goal.cost, math.floor(in_units(self.prepared.product, Fraction(goal.mu)))

    def reset(self) -> None:
        """Forget everything but the bounds."""
        self.limits[0] = min(self._max_mu + 1, UNBOUNDED)
        super().reset()

    def _new_labels(self, count: int) -> boa_star.Labels:
        kinds = (np.int32, np.int64, np.int64, np.int32, np.int32)
        return boa_star.Labels(*(np.empty(count, kind) for kind in kinds))

    def _run(self, pops: int) -> int:
        if self._cost_only and self.counters[EXPANDED] > self.prepared.deepening_expansions:
            self.prepared.deepen()
            self.reset()
        if not self._cost_only and self.counters[EXPANDED] >= self._next_table:
            self._tabulate_ahead()
        return int(boa_star.run(self.memory, self.labels, self._cost_only, self._left_out, pops))

    def _tabulate_ahead(self) -> None:
        """Have bounds tabulated for what is left of the front, as far as it is known where that leads."""
        begin, end = self._reached or min(self._met), self._likely_end()
        weights = None if end is None else weights_along(begin, end)
        if weights is not None and list(weights) not in self.prepared.bounds.lagrangian.weights.tolist():
            try:
                self.prepared.weigh(weights)
            except LimitError as error:
                if error.ended != "memory":
                    raise
                # Without the table, the memory may suffice.
                self._next_table = math.inf
                return
        self._next_table = self.counters[EXPANDED] + self.prepared.lagrangian_expansions

    def _likely_end(self) -> tuple[int, int] | None:
        """Return about what cost and mu the end of the front has, in units; None if nothing tells."""
        tables, open_labels = self.prepared.bounds.lagrangian, self.queue.items[: self.counters[OPEN]]
        labels = open_labels[self.labels.mu[open_labels] < self.limits[0]]
        if not len(tables.weights) or not len(labels):
            ahead = [plan for plan in self._met if plan[1] < self.limits[0]]
            return min(ahead, key=lambda plan: (plan[1], plan[0]), default=None)
        known, mus = self.states.known[self.labels.row[labels]], self.labels.mu[labels]
        view, costs = self.prepared.view, self.labels.cost[labels] >> self.product.shift
        automata = known[:, CODE, None] // view.strides % self.product.sizes
        total = least_sum(tables, len(tables.weights) - 1, known[:, CODE] % view.nodes, automata, costs, mus)
        if total is None:
            return None
        # No plan costs less if its mu is as small as that of any may be.
        mu = int((mus + known[:, GROWTH_BOUND]).min())
        return (total - int(tables.weights[-1, 1]) * mu) // int(tables.weights[-1, 0]), mu

    def _exact_mu(self, label: int) -> int:
        return int(self.labels.mu[label])

    def bound_cost(self, most: float) -> None:
        """Look for no goals that cost more, in units."""
        self.limits[1] = min(self.limits[1], self._up_to(most))

    def adopt_states(self, other: Search) -> None:
        """Take over the product states, with their bounds, of another search over the same."""
        self.states, self.counters[ROWS] = other.states, other.counters[ROWS]
        self.states.known[: other.counters[ROWS], HEAD] = NONE

    def _accept(self, goal: Found) -> bool:
        self._reached = goal.cost, int(self.limits[0])
        if self._cost_only:
            self.limits[1] = -1
        elif self._first_only:
            self.limits[1] = self._up_to(goal.cost)
        elif self.tolerance.value:
            self.limits[0] = min(self.limits[0], self._least_mu(self.product, goal))
        return True

    def left_out(self, cost: np.ndarray, mu: np.ndarray) -> np.ndarray:
        """Return of bounds of labels' costs (n,) and of mu (n,) whether nothing that they admit is looked for."""
        out: np.ndarray = mu >= self.limits[0]
        for least_cost, least_mu in zip(self._left_out.cost, self._left_out.mu, strict=True):
            out |= (cost >= least_cost) & (mu >= least_mu)
        return out

    def _least_mu(self, product: Product, goal: Found) -> int:
        """Return from which units of mu on a goal is good enough."""
        return math.ceil(in_units(product, self.tolerance.least(Fraction(goal.mu))))


def _longer(array: np.ndarray) -> np.ndarray:
    """Return an array of twice the length that begins with another."""
    longer = np.empty((2 * len(array), *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer


def found_path(search: BiObjectiveSearch, path: Sequence[tuple[int, int]]) -> Found:
    """Return the plan along product states, each with the cost of getting there."""
    codes, costs = zip(*path, strict=True)
    waypoints = search.waypoints(np.array(codes, dtype=np.int64), costs)
    start = search._start_of(NONE, waypoints[0])
    product, graph = search.product, search.prepared.graph
    return Found(costs[-1] >> product.shift, None, lambda: extract(product, graph, waypoints, start))
