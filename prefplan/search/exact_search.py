"""Label-setting search in Python's integers and fractions, for problems that 64 bits may not hold.

The compiled searches (`boa_star`, `multi_objective`) are used where bounds that are known beforehand, and a check of
every label, show that no sum leaves the range of exact numbers. Everything else comes here: the same labels, compared
by the same keys (`prefplan.preferences.objective`), and the max-min heuristic (equation 4), without any bound on the
size or the digits of numbers, and a hundred times slower.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import count, product
from typing import Any

from prefplan.front import Stats
from prefplan.limits import Limits
from prefplan.preferences.terms import Term
from prefplan.product.product_automaton import Product, Start
from prefplan.search.driver import Found
from prefplan.search.plan_extraction import account

BYTES_A_LABEL = 1500
"""Measured: a label with its key, and its share of the tables."""

CLOCK_PERIOD = 256
"""Labels taken from the open list between two looks at the clock."""

Key = tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class _Label:
    """A path: where it leads, what was spent and paid, and the path before with the edge that prolonged it."""

    state: int
    automata: tuple[int, ...]
    cost: int
    finished: tuple[int | None, ...]
    paid: tuple[int, ...]
    actions: int
    parent: _Label | None
    edge: int
    start: Start


class ExactSearch:
    """Search for all non-dominated (cost, mu), whatever numbers a problem has."""

    def __init__(self, product: Product, *, max_mu: Fraction | None = None, max_cost: float = math.inf) -> None:
        """Make the search ready.

        Args:
            product: what is searched.
            max_mu: inclusive bound of mu in the user's units.
            max_cost: inclusive bound of the total cost, in units.
        """
        self.product, self._max_mu, self._max_cost = product, max_mu, max_cost
        self._measure = product.problem.measure
        self._costs = [int(cost) >> product.shift for cost in product.costs.tolist()]
        self._general = self._measure.contract == "general"
        self._expanded = self._generated = 0
        self._kept: dict[tuple[int, tuple[int, ...]], list[tuple[int, Key]]] = {}

    @property
    def work(self) -> Stats:
        """What was done so far."""
        return Stats(len(self._kept), self._expanded, self._generated, self._generated * BYTES_A_LABEL)

    def goals(self, limits: Limits) -> Iterator[Found]:
        """Yield non-dominated goals in order of cost; stop early, with `limits.ended` set, at a limit."""
        order = count()
        waiting: list[tuple[float, int, int, _Label]] = []

        def enter(label: _Label) -> None:
            rest = self._rest(label)
            if rest < math.inf and label.cost + rest <= self._max_cost and self._keep(label):
                heapq.heappush(waiting, (label.cost + rest, label.actions, next(order), label))

        for label in self._starts():
            enter(label)
        pending: Found | None = None
        least: Any = None
        while waiting:
            estimate, _, _, label = heapq.heappop(waiting)
            limits.complete_below = estimate
            if pending and estimate > pending.cost:
                yield pending
                pending = None
            if (limits.out_of_time or self.work.bytes > limits.bytes) and self._expanded % CLOCK_PERIOD == 0:
                limits.ended = "time" if limits.out_of_time else "memory"
                return
            mu = self._mu(label)
            if (least is not None and mu >= least) or self._superseded(label):
                continue
            if all(a in end for a, end in zip(label.automata, self._ends, strict=True)):
                pending, least = self._found(label), mu
                continue
            self._expanded += 1
            for after in self._successors(label):
                enter(after)
        if pending:
            yield pending
        limits.complete_below = math.inf

    @cached_property
    def _ends(self) -> list[list[int]]:
        """The accepting and the skipped state of each automaton."""
        return self.product.ends.tolist()

    def _starts(self) -> Iterator[_Label]:
        for start in self.product.starts:
            state, automata = self.product.decode(start.code)
            yield _Label(state, automata, 0, self._finished(automata, 0, None), start.violations, 0, None, -1, start)

    def _finished(
        self, automata: tuple[int, ...], cost: int, before: tuple[int | None, ...] | None
    ) -> tuple[int | None, ...]:
        """Return what had been spent when each task was satisfied, None for those that are not."""
        before = before or (None,) * len(automata)
        return tuple(
            cost if c is None and q == end[0] else c for c, q, end in zip(before, automata, self._ends, strict=True)
        )

    def _successors(self, label: _Label) -> Iterator[_Label]:
        p = self.product
        for edge in p.problem.system.edges(label.state):
            target, cost = int(p.targets[edge]), label.cost + self._costs[edge]
            for automata, prices in self._readings(label.automata, int(p.classes[target])):
                paid = tuple(a + b for a, b in zip(label.paid, prices, strict=True))
                finished = self._finished(automata, cost, label.finished)
                yield _Label(target, automata, cost, finished, paid, label.actions + 1, label, edge, label.start)

    def _readings(self, automata: tuple[int, ...], label: int) -> Iterator[tuple[tuple[int, ...], tuple[int, ...]]]:
        """Yield the automata's states after each way to read a label class, and the price of it for each task."""
        p = self.product
        readings: list[list[tuple[int, int]]] = []
        for i, q in enumerate(automata):
            bought = slice(p.extra_first[i, q, label], p.extra_first[i, q, label + 1])
            dear = zip(p.extra_state[bought].tolist(), p.extra_price[bought].tolist(), strict=True)
            readings.append([(int(p.delta[i, q, label]), 0), *dear])
        for reading in product(*readings):
            yield tuple(q for q, _ in reading), tuple(price for _, price in reading)

    def _values(self, label: _Label) -> tuple[list[Fraction], list[Fraction]]:
        """Return the task costs and violation costs of a label in the user's units."""
        units = self.product.units
        costs = [(label.cost if c is None else c) * units.cost for c in label.finished]
        return costs, [v * units.price for v in label.paid]

    def _mu(self, label: _Label) -> Any:
        return self._measure.value(*self._values(label))

    def _key(self, label: _Label) -> Key:
        """Return what labels of one product state are compared by: less is better in every entry."""
        measure = self._measure
        if self._general:
            return label.paid
        costs, paid = self._values(label)
        if measure.bi_objective:
            return (measure.value(costs, paid),)
        single: list[Term] = [*measure.maxima, *(f for f in measure.formulas if f.contract != "componentwise")]
        mixed = [f for f in measure.formulas if f.contract == "componentwise"]
        frozen = [0 if c is None else c for c in label.finished]
        return (
            sum((term.value(costs, paid) for term in measure.terms if term not in (*single, *mixed)), Fraction(0)),
            *(term.value(costs, paid) for term in single),
            *(frozen[i] for i in sorted({i for f in mixed for i in f.costs})),
            *(label.paid[i] for i in sorted({i for f in mixed for i in f.violations})),
        )

    def _keep(self, label: _Label) -> bool:
        """Enter a label among those of its product state, unless it is dominated there or out of bounds."""
        if self._max_mu is not None and self._mu(label) > self._max_mu:
            return False
        key = self._key(label)
        rivals = self._kept.setdefault(self._place(label), [])
        if any(cost <= label.cost and _no_worse(other, key) for cost, other in rivals):
            return False
        rivals[:] = [(c, other) for c, other in rivals if not (label.cost <= c and _no_worse(key, other))]
        rivals.append((label.cost, key))
        self._generated += 1
        return True

    def _place(self, label: _Label) -> tuple[Any, ...]:
        """Return what two labels must share to be compared."""
        same = (label.cost, label.finished) if self._general else ()
        return (label.state, label.automata, *same)

    def _superseded(self, label: _Label) -> bool:
        """Return whether a label was dominated after it was made."""
        return (label.cost, self._key(label)) not in self._kept[self._place(label)]

    def _rest(self, label: _Label) -> float:
        """Return the largest cost-to-go of a single task (equation 4)."""
        size = self.product.problem.system.size
        cells = zip(self._cost_to_go, label.automata, strict=True)
        return max(table.get(label.state + size * q, math.inf) for table, q in cells)

    @cached_property
    def _cost_to_go(self) -> list[dict[int, int]]:
        """For each task the least cost from state + S * q until it is satisfied or dropped; absent where never."""
        p, system = self.product, self.product.problem.system
        into: dict[int, list[tuple[int, int]]] = {}
        for state in range(system.size):
            for edge in system.edges(state):
                into.setdefault(int(p.targets[edge]), []).append((self._costs[edge], state))
        return [self._backward(i, into) for i in range(len(self._ends))]

    def _backward(self, i: int, into: dict[int, list[tuple[int, int]]]) -> dict[int, int]:
        """Dijkstra from where a task is satisfied or dropped, backwards on T x A_i."""
        p, nodes = self.product, self.product.problem.system.size
        sources: dict[tuple[int, int], list[int]] = {}
        for q in range(int(p.sizes[i])):
            for label in range(p.delta.shape[2]):
                bought = slice(p.extra_first[i, q, label], p.extra_first[i, q, label + 1])
                for after in {int(p.delta[i, q, label]), *p.extra_state[bought].tolist()}:
                    sources.setdefault((after, label), []).append(q)
        least: dict[int, int] = {}
        waiting = [(0, state + nodes * q) for q in self._ends[i] if q >= 0 for state in range(nodes)]
        while waiting:
            cost, cell = heapq.heappop(waiting)
            if cell in least:
                continue
            least[cell] = cost
            q, state = divmod(cell, nodes)
            for before in sources.get((q, int(p.classes[state])), ()):
                for step, source in into.get(state, ()):
                    heapq.heappush(waiting, (cost + step, source + nodes * before))
        return least

    def _found(self, label: _Label) -> Found:
        edges, states = [], [label.automata]
        at = label
        while at.parent is not None:
            edges.append(at.edge)
            at = at.parent
            states.append(at.automata)
        return Found(label.cost, None, lambda: account(self.product, edges[::-1], states[::-1], label.start))


def _no_worse(one: Key, other: Key) -> bool:
    return all(a <= b for a, b in zip(one, other, strict=True))
