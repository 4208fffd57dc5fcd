"""Searches: memory for a compiled kernel, run in slices so that it can be limited and interrupted."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from fractions import Fraction
from operator import attrgetter, mul
from typing import Any

import numpy as np

from prefplan.errors import LimitError
from prefplan.front import Stats
from prefplan.heuristics.prepare import Prepared
from prefplan.limits import Limits
from prefplan.models.kernels import UNBOUNDED, is_interpreted
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.product_automaton import Product
from prefplan.product.starts import Start
from prefplan.product.successors import successor_buffer
from prefplan.search.growth import PRODUCT_LIMIT
from prefplan.search.labels import (
    AT,
    COL,
    COLUMNS,
    END,
    NONE,
    Memory,
    Queue,
    States,
    rehash,
)
from prefplan.search.paths import GeneratedPaths, Paths
from prefplan.search.result import Goal, Result, ended_by

ROWS_AT_FIRST, LABELS_AT_FIRST = 2**14, 2**15

INTERPRETED_POPS = 100
"""Labels popped by a kernel that runs in Python before it may go on compiled; they take some tens of milliseconds."""


def in_units(product: Product, mu: Fraction) -> Fraction:
    """Return a preference value, without its constant part, in units of mu."""
    return (mu - product.problem.measure.constant) / product.units.mu


class Search(ABC):
    """What all searches have in common: product states, the open list, and the loop around the kernel.

    Attributes:
        by_cost: whether goals are found in order of the first cost.
        single: whether the search ends with the first point of the front.
        pops: labels popped between two checks of the limits, which then take a few tens of milliseconds.
    """

    labels: Any
    by_cost = True
    single = False
    pops = 10_000

    def __init__(self, prepared: Prepared, max_cost: float) -> None:
        """Make the first labels; `max_cost` is an inclusive bound in units."""
        self.prepared, self.product = prepared, prepared.product
        self.limits = np.array([UNBOUNDED, self._up_to(max_cost)], dtype=np.int64)
        self.reset()

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
        self._lowest, self._found = 0.0, list[tuple[float, int, tuple[Any, ...]]]()
        self.states = States(
            np.empty((ROWS_AT_FIRST, COLUMNS), np.int64),
            np.full(2 * ROWS_AT_FIRST, NONE, np.int32),
        )
        self.labels = self._new_labels(LABELS_AT_FIRST)
        self.queue = Queue(*np.empty((2, LABELS_AT_FIRST), np.int64))
        self.buffer = successor_buffer(self.prepared.space, len(self.product.starts))
        strides, node = self.prepared.space.strides.tolist(), self.prepared.graph.start
        pairs = sorted(((self._begin(start), start) for start in self.product.starts), key=lambda pair: pair[0][0])
        self._starts = [start for _, start in pairs]
        self.begin = np.array([key for key, _ in pairs] or np.zeros((0, 1)), dtype=np.int64)
        if self.begin.max(initial=0) >= PRODUCT_LIMIT:
            raise OverflowError
        if self.prepared.space.generated is not None:
            self.prepared.space.generated.unmeasured[0] = -1
        for k, start in enumerate(self._starts):
            self.buffer.code[k] = node + sum(map(mul, strides, start.automata))
            self.buffer.cost[k] = start.spent << self.product.shift
        self.counters[[AT.PARENT, AT.NEXT, AT.COUNT]] = NONE, 0, len(self._starts)

    def _begin(self, start: Start) -> list[int]:
        """Return the entries, in units, of the key of a start's label, but for its cost; here mu."""
        objective = self.product.problem.objectives[0]
        return [math.floor(in_units(self.product, objective.measure.value(*start.amounts(objective))))]

    def run(self, limits: Limits, *, most_expanded: float = math.inf) -> Result:
        """Search until all goals are found, or a limit or Ctrl-C stops it; see `single`.

        Args:
            limits: of time and memory.
            most_expanded: expansions after which to stop; another call continues the search.
        """
        ended = None
        try:
            while not self._is_done and (self._is_pending or self.counters[AT.EXPANDED] < most_expanded):
                pops = INTERPRETED_POPS if is_interpreted() else self.pops
                pops = max(1, min(pops, most_expanded - self.counters[AT.EXPANDED]))
                self._advance(int(pops), limits)
                if not self._is_done and limits.out_of_time:
                    raise LimitError("time")
        except (LimitError, KeyboardInterrupt) as error:
            ended = ended_by(error)
        settled = [(label, objectives) for rank, label, objectives in self._found if rank < self._lowest]
        paths = self._paths([label for label, _ in settled])
        goals = [Goal(self._cost(label), values, paths, k) for k, (label, values) in enumerate(settled)]
        below = self._lowest if self.by_cost or self._lowest == math.inf else 0
        return Result(tuple(self._points(goals)), ended, below, self.work)

    def _advance(self, pops: int, limits: Limits) -> None:
        """Run the kernel once; raise LimitError if the search needs more memory than there is."""
        end = self._run(pops)
        self._require_measured()
        if end == END.EXHAUSTED:
            self._lowest = math.inf
            return
        self._lowest = int(self.counters[AT.LOWEST]) >> (self.product.shift if self.by_cost else 0)
        if end == END.GOAL:
            label = int(self.counters[AT.FOUND])
            objectives = self._objectives(label)
            if self._accept(label, objectives):
                rank = self._cost(label) if self.by_cost else self._lowest
                self._found.append((rank, label, objectives))
        elif end != END.PAUSED and not self._grow(end, limits):
            raise LimitError("memory")

    @property
    def memory(self) -> Memory:
        """What the kernel works on."""
        return Memory(self.states, self.labels, self.queue, self.counters, self.limits, self.begin, self.buffer)

    @property
    def _is_done(self) -> bool:
        return self._lowest == math.inf or (self.single and bool(self._found) and not self._is_pending)

    @property
    def _is_pending(self) -> bool:
        """Whether the last goal may still prove to be dominated by another one of equal cost."""
        return bool(self._found) and self._found[-1][0] >= self._lowest

    def _points(self, goals: list[Goal]) -> list[Goal]:
        """Return the points of the front among goals in the order in which they were found.

        Here that is the last of each cost, which dominates the others.
        """
        return list({goal.cost: goal for goal in goals}.values())

    def _require_measured(self) -> None:
        """Raise ModelError if an action was met whose cost was not measured."""
        generated = self.prepared.space.generated
        state = -1 if generated is None else int(generated.unmeasured[0])
        if state >= 0:
            assert isinstance(self.product, GeneratedProduct)
            self.product.model.require_measured(state)

    @abstractmethod
    def _objectives(self, label: int) -> tuple[Any, ...]:
        """Return the exact objectives of a goal's label, in the user's units."""

    @abstractmethod
    def _accept(self, label: int, objectives: tuple[Any, ...]) -> bool:
        """Tighten the limits by a goal; return False if its objectives show that it is no point of the front."""

    def _cost(self, label: int) -> int:
        """Return a label's first cost, units."""
        return int(self._costs(np.array([label]))[0]) >> self.product.shift

    def _paths(self, labels: Sequence[int]) -> Paths:
        """Return the paths that lead to some labels."""
        last = np.array(labels, dtype=np.int64)
        generations = [last]
        while len(generations[-1]):
            ahead = np.unique(self.labels.parent[generations[-1]])
            generations.append(ahead[ahead != NONE])
        kept = np.unique(np.concatenate(generations))
        parents = self.labels.parent[kept]
        before = np.searchsorted(kept, np.where(parents == NONE, kept, parents))
        codes, space = self.states.known[self.labels.row[kept], COL.CODE], self.prepared.space
        automata = codes[:, None] // space.strides % space.automata.sizes
        nodes = codes % space.automata.nodes
        first = np.flatnonzero(parents == NONE).tolist()
        starts = {k: self._start_of(int(kept[k]), tuple(automata[k].tolist())) for k in first}
        ends = np.searchsorted(kept, last)
        if isinstance(self.product, GeneratedProduct):
            return GeneratedPaths(self.product, before, nodes, automata, starts, ends)
        edges = self._edges(kept)
        if edges is not None:
            return Paths(self.product, before, edges, automata, starts, ends)
        costs = self._costs(kept)
        return Paths.through(self.product, self.prepared.graph, (before, nodes, costs, automata), starts, ends)

    def _edges(self, labels: np.ndarray) -> np.ndarray | None:
        """Return the system's edges that lead to labels, where they are known."""
        return None

    def _costs(self, labels: np.ndarray) -> np.ndarray:
        """Return the costs of labels, as in `Product.costs`."""
        costs: np.ndarray = self.labels.cost[labels]
        return costs

    def _start_of(self, label: int, automata: tuple[int, ...]) -> Start:
        """Return the start of a label without parent: one with its automaton states and its mu."""
        mu = self.labels.mu[label]
        starts = zip(self._starts, self.begin[:, 0], strict=True)
        return next(start for start, key in starts if key == mu and start.automata == automata)

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
