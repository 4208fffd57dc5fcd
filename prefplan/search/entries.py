"""The entries of a label's key with several costs or preferences (`ltmoa_star`), and how they grow.

They are: every cost; for each preference the sum of its additive terms; each maximum; and for formulas the costs of
satisfied tasks and the violation costs that they mention (`prefplan.preferences.objective`). If one label of a product
state is no worse than another in every entry, then so is each of its continuations in every objective.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from prefplan.preferences.objective import PreferenceObjective
from prefplan.problem import Problem
from prefplan.product.kernels import Integer, bare_kernel
from prefplan.product.starts import Start
from prefplan.search.labels import COLUMNS, PRODUCT_LIMIT

# Columns of a product state's row after those of `labels`: where its truncated vectors begin, how many there are, how
# many there is memory for, and the bounds of the entries that have one.
FIRST, SIZE, CAPACITY, BOUND = range(COLUMNS, COLUMNS + 4)


class Entries(NamedTuple):
    """The K entries of a label: [costs, additive, maxima, costs of satisfied tasks, violation costs].

    Attributes:
        edge_costs: (D, E) int64, costs of each edge, or of each price where states are generated;
            (1, 0) where successors come with their only cost.
        of: (A,) int64, the cost that each additive entry grows with. rate: (A, 2^N) int64, units of mu for each unit of
            it. violation: (A, N) int64, units of mu for each unit of violation cost.
        late: (L, 2) int64, additive entry and task of each deadline, late_slope: (L,) int64, late_offset: (L,) int64:
            tardiness is max(0, slope * cost - offset).
        of_maximum: (M,) int64, the cost of each maximum. maximum: (M, 2^N) int64, by satisfied set: the maximum is at
            least this times the cost.
        frozen: (C, 2) int64, the cost and the task of each entry for the cost of a satisfied task.
        paid: (V,) int64, the task of each entry for a violation cost.
        cost_limit: (D,) int64, from this cost on a product with it might not fit 64 bits.
        order: (K,) int64, the entries in the order of comparison.
        compared: (W,) int64, the entries of the truncated vectors, by which labels of a product state are compared.
    """

    edge_costs: np.ndarray
    of: np.ndarray
    rate: np.ndarray
    violation: np.ndarray
    late: np.ndarray
    late_slope: np.ndarray
    late_offset: np.ndarray
    of_maximum: np.ndarray
    maximum: np.ndarray
    frozen: np.ndarray
    paid: np.ndarray
    cost_limit: np.ndarray
    order: np.ndarray
    compared: np.ndarray


class Paths(NamedTuple):
    """Labels.

    Attributes:
        row: (L,) int32, of the product state. parent: (L,) int32, or -1.
        step: (L,) int32, the last edge, or the index of its costs; of a label without parent, its start.
        key: (L, K) int64, entries; costs of tasks that are not satisfied are entered as 0.
    """

    row: np.ndarray
    parent: np.ndarray
    step: np.ndarray
    key: np.ndarray


@dataclass(frozen=True)
class EntryMap:
    """The layout of the entries of labels.

    Attributes:
        problem: the problem whose objectives they are for.
        costs: number of costs.
        additive: the preferences with an additive entry, in the order of these.
        maxima: for each maximum entry, the preference and the number of the maximum in it.
        frozen: for each entry of a satisfied task's cost, the cost and the task.
        paid: the task of each entry of a violation cost.
    """

    problem: Problem
    costs: int
    additive: tuple[PreferenceObjective, ...]
    maxima: tuple[tuple[PreferenceObjective, int], ...]
    frozen: tuple[tuple[int, int], ...]
    paid: tuple[int, ...]

    @classmethod
    def of(cls, problem: Problem) -> EntryMap:
        """Return the entries that a problem's objectives need."""
        objectives = problem.objectives
        mentioned = [(o.cost, f) for o in objectives for f in o.measure.formulas]
        return cls(
            problem,
            len(problem.cost_names),
            tuple(o for o in objectives if not (o.measure.bi_objective and o.measure.maxima)),
            tuple((o, k) for o in objectives for k in range(len(o.measure.maxima))),
            tuple(sorted({(cost, i) for cost, f in mentioned for i in f.costs})),
            tuple(sorted({i for _, f in mentioned for i in f.violations})),
        )

    @property
    def count(self) -> int:
        """Number of entries."""
        return self.costs + len(self.additive) + len(self.maxima) + len(self.frozen) + len(self.paid)

    def alone(self, objective: PreferenceObjective) -> int | None:
        """Return the entry that by itself gives a preference's value, or None."""
        if not objective.measure.bi_objective:
            return None
        if objective in self.additive:
            return self.costs + self.additive.index(objective)
        return self.costs + len(self.additive) + self.maxima.index((objective, 0))

    def value(self, objective: PreferenceObjective, entries: list[int], spent: list[int]) -> Any:
        """Return the exact value of a preference at a goal.

        Args:
            objective: the preference.
            entries: of the goal.
            spent: every total cost, in units.
        """
        units, measure, first = objective.units, objective.measure, self.costs
        value = measure.constant
        if objective in self.additive:
            value += entries[first + self.additive.index(objective)] * units.mu
        first += len(self.additive)
        for m, (owner, _) in enumerate(self.maxima):
            if owner is objective:
                value += entries[first + m] * units.mu
        first += len(self.maxima)
        costs = [Fraction(0)] * len(self.problem.priced)
        for c, (cost, i) in enumerate(self.frozen):
            if cost == objective.cost:
                costs[i] = entries[first + c] * units.cost
        first += len(self.frozen)
        violations = [Fraction(0)] * len(self.problem.priced)
        for v, i in enumerate(self.paid):
            violations[i] = entries[first + v] * units.price
        return sum((formula.value(costs, violations) for formula in measure.formulas), value)

    def begin(self, start: Start, shift: int) -> list[int]:
        """Return the entries of a start's label; costs have `shift` more low bits."""
        entries = [start.spent << shift, *[0] * (self.costs - 1)]
        for o in self.additive:
            entries.append(int(o.measure.summed(*start.amounts(o)) / o.units.mu))
        for o, k in self.maxima:
            entries.append(int(o.measure.maxima[k].value(*start.amounts(o)) / o.units.mu))
        entries += [0 if cost else start.finished[i] or 0 for cost, i in self.frozen]
        return entries + [start.violations[i] for i in self.paid]

    def arrays(
        self, columns: Sequence[np.ndarray], order: Sequence[int], compared: Sequence[int], *, numbered: bool
    ) -> Entries:
        """Return the entries as arrays for the kernel.

        Args:
            columns: each of the costs, in units, of edges or actions.
            order: of comparison.
            compared: the entries by which labels of a product state are compared.
            numbered: whether successors come with the number of an edge or action in place of a cost.
        """
        sets, priced = 2 ** len(self.problem.tasks), len(self.problem.priced)
        late = [(a, term) for a, o in enumerate(self.additive) for term in o.measure.tardiness]
        units = [self.additive[a].units for a, _ in late]
        maximum = [o.measure.maximum_table(o.units.factor)[k] for o, k in self.maxima]
        slopes = [int(term.weight * unit.factor) for (_, term), unit in zip(late, units, strict=True)]
        offsets = [term.weight * term.by / unit.mu for (_, term), unit in zip(late, units, strict=True)]
        largest = [1] * self.costs
        for (a, _), slope in zip(late, slopes, strict=True):
            largest[self.additive[a].cost] = max(largest[self.additive[a].cost], slope)
        for (o, _), table in zip(self.maxima, maximum, strict=True):
            largest[o.cost] = max(largest[o.cost], int(table.max(initial=1)))
        violation = [[int(w * o.units.price / o.units.mu) for w in o.measure.violation_weights] for o in self.additive]
        return Entries(
            edge_costs=np.stack(columns) if numbered else np.zeros((1, 0), np.int64),
            of=np.array([o.cost for o in self.additive], np.int64),
            rate=_table([o.measure.rate_table(o.units.factor) for o in self.additive], sets),
            violation=_table(violation, priced),
            late=_table([(a, term.task) for a, term in late], 2),
            late_slope=np.array(slopes, np.int64),
            late_offset=np.array([min(int(offset), PRODUCT_LIMIT) for offset in offsets], np.int64),
            of_maximum=np.array([o.cost for o, _ in self.maxima], np.int64),
            maximum=_table(maximum, sets),
            frozen=_table(self.frozen, 2),
            paid=np.array(self.paid, np.int64),
            cost_limit=np.array([PRODUCT_LIMIT // most for most in largest], np.int64),
            order=np.array(order, np.int64),
            compared=np.array(compared, np.int64),
        )


def _table(rows: Any, width: int) -> np.ndarray:
    """Return (n, width) int64 rows; n may be 0."""
    return np.array(list(rows), dtype=np.int64).reshape(-1, width)


@bare_kernel
def follow(
    shift: Integer,
    entries: Entries,
    satisfied: Integer,
    step: Integer,
    violation: np.ndarray,
    pays: bool,
    key: np.ndarray,
) -> bool:
    """Replace a label's entries by those of a successor, except costs of tasks that become satisfied (see `freeze`).

    Args:
        shift: number of low bits of the first cost.
        entries: the layout of a key.
        satisfied: the tasks that were satisfied before, as bits.
        step: cost of the step, or the number of its edge or action.
        violation: (P,) int64, violation costs that it pays.
        pays: whether it may pay any.
        key: (K,) entries of the parent, overwritten.

    Returns:
        whether they fit 64 bits for sure.
    """
    costs, additive, maxima = entries.cost_limit.shape[0], entries.of.shape[0], entries.of_maximum.shape[0]
    for a in range(additive):
        key[costs + a] += _growth(shift, entries, a, satisfied, key, step)
    for d in range(costs):
        key[d] += _step(entries, d, step)
        if spent(shift, key, d) >= entries.cost_limit[d]:
            return False
    for m in range(maxima):
        at_least = entries.maximum[m, satisfied] * spent(shift, key, entries.of_maximum[m])
        key[costs + additive + m] = max(key[costs + additive + m], at_least)
    if pays:
        for a in range(additive):
            for i in range(entries.violation.shape[1]):
                key[costs + a] += entries.violation[a, i] * violation[i]
        first = key.shape[0] - entries.paid.shape[0]
        for v in range(entries.paid.shape[0]):
            key[first + v] += violation[entries.paid[v]]
    return True


@bare_kernel
def _growth(
    shift: Integer, entries: Entries, a: Integer, satisfied: Integer, key: np.ndarray, edge: Integer
) -> Integer:
    """Return what a step adds to an additive entry, given the parent's entries."""
    d = entries.of[a]
    before = spent(shift, key, d)
    after = key[d] + _step(entries, d, edge)
    if d == 0:
        after >>= shift
    added = entries.rate[a, satisfied] * (after - before)
    for late in range(entries.late.shape[0]):
        if entries.late[late, 0] == a and not satisfied >> entries.late[late, 1] & 1:
            slope, offset = entries.late_slope[late], entries.late_offset[late]
            added += max(0, slope * after - offset) - max(0, slope * before - offset)
    return added


@bare_kernel
def _step(entries: Entries, d: Integer, edge: Integer) -> Integer:
    """Return one of the costs of a step."""
    return entries.edge_costs[d, edge] if entries.edge_costs.shape[1] else edge


@bare_kernel
def spent(shift: Integer, key: np.ndarray, d: Integer) -> Integer:
    """Return one of the total costs, in units."""
    return key[d] >> shift if d == 0 else key[d]


@bare_kernel
def freeze(shift: Integer, entries: Entries, before: Integer, after: Integer, key: np.ndarray) -> None:
    """Enter the costs of the tasks that become satisfied."""
    first = key.shape[0] - entries.paid.shape[0] - entries.frozen.shape[0]
    for c in range(entries.frozen.shape[0]):
        i = entries.frozen[c, 1]
        if after >> i & 1 and not before >> i & 1:
            key[first + c] = spent(shift, key, entries.frozen[c, 0])
