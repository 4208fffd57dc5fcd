"""The entries of a label, by which labels are compared: their layout, and what they say about objectives.

| entries                  | how they grow                                                                         |
| ------------------------ | ------------------------------------------------------------------------------------- |
| every cost               | along each step                                                                       |
| mu of every preference   | as its only sum or maximum, if that is all (`Measure.bi_objective`); else computed    |
| sums and maxima          | of each other preference, see `prefplan.preferences.objective`                        |
| values of formulas       | of those declared additive or convex beside other terms; computed                     |
| costs of satisfied tasks | set when the task is satisfied; 0 before                                              |
| violation costs          | where they are paid                                                                   |

The first, up to the mu of every preference, are the objectives. If one label of a product state is no worse than
another in every entry that is *compared*, then so is each of its continuations in every objective. Under a general
contract, costs are compared in both directions: they must be equal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import count
from typing import Any

import numpy as np

from prefplan.preferences.objective import PreferenceObjective
from prefplan.preferences.terms import OpaqueTerm
from prefplan.problem import Problem
from prefplan.product.product_automaton import Product
from prefplan.product.starts import Start
from prefplan.search.growth import PRODUCT_LIMIT
from prefplan.search.multi_objective.entries import Entries


@dataclass(frozen=True)
class Value:
    """An entry computed from others.

    Attributes:
        objective: the preference that it belongs to.
        formulas: whose values are added.
        parts: entries that are added.
        entry: its place.
    """

    objective: PreferenceObjective
    formulas: tuple[OpaqueTerm, ...]
    parts: tuple[int, ...]
    entry: int


@dataclass(frozen=True)
class EntryMap:
    """The layout of the entries of labels.

    Attributes:
        problem: the problem whose objectives they are for.
        sums: the preference and the place of each entry that grows at a rate.
        maxima: for each maximum its preference, its number in that, and its place.
        values: the entries computed from others.
        frozen: for each entry of a satisfied task's cost, the cost and the task.
        paid: the task or rule of each entry of a violation cost; these are the last, after those in `frozen`.
        compared: the entries by which labels are compared, ~e for less of entry e.
        size: number of entries.
    """

    problem: Problem
    sums: tuple[tuple[PreferenceObjective, int], ...]
    maxima: tuple[tuple[PreferenceObjective, int, int], ...]
    values: tuple[Value, ...]
    frozen: tuple[tuple[int, int], ...]
    paid: tuple[int, ...]
    compared: tuple[int, ...]
    size: int

    @classmethod
    def of(cls, product: Product) -> EntryMap:
        """Return the entries that the objectives of a product's problem need."""
        problem = product.problem
        costs, objectives = len(problem.cost_names), problem.objectives
        free, compared = count(costs + len(objectives)), list(range(costs))
        sums, maxima, values = [], [], []
        for place, o in enumerate(objectives, costs):
            measure, parts = o.measure, list[int]()
            places = iter([place]) if measure.bi_objective else free
            if measure.one_entry:
                parts.append(next(places))
                sums.append((o, parts[-1]))
            for k in range(len(measure.maxima)):
                parts.append(next(places))
                maxima.append((o, k, parts[-1]))
            compared += parts
            if not measure.bi_objective:
                values.append(Value(o, measure.formulas, tuple(parts), place))
            for formula in measure.formulas:
                if formula.contract in ("additive", "convex"):
                    if parts or len(measure.formulas) > 1:
                        values.append(Value(o, (formula,), (), next(free)))
                    compared.append(values[-1].entry)
        mentioned, same, payers = _mentioned(objectives, ("additive", "convex", "componentwise", "general"))
        ordered, _, weighed = _mentioned(objectives, ("componentwise", "general"))
        paying = product.relaxed or len(product.tolls) > 0 or any(any(start.violations) for start in product.starts)
        frozen, paid = tuple(sorted(mentioned)), tuple(sorted(payers)) if paying else ()
        first = next(free)
        compared += [first + c for c, entry in enumerate(frozen) if entry in ordered]
        compared += [first + len(frozen) + v for v, i in enumerate(paid) if i in weighed]
        opposed = [~d for d in sorted(same)] + [~(first + c) for c, (d, _) in enumerate(frozen) if d in same]
        size = first + len(frozen) + len(paid)
        return cls(problem, tuple(sums), tuple(maxima), tuple(values), frozen, paid, (*opposed, *compared), size)

    @property
    def costs(self) -> int:
        """Number of costs."""
        return len(self.problem.cost_names)

    @property
    def first_frozen(self) -> int:
        """Place of the first entry of a satisfied task's cost."""
        return self.size - len(self.paid) - len(self.frozen)

    @property
    def first_paid(self) -> int:
        """Place of the first entry of a violation cost."""
        return self.size - len(self.paid)

    def begin(self, start: Start, shift: int) -> list[int]:
        """Return the entries of a start's label, 0 for computed ones; the first cost has `shift` more low bits."""
        entries = [0] * self.size
        entries[0] = start.spent << shift
        for o, entry in self.sums:
            entries[entry] = int(o.measure.summed(*start.amounts(o)) / o.units.mu)
        for o, k, entry in self.maxima:
            entries[entry] = int(o.measure.maxima[k].value(*start.amounts(o)) / o.units.mu)
        entries[self.first_frozen : self.first_paid] = [0 if d else start.finished[i] or 0 for d, i in self.frozen]
        entries[self.first_paid :] = [start.violations[i] for i in self.paid]
        return entries

    def amounts(self, objective: PreferenceObjective, entries: list[int]) -> tuple[list[Fraction], list[Fraction]]:
        """Return the costs and violation costs that a preference mentions, (P,) each, in the user's units.

        Args:
            objective: the preference.
            entries: of a label, in units, with what is spent as the cost of every task that is not satisfied.
        """
        tasks, rules = len(self.problem.tasks), len(self.problem.priced) - len(self.problem.tasks)
        costs = [entries[objective.cost] * objective.units.cost] * tasks + [Fraction(0)] * rules
        for entry, (cost, i) in enumerate(self.frozen, self.first_frozen):
            if cost == objective.cost:
                costs[i] = entries[entry] * objective.units.cost
        violations = [Fraction(0)] * len(costs)
        for entry, i in enumerate(self.paid, self.first_paid):
            violations[i] = entries[entry] * objective.units.price
        return costs, violations

    def objectives(self, entries: list[int]) -> tuple[Any, ...]:
        """Return the exact objectives of a goal, in the user's units; `entries` are as for `amounts`."""
        found: list[Any] = [unit * spent for unit, spent in zip(self.problem.cost_units, entries, strict=False)]
        for place, o in enumerate(self.problem.objectives, self.costs):
            mu = o.measure.constant
            if o.measure.is_whole:
                mu += entries[place] * o.units.mu
            else:
                value = next(value for value in self.values if value.entry == place)
                mu += sum(entries[part] for part in value.parts) * o.units.mu
                mu = sum((formula.value(*self.amounts(o, entries)) for formula in value.formulas), mu)
            found.append(mu)
        return tuple(found)

    def arrays(self, columns: Sequence[np.ndarray], order: Sequence[int], compared: Sequence[int]) -> Entries:
        """Return the entries as arrays for the kernel.

        Args:
            columns: each of the costs, in units, of edges or actions; none where successors come with their only cost.
            order: the objectives in the order of comparison.
            compared: the entries by which labels of a product state are compared.
        """
        sets, priced = 2 ** len(self.problem.tasks), len(self.problem.priced)
        late = [(s, o, term) for s, (o, _) in enumerate(self.sums) for term in o.measure.tardiness]
        late_tasks = [(s, term.task) for s, _, term in late]
        slopes = [int(term.weight * o.units.factor) for _, o, term in late]
        offsets = [min(int(term.weight * term.by / o.units.mu), PRODUCT_LIMIT) for _, o, term in late]
        maximum = [o.measure.maximum_table(o.units.factor)[k] for o, k, _ in self.maxima]
        largest = [1] * self.costs
        for (_, o, _), slope in zip(late, slopes, strict=True):
            largest[o.cost] = max(largest[o.cost], slope)
        for (o, _, _), table in zip(self.maxima, maximum, strict=True):
            largest[o.cost] = max(largest[o.cost], int(table.max(initial=1)))
        violation = [[int(w * o.units.price / o.units.mu) for w in o.measure.violation_weights] for o, _ in self.sums]
        return Entries(
            edge_costs=np.stack(columns) if columns else np.zeros((1, 0), np.int64),
            sums=_table([(entry, o.cost) for o, entry in self.sums], 2),
            rate=_table([o.measure.rate_table(o.units.factor) for o, _ in self.sums], sets),
            violation=_table(violation, priced),
            late=_table([(*pair, *line) for pair, *line in zip(late_tasks, slopes, offsets, strict=True)], 4),
            maxima=_table([(entry, o.cost) for o, _, entry in self.maxima], 2),
            maximum=_table(maximum, sets),
            frozen=_table(self.frozen, 2),
            paid=np.array(self.paid, np.int64),
            cost_limit=np.array([PRODUCT_LIMIT // most for most in largest], np.int64),
            order=np.array(order, np.int64),
            compared=np.array(compared, np.int64),
        )


def _mentioned(
    objectives: Sequence[PreferenceObjective], contracts: Sequence[str]
) -> tuple[set[tuple[int, int]], set[int], set[int]]:
    """Return what formulas with some contracts are about.

    Returns:
        each cost and task of which the cost of a satisfied task matters; the costs of preferences with a general
        contract; the tasks and rules whose violation costs matter.
    """
    costs, same, paid = set[tuple[int, int]](), set[int](), set[int]()
    for o in objectives:
        for formula in (formula for formula in o.measure.formulas if formula.contract in contracts):
            costs |= {(o.cost, i) for i in formula.costs}
            paid |= set(formula.violations)
        if o.measure.contract == "general":
            same.add(o.cost)
            costs |= {(o.cost, i) for i in range(o.measure.tasks)}
            paid |= set(range(len(o.measure.violation_weights)))
    return costs, same, paid


def _table(rows: Any, width: int) -> np.ndarray:
    """Return (n, width) int64 rows; n may be 0."""
    return np.array(list(rows), dtype=np.int64).reshape(-1, width)
