"""Searches: memory for a compiled kernel, run in slices so that it can be limited and interrupted."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from operator import attrgetter, mul
from typing import Any

import numpy as np

from prefplan.front import Stats
from prefplan.heuristics.preprocessing import Prepared
from prefplan.limits import Limits
from prefplan.plan import Plan
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.kernels import UNBOUNDED
from prefplan.product.product_automaton import Product
from prefplan.product.starts import Start
from prefplan.product.successors import successor_buffer
from prefplan.search.labels import (
    AT,
    COL,
    COLUMNS,
    END,
    NONE,
    PRODUCT_LIMIT,
    Memory,
    Queue,
    States,
    growth_of,
    rehash,
)
from prefplan.search.plan_extraction import Waypoint, extract

ROWS_AT_FIRST, LABELS_AT_FIRST = 2**14, 2**15


@dataclass(frozen=True)
class Found:
    """A goal.

    Attributes:
        cost: total cost, units.
        label_mu: mu of the goal's label, in units; None where that is only a bound.
        objectives: exact values in the user's units, where there are several costs or preferences.
        least_cost: for a plan that need not be a point of the front, a lower bound of the cost of every plan, units;
            None for a point of the front.
    """

    cost: int
    label_mu: int | None
    _extract: Callable[[], tuple[Plan, Any]]
    objectives: tuple[Any, ...] | None = None
    least_cost: float | None = None

    @cached_property
    def _extracted(self) -> tuple[Plan, Any]:
        return self._extract()

    @property
    def plan(self) -> Plan:
        """The plan that leads to the goal."""
        return self._extracted[0]

    @property
    def mu(self) -> Any:
        """Exact preference value in the user's units: a fraction, or a float where a Python function gave it."""
        return self._extracted[1]


def in_units(product: Product, mu: Fraction) -> Fraction:
    """Return a preference value, without its constant part, in units of mu."""
    return (mu - product.problem.measure.constant) / product.units.mu


