"""Label-setting search in Python's integers and fractions, for problems that 64 bits may not hold.

The compiled searches (`boa_star`, `multi_objective`, `ltmoa_star`) are used where bounds known beforehand, and a check
of every label, show that all sums are exact. Other problems are solved here: with the same labels, compared by the same
keys (`prefplan.preferences.objective`), and the max-min heuristic (equation 4), for numbers of any size, any number of
costs and preferences, and a hundred times slower.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from itertools import count, product
from typing import Any

from prefplan.front import Stats
from prefplan.limits import Limits, check_limits
from prefplan.preferences.objective import PreferenceObjective
from prefplan.preferences.terms import Term
from prefplan.problem import Problem
from prefplan.product.product_automaton import BARRED, Product
from prefplan.product.starts import Start
from prefplan.search.driver import Found
from prefplan.search.plan_extraction import account

BYTES_A_LABEL = 1500
"""Measured memory of a label with its key, and its share of the tables."""

CLOCK_PERIOD = 64
"""Labels expanded between two checks of the limits."""

LabelKey = tuple[Any, ...]
Counts = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class _Label:
    """A path: its product state, what was spent and paid, its parent and its last edge.

    What was spent, in all (`spent`) and until each task was satisfied (`finished`), has an entry for every cost.
    """

    state: int
    automata: tuple[int, ...]
    spent: Counts
    finished: tuple[Counts | None, ...]
    paid: Counts
    actions: int
    parent: _Label | None
    edge: int
    start: Start


class ExactSearch:
    """Search for all non-dominated vectors of costs and preferences, whatever numbers a problem has."""

    def __init__(self, product: Product, *, bounds: Mapping[str, Fraction]) -> None:
        """Make the search ready.

        Args:
            product: what is searched.
            bounds: inclusive, of objectives by name, in the user's units.
        """
        problem = product.problem
        self.product, self._objectives = product, problem.objectives
        self._units = problem.cost_units
        self._bounds = [bounds.get(name) for name in problem.objective_names]
        units = zip(problem.system.edge_costs, self._units, strict=True)
        columns = [edges.counts(unit).tolist() for edges, unit in units]
        self._costs: list[Counts] = list(zip(*columns, strict=True))
        self._expanded = self._generated = 0
        self._kept: dict[tuple[Any, ...], list[tuple[Counts, LabelKey]]] = {}

    @property
    def work(self) -> Stats:
        """What was done so far."""
        return Stats(len(self._kept), self._expanded, self._generated, self._generated * BYTES_A_LABEL)

    def goals(self, limits: Limits) -> Iterator[Found]:
        """Yield non-dominated goals in order of the first cost; stop early, with `limits.ended` set, at a limit."""
        order = count()
        waiting: list[tuple[int, int, int, LabelKey, _Label]] = []

        def enter(label: _Label) -> None:
            bound = self._bound(label)
            if bound is not None and self._is_within(bound) and self._keep(label):
                heapq.heappush(waiting, (bound[0], label.actions, next(order), bound, label))

        for label in self._starts():
            enter(label)
        pending: dict[LabelKey, _Label] = {}
        front: list[LabelKey] = []
        while waiting:
            estimate, _, _, bound, label = heapq.heappop(waiting)
            limits.complete_below = estimate
            if pending and estimate > next(iter(pending))[0]:
                yield from self._settled(pending)
            if self._expanded % CLOCK_PERIOD == 0 and (limits.out_of_time or self.work.bytes > limits.bytes):
                limits.ended = "time" if limits.out_of_time else "memory"
                return
            if any(_no_worse(goal, bound) for goal in reversed(front)) or self._superseded(label):
                continue
            if all(a in end for a, end in zip(label.automata, self._ends, strict=False)):
                front = [goal for goal in front if not _no_worse(bound, goal)] + [bound]
                pending = {goal: at for goal, at in pending.items() if not _no_worse(bound, goal)} | {bound: label}
                continue
            self._expanded += 1
            for after in self._successors(label):
                enter(after)
        yield from self._settled(pending)
        limits.complete_below = math.inf

    def _settled(self, pending: dict[LabelKey, _Label]) -> Iterator[Found]:
        """Yield goals of one cost that no other one dominates, and forget them."""
        for goal in sorted(pending):
            yield self._found(pending[goal], goal)
        pending.clear()

    def _bound(self, label: _Label) -> LabelKey | None:
        """Return lower bounds of the costs, in units, and preferences at the end; None if no goal can be reached."""
        rest = self._rest(label)
        if math.inf in rest:
            return None
        spent = (spent + int(more) for spent, more in zip(label.spent, rest, strict=True))
        return (*spent, *(self._mu(label, o) for o in self._objectives))

    def _is_within(self, bound: LabelKey) -> bool:
        """Return whether lower bounds of the objectives are within the user's bounds."""
        units = (*self._units, *(Fraction(1) for _ in self._objectives))
        within = zip(bound, units, self._bounds, strict=True)
        return all(limit is None or value * unit <= limit for value, unit, limit in within)

    @cached_property
    def _ends(self) -> list[list[int]]:
        """The accepting and the skipped state of each automaton."""
        return self.product.ends.tolist()

    def _starts(self) -> Iterator[_Label]:
        for start in self.product.starts:
            rest = (0,) * (len(self._units) - 1)
            spent = (start.spent, *rest)
            finished = tuple(None if c is None else (c, *rest) for c in start.finished)
            yield _Label(self.product.start_node, start.automata, spent, finished, start.violations, 0, None, -1, start)

    def _finished(
        self, automata: tuple[int, ...], spent: Counts, before: tuple[Counts | None, ...]
    ) -> tuple[Counts | None, ...]:
        """Return what had been spent when each task was satisfied, None for tasks that are not."""
        pairs = zip(before, automata, self._ends, strict=False)
        return tuple(spent if c is None and q == end[0] else c for c, q, end in pairs)

    def _successors(self, label: _Label) -> Iterator[_Label]:
        p = self.product
        for edge in p.problem.system.edges(label.state):
            target = int(p.targets[edge])
            spent = tuple(map(sum, zip(label.spent, self._costs[edge], strict=True)))
            for automata, prices in self._readings(label.automata, int(p.classes[target])):
                paid = tuple(a + b for a, b in zip(label.paid, prices, strict=True))
                finished = self._finished(automata, spent, label.finished)
                yield _Label(target, automata, spent, finished, paid, label.actions + 1, label, edge, label.start)

    def _readings(self, automata: tuple[int, ...], label: int) -> Iterator[tuple[tuple[int, ...], tuple[int, ...]]]:
        """Yield the automata's states after each way to read a label class, and its violation costs (P,)."""
        p, tasks = self.product, len(self._ends)
        readings: list[list[tuple[int, int]]] = []
        for i, q in enumerate(automata[:tasks]):
            bought = slice(p.extra_first[i, q, label], p.extra_first[i, q, label + 1])
            dear = zip(p.extra_state[bought].tolist(), p.extra_price[bought].tolist(), strict=True)
            readings.append([(int(p.delta[i, q, label]), 0), *dear])
        rules = tuple(int(p.rule_delta[r, q, label]) for r, q in enumerate(automata[tasks:]))
        tolls = tuple(int(p.tolls[r, automata[tasks + r], label]) for r in range(len(p.tolls)))
        for reading in product(*readings) if BARRED not in rules else ():
            yield (*(q for q, _ in reading), *rules), (*(price for _, price in reading), *tolls)

    def _values(self, label: _Label, objective: PreferenceObjective) -> tuple[list[Fraction], list[Fraction]]:
        """Return the task costs, in a preference's cost, and violation costs of a label in the user's units."""
        units, d = objective.units, objective.cost
        costs = [(label.spent if c is None else c)[d] * units.cost for c in label.finished]
        rules = [Fraction(0)] * (len(label.paid) - len(costs))
        return [*costs, *rules], [v * units.price for v in label.paid]

    def _mu(self, label: _Label, objective: PreferenceObjective) -> Any:
        return objective.measure.value(*self._values(label, objective))

    def _key(self, label: _Label) -> LabelKey:
        """Return what labels of one product state are compared by: less is better in every entry."""
        return tuple(entry for objective in self._objectives for entry in self._key_of(label, objective))

    def _key_of(self, label: _Label, objective: PreferenceObjective) -> LabelKey:
        """Return the entries for one preference."""
        measure = objective.measure
        if measure.contract == "general":
            return label.paid
        costs, paid = self._values(label, objective)
        if measure.bi_objective:
            return (measure.value(costs, paid),)
        single: list[Term] = [*measure.maxima, *(f for f in measure.formulas if f.contract != "componentwise")]
        mixed = [f for f in measure.formulas if f.contract == "componentwise"]
        frozen = [0 if c is None else c[objective.cost] for c in label.finished]
        return (
            measure.summed(costs, paid),
            *(term.value(costs, paid) for term in single),
            *(frozen[i] for i in sorted({i for f in mixed for i in f.costs})),
            *(label.paid[i] for i in sorted({i for f in mixed for i in f.violations})),
        )

    def _keep(self, label: _Label) -> bool:
        """Enter a label among those of its product state, unless it is dominated there or out of bounds."""
        spent, key = label.spent, self._key(label)
        rivals = self._kept.setdefault(self._place(label), [])
        if any(_no_worse(costs, spent) and _no_worse(other, key) for costs, other in rivals):
            return False
        rivals[:] = [(c, other) for c, other in rivals if not (_no_worse(spent, c) and _no_worse(key, other))]
        rivals.append((spent, key))
        self._generated += 1
        return True

    def _place(self, label: _Label) -> tuple[Any, ...]:
        """Return what must be equal for two labels to be compared."""
        general = sorted({o.cost for o in self._objectives if o.measure.contract == "general"})
        same = [(label.spent[d], *(c and c[d] for c in label.finished)) for d in general]
        return (label.state, label.automata, *same)

    def _superseded(self, label: _Label) -> bool:
        """Return whether a label was dominated after it was made."""
        return (label.spent, self._key(label)) not in self._kept[self._place(label)]

    def _rest(self, label: _Label) -> list[float]:
        """Return the largest cost-to-go of a single task (equation 4), for every cost."""
        nodes = self.product.problem.system.size
        cells = [label.state + nodes * q for q in label.automata[: len(self._ends)]]
        return [
            max(table.get(cell, math.inf) for table, cell in zip(tables, cells, strict=True))
            for tables in self._cost_to_go
        ]

    @cached_property
    def _cost_to_go(self) -> list[list[dict[int, int]]]:
        """By cost and task, the least cost from state + S * q until the task is satisfied or dropped, if any."""
        p, system = self.product, self.product.problem.system
        found = []
        for d in range(len(self._units)):
            into: dict[int, list[tuple[int, int]]] = {}
            for state in range(system.size):
                if state % CLOCK_PERIOD == 0:
                    check_limits()
                for edge in system.edges(state):
                    into.setdefault(int(p.targets[edge]), []).append((self._costs[edge][d], state))
            found.append([self._backward(i, into) for i in range(len(self._ends))])
        return found

    def _backward(self, i: int, into: dict[int, list[tuple[int, int]]]) -> dict[int, int]:
        """Return the cost-to-go of one task by Dijkstra, backwards on T x A_i from where it is satisfied or dropped."""
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
            if len(least) % CLOCK_PERIOD == 0:
                check_limits()
            q, state = divmod(cell, nodes)
            for before in sources.get((q, int(p.classes[state])), ()):
                for step, source in into.get(state, ()):
                    heapq.heappush(waiting, (cost + step, source + nodes * before))
        return least

    def _found(self, label: _Label, goal: LabelKey) -> Found:
        costs = len(self._units)
        exact = (*(c * unit for c, unit in zip(goal, self._units, strict=False)), *goal[costs:])
        edges, states = [], [label.automata]
        at = label
        while at.parent is not None:
            edges.append(at.edge)
            at = at.parent
            states.append(at.automata)
        plan = partial(account, self.product, edges[::-1], states[::-1], label.start)
        return Found(label.spent[0], None, plan, exact)


def needs_exact_numbers(problem: Problem) -> bool:
    """Return whether compiled code would round the keys of labels, or has no keys for a problem's formulas."""
    if problem.is_bi_objective:
        return problem.measure.rounds
    formulas = [formula for objective in problem.objectives for formula in objective.measure.formulas]
    return any(formula.contract != "componentwise" for formula in formulas)


def _no_worse(one: LabelKey, other: LabelKey) -> bool:
    return all(a <= b for a, b in zip(one, other, strict=True))
