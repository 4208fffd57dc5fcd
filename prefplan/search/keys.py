"""The entries of a label key, and how the objectives follow from them.

| entries              | how they grow                                                                         |
| -------------------- | ------------------------------------------------------------------------------------- |
| every cost           | along each step                                                                       |
| mu of every          | as its only sum or maximum, if that is all (`Measure.bi_objective`); else a value,    |
| preference           | computed from others                                                                  |
| sums and maxima      | of each other preference, see `prefplan.preferences.objective`                        |
| values of formulas   | of those declared additive or convex beside other terms                               |
| costs of tasks       | with the cost, until the task is satisfied                                            |
| violation costs      | where they are paid                                                                   |

The first entries, every cost and every mu, are the objectives. If one label of a product state is no worse than another
in every *compared* entry, then each of its continuations is no worse in every objective than the same continuation of
the other. Under a general contract, costs are compared in both directions: they must be equal.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from prefplan.preferences.objective import Measure
from prefplan.preferences.terms import OpaqueTerm
from prefplan.problem import Problem
from prefplan.product.product_automaton import Product, Start
from prefplan.search.labels import COST, MAXIMUM, PRODUCT_LIMIT, SUM, TASK, VALUE, VIOLATION, Keys

FALL = 2**19
"""How far an `ordered_number` may fall by rounding: 1e-9 relative."""


def ordered_number(value: float) -> int:
    """Return an integer below INFINITE that is ordered as floats >= 0 are, but for their last three bits."""
    return int(struct.unpack("<q", struct.pack("<d", value))[0]) >> 3


@dataclass(frozen=True)
class KeyEntry:
    """An entry of a key.

    Attributes:
        how: how the entry grows, one of COST .. VALUE of `labels`.
        cost: number of the cost that it grows with.
        number: number of the task or rule, or of the maximum among the maxima of its preference.
        objective: the preference that it belongs to, if it belongs to one only.
        formulas: for a value, the formulas whose values are added.
        parts: for a value, the entries that are added.
    """

    how: int
    cost: int = 0
    number: int = 0
    objective: Measure | None = None
    formulas: tuple[OpaqueTerm, ...] = ()
    parts: tuple[int, ...] = ()


@dataclass(frozen=True)
class KeyMap:
    """The layout of label keys.

    Attributes:
        problem: the problem.
        shift: number of low bits of the first cost, which count actions.
        entries: entries of a key.
        compared: the entries by which labels are compared; ~e to compare entry e in the opposite direction.
    """

    problem: Problem
    shift: int
    entries: tuple[KeyEntry, ...]
    compared: tuple[int, ...]

    @classmethod
    def of(cls, product: Product) -> KeyMap:
        """Return the layout with the entries that the objectives of a product's problem need."""
        problem, costs = product.problem, len(product.problem.cost_names)
        entries = [KeyEntry(COST, d) for d in range(costs)]
        # The mu of every preference comes next; it is replaced where it is computed from others.
        entries += [_entries(o)[0] if o.bi_objective else KeyEntry(VALUE) for o in problem.objectives]
        compared = list(range(costs))
        for place, o in enumerate(problem.objectives, costs):
            if o.bi_objective:
                compared.append(place)
                continue
            parts = range(len(entries), len(entries) + len(_entries(o)))
            entries += _entries(o)
            compared += parts
            entries[place] = KeyEntry(VALUE, o.cost, 0, o, o.formulas, tuple(parts))
            for formula in o.formulas:
                if formula.contract in ("additive", "convex"):
                    is_whole_value = not parts and len(o.formulas) == 1
                    compared.append(place if is_whole_value else len(entries))
                    entries += [] if is_whole_value else [KeyEntry(VALUE, o.cost, 0, o, (formula,))]
        mentioned, same, payers = _mentioned(problem, ("additive", "convex", "componentwise", "general"))
        ordered, _, weighed = _mentioned(problem, ("componentwise", "general"))
        paying = len(product.tables.tolls) or any(any(start.violations) for start in product.starts)
        opposed = [~d for d in sorted(same)]
        for d, i in sorted(mentioned):
            compared += [len(entries)] if (d, i) in ordered else []
            opposed += [~len(entries)] if d in same else []
            entries.append(KeyEntry(TASK, d, i))
        for i in sorted(payers) if paying else ():
            compared += [len(entries)] if i in weighed else []
            entries.append(KeyEntry(VIOLATION, 0, i))
        return cls(problem, product.graph.shift, tuple(entries), (*opposed, *compared))

    def place(self, how: int, cost: int, number: int) -> int | None:
        """Return the place of the entry of a task's cost or of a violation cost; None if there is none."""
        wanted = how, cost, number
        return next((e for e, each in enumerate(self.entries) if (each.how, each.cost, each.number) == wanted), None)

    def begin(self, start: Start) -> list[int]:
        """Return the key of a start's label, 0 for values."""
        return [self._begin(each, start) << (0 if e else self.shift) for e, each in enumerate(self.entries)]

    def _begin(self, each: KeyEntry, start: Start) -> int:
        if each.how == COST:
            # The past has the first cost only.
            return 0 if each.cost else start.spent
        if each.how == TASK:
            return start.task_costs(each.cost)[each.number]
        if each.how == VIOLATION:
            return start.violations[each.number]
        if each.how == VALUE or each.objective is None:
            return 0
        measure = each.objective
        amounts = each.objective.amounts(start.task_costs(each.cost), start.violations)
        value = measure.summed(*amounts) if each.how == SUM else measure.maxima[each.number].value(*amounts)
        return int(value / each.objective.unit)

    def amounts(self, objective: Measure, key: Sequence[int]) -> tuple[list[Fraction], list[Fraction]]:
        """Return the costs and violation costs that a preference mentions, (P,) each, in the user's units.

        The `key` is a label's, with the first cost in units.
        """
        costs, violations = [key[objective.cost]] * len(self.problem.tasks), [0] * len(self.problem.priced)
        for each, count in zip(self.entries, key, strict=True):
            if each.how == TASK and each.cost == objective.cost:
                costs[each.number] = count
            elif each.how == VIOLATION:
                violations[each.number] = count
        return objective.amounts(costs, violations)

    def objectives(self, key: Sequence[int]) -> tuple[Any, ...]:
        """Return the exact objectives of a label with a key, in the user's units."""
        key = [key[0] >> self.shift, *key[1:]]
        objectives: list[Any] = [unit * spent for unit, spent in zip(self.problem.cost_units, key, strict=False)]
        for place, o in enumerate(self.problem.objectives, len(self.problem.cost_names)):
            mu = o.constant
            if o.is_whole:
                mu += key[place] * o.unit
            else:
                value = self.entries[place]
                mu += sum(key[part] for part in value.parts) * o.unit
                mu = sum((formula.value(*self.amounts(o, key)) for formula in value.formulas), mu)
            objectives.append(mu)
        return tuple(objectives)

    def arrays(
        self,
        columns: Sequence[np.ndarray],
        *,
        first: int,
        compared: Sequence[int],
        lexicographic: bool,
    ) -> Keys:
        """Return the layout as arrays for the kernel, without `evaluate`; arguments as in `Keys`.

        `columns` has, for every cost, the costs in units of all edges or prices; it is empty where successors come with
        their only cost.
        """
        rates, late, largest = list[np.ndarray](), list[tuple[int, int, int, int]](), 1
        entries = np.zeros((len(self.entries), 3), np.int64)
        violation = np.zeros((len(self.entries), len(self.problem.priced)), np.int64)
        for e, each in enumerate(self.entries):
            entries[e] = each.how, each.cost, each.number if each.how == TASK else len(rates)
            if each.how == VIOLATION:
                violation[e, each.number] = 1
            if each.objective is None or each.how == VALUE:
                continue
            measure = each.objective
            if each.how == SUM:
                rates.append(measure.rates(measure.rate_terms))
                violation[e] = [int(w * measure.price_unit / measure.unit) for w in measure.violation_weights]
                late += [
                    (e, t.task, int(t.weight * measure.factor), min(int(t.weight * t.by / measure.unit), PRODUCT_LIMIT))
                    for t in measure.tardiness
                ]
            else:
                rates.append(measure.rates([measure.maxima[each.number]]))
                largest = max(largest, int(rates[-1].max()))
        return Keys(
            entries=entries,
            rates=np.array(rates or np.zeros((0, 1)), dtype=np.int64),
            late=np.array(late, dtype=np.int64).reshape(-1, 4),
            violation=violation,
            edge_costs=np.stack(columns) if columns else np.zeros((1, 0), np.int64),
            compared=np.array(compared, np.int64),
            shift=self.shift,
            objectives=len(self.problem.objective_names),
            first=first,
            lexicographic=lexicographic,
            lazy=len(self.problem.objective_names) > 2 and not lexicographic,
            cost_limit=PRODUCT_LIMIT // max([largest, *(slope for _, _, slope, _ in late)]),
            computed=any(each.how == VALUE for each in self.entries),
            evaluate=None,
        )


def _entries(o: Measure) -> list[KeyEntry]:
    """Return the sum and the maxima of a preference; an empty sum if the preference has no terms at all."""
    maxima = [KeyEntry(MAXIMUM, o.cost, k, o) for k in range(len(o.maxima))]
    empty = o.bi_objective and not maxima
    return [*([KeyEntry(SUM, o.cost, 0, o)] if o.one_entry or empty else []), *maxima]


def _mentioned(problem: Problem, contracts: Sequence[str]) -> tuple[set[tuple[int, int]], set[int], set[int]]:
    """Return which task costs and violation costs matter to formulas with some contracts.

    Returns:
        pairs (cost, task) of the task costs that matter; the costs of preferences with a general contract; the tasks
        and rules whose violation costs matter.
    """
    costs, same, violations = set[tuple[int, int]](), set[int](), set[int]()
    for o in problem.objectives:
        for formula in (formula for formula in o.formulas if formula.contract in contracts):
            costs |= {(o.cost, i) for i in formula.costs}
            violations |= set(formula.violations)
        if o.contract == "general":
            same.add(o.cost)
            costs |= {(o.cost, i) for i in range(o.tasks)}
            violations |= set(range(len(o.violation_weights)))
    return costs, same, violations