class Search(ABC):
    """What all searches have in common: product states, the open list, and the loop around the kernel.

    Attributes:
        by_cost: whether goals are found in order of the first cost.
        pops: labels popped between two checks of the limits, which then take a few tens of milliseconds.
    """

    labels: Any
    by_cost = True
    pops = 10_000

    def __init__(self, prepared: Prepared, max_cost: float) -> None:
        """Make the first labels; `max_cost` is an inclusive bound in units."""
        self.prepared, self.product = prepared, prepared.product
        self.growth = growth_of(self.product)
        self.limits = np.array([UNBOUNDED, self._up_to(max_cost)], dtype=np.int64)
        self.reset()

    @property
    def memory(self) -> Memory:
        """The arrays that the kernel works on."""
        p = self.prepared
        fixed = p.view, self.growth, p.bounds
        return Memory(*fixed, self.states, self.queue, self.counters, self.limits, self.begin, self.buffer)

    def _up_to(self, cost: float) -> int:
        """Return the largest label cost of at most `cost` units."""
        shift = self.product.shift
        return (int(min(cost, (UNBOUNDED >> shift) - 1)) + 1 << shift) - 1

    @abstractmethod
    def _new_labels(self, count: int) -> Any:
        """Return memory for labels."""

    @abstractmethod
    def _run(self, pops: int) -> int:
        """Run the kernel until `pops` labels are popped or something else ends it; return what did (`END`)."""

    def reset(self) -> None:
        """Start the search anew: the start states are entered as successors of no label."""
        self.counters = np.zeros(len(AT), dtype=np.int64)
        self.counters[AT.FOUND] = NONE
        self.states = States(
            np.empty((ROWS_AT_FIRST, COLUMNS), np.int64),
            np.full(2 * ROWS_AT_FIRST, NONE, np.int32),
        )
        self.labels = self._new_labels(LABELS_AT_FIRST)
        self.queue = Queue(*np.empty((2, LABELS_AT_FIRST), np.int64))
        self.buffer = successor_buffer(self.prepared.view, len(self.product.starts))
        view, node = self.prepared.view, self.prepared.graph.start
        pairs = sorted(((self._begin(start), start) for start in self.product.starts), key=lambda pair: pair[0][0])
        self._starts = [start for _, start in pairs]
        self.begin = np.array([key for key, _ in pairs] or np.zeros((0, 1)), dtype=np.int64)
        if self.begin.max(initial=0) >= PRODUCT_LIMIT:
            raise OverflowError
        for k, start in enumerate(self._starts):
            self.buffer.code[k] = node + sum(map(mul, view.strides.tolist(), start.automata))
            self.buffer.cost[k] = start.spent << self.product.shift
        self.counters[[AT.PARENT, AT.NEXT, AT.COUNT]] = NONE, 0, len(self._starts)

    def _begin(self, start: Start) -> list[int]:
        """Return the entries, in units, of the key of a start's label, but for its cost; here mu."""
        objective = self.product.problem.objectives[0]
        return [math.floor(in_units(self.product, objective.measure.value(*start.amounts(objective))))]

    def goals(self, limits: Limits, *, most_expanded: float = math.inf) -> Iterator[Found]:
        """Yield non-dominated goals in order of cost; stop early, with `limits.ended` set, at a limit.

        Args:
            limits: of time and memory.
            most_expanded: expansions after which to stop; another call continues the search.
        """
        pending, rank = list[Found](), 0
        while pending or self.counters[AT.EXPANDED] < most_expanded:
            end = self._run(int(max(1, min(self.pops, most_expanded - self.counters[AT.EXPANDED]))))
            self._require_measured()
            lowest = int(self.counters[AT.LOWEST]) >> (self.product.shift if self.by_cost else 0)
            limits.complete_below = lowest if self.by_cost else 0
            if pending and (end == END.EXHAUSTED or lowest > rank):
                yield from self._settled(pending)
                pending = []
            if end == END.EXHAUSTED:
                limits.complete_below = math.inf
                return
            if end == END.GOAL:
                goal = self._found(int(self.counters[AT.FOUND]))
                if self._accept(goal):
                    pending, rank = self._pending(pending, goal), goal.cost if self.by_cost else lowest
            elif end != END.PAUSED and not self._grow(end, limits):
                limits.ended = "memory"
                return
            if limits.out_of_time:
                limits.ended = "time"
                return

    def _pending(self, goals: list[Found], goal: Found) -> list[Found]:
        """Return the goals of one cost to keep when one more is found: here the last, which dominates the others."""
        return [goal]

    def _settled(self, goals: list[Found]) -> Iterator[Found]:
        """Yield the goals of one cost, after all have been found."""
        yield from goals

    def _require_measured(self) -> None:
        """Raise ModelError if an action was met whose cost was not measured."""
        state = int(self.buffer.digits.unmeasured[0])
        if state >= 0:
            assert isinstance(self.product, GeneratedProduct)
            self.product.model.generator.require_measured(state)

    def _exact_mu(self, label: int) -> int | None:
        """Return a label's mu in units, None where that is only a bound."""
        return None

    @abstractmethod
    def _accept(self, goal: Found) -> bool:
        """Tighten the limits by a goal; return False if its exact objectives show that it is none of the front."""

    def _found(self, label: int) -> Found:
        labels = self._labels_to(label)
        codes, costs = self.states.known[self.labels.row[labels], COL.CODE], self.labels.cost[labels].tolist()
        path = self.waypoints(codes, costs)
        start, graph = self._start_of(labels[0], path[0]), self.prepared.graph
        mu = self._exact_mu(label)
        return Found(costs[-1] >> self.product.shift, mu, lambda: extract(self.product, graph, path, start))

    def _labels_to(self, label: int) -> list[int]:
        """Return the labels on the path to one, that of the start first."""
        labels = []
        while label != NONE:
            labels.append(label)
            label = int(self.labels.parent[label])
        return labels[::-1]

    def waypoints(self, codes: np.ndarray, costs: Sequence[int]) -> tuple[Waypoint, ...]:
        """Return product states (n,) on a path, and its costs up to each, as waypoints."""
        view = self.prepared.view
        automata = (codes[:, None] // view.strides % view.sizes).tolist()
        nodes = (codes % view.nodes).tolist()
        return tuple(Waypoint(*at) for at in zip(nodes, map(tuple, automata), costs, strict=True))

    def _start_of(self, label: int, at: Waypoint) -> Start:
        """Return the start of a label without parent: one with its automaton states and its mu."""
        mu = self.labels.mu[label]
        starts = zip(self._starts, self.begin[:, 0], strict=True)
        return next(start for start, key in starts if key == mu and start.automata == at.automata)

    @property
    def work(self) -> Stats:
        """The work so far."""
        c = self.counters
        held = sum(map(attrgetter("nbytes"), (*self.states, *self.labels, *self.queue)))
        return Stats(int(c[AT.ROWS]), int(c[AT.EXPANDED]), int(c[AT.LABELS]), held)

    def _grow(self, end: int, limits: Limits) -> bool:
        """Double what the kernel ran out of; return False if that would exceed the memory limit."""
        if end == END.TOO_LARGE:
            self._too_large()
            raise OverflowError
        more = {END.MORE_ROWS: self.states, END.MORE_LABELS: (*self.labels, *self.queue)}[end]
        if max(self.work.bytes, limits.bytes_taken) + 2 * sum(map(attrgetter("nbytes"), more)) > limits.bytes:
            return False
        if end == END.MORE_ROWS:
            slots = np.full(2 * len(self.states.slots), NONE, np.int32)
            self.states = States(_longer(self.states.known), slots)
            rehash(self.states, int(self.counters[AT.ROWS]))
        else:
            self.labels = type(self.labels)(*map(_longer, self.labels))
            self.queue = Queue(*map(_longer, self.queue))
        return True

    def _too_large(self) -> None:
        """Raise an error that explains why a number does not fit 64 bits, if there is one."""
        return None


def _longer(array: np.ndarray) -> np.ndarray:
    """Return an array of twice the length that begins with the given one."""
    longer = np.empty((2 * len(array), *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer
