"""Best-first search with label keys of several entries, for measures for which (g, mu) is not a sufficient key.

The terms of mu determine the entries, and how they are compared (`prefplan.preferences.objective`). A label dominates
another one of its product state if it is no worse in cost and in every entry; EQUAL entries must be the same.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.heuristics.pattern_database import COST_BOUND, LIKELY
from prefplan.heuristics.preprocessing import Bounds
from prefplan.product.formula_programs import CALL, LARGEST_WHOLE, ROUNDING, Programs, evaluate
from prefplan.product.kernels import INFINITE, UNBOUNDED, Integer, bare_kernel
from prefplan.product.space import Space
from prefplan.product.successors import Successors
from prefplan.search.boa_star import bound_state
from prefplan.search.labels import (
    AT,
    COL,
    END,
    NONE,
    Growth,
    Queue,
    States,
    added_mu,
    expand,
    next_successor,
    pop,
    push,
    slot_of,
)

HUGE = 1e200
"""A formula's value beyond this, or below 0, ends the search."""

CARRIED, ORDERED, EQUAL = 0, 1, 2
"""How entries are compared: not at all, smaller is better, or must be the same."""


class Key(NamedTuple):
    """The entries of a label's key: [additive, maxima, formula values, costs, violation costs].

    Attributes:
        compare: (D,) int8: CARRIED, ORDERED or EQUAL.
        same_cost: whether only labels of equal cost are compared.
        maxima: number of maxima. values: (V,) int64, the formulas whose values are entries.
        costs: (A,) int64 and violations: (B,) int64, the tasks whose costs are entries.
    """

    compare: np.ndarray
    same_cost: bool
    maxima: int
    values: np.ndarray
    costs: np.ndarray
    violations: np.ndarray


class VectorLabels(NamedTuple):
    """Labels: paths to product states.

    Attributes:
        row: (L,) int32, cost: (L,) int64, parent: (L,) int32: as in `boa_star.Labels`.
        sibling: (L,) int32, the label made before at the same product state, or -1.
        key: (L, D) float64, in units; costs of unsatisfied tasks are entered as 0.
        mu: (L,) float64 units, never more than the exact value, and equal to it where no formula rounds.
    """

    row: np.ndarray
    cost: np.ndarray
    parent: np.ndarray
    sibling: np.ndarray
    key: np.ndarray
    mu: np.ndarray


class Scratch(NamedTuple):
    """Scratch for one label: key: (D,), costs: (N,) and violations: (N,) float64."""

    key: np.ndarray
    costs: np.ndarray
    violations: np.ndarray


@bare_kernel
def run_vector(
    space: Space,
    growth: Growth,
    bounds: Bounds,
    states: States,
    labels: VectorLabels,
    queue: Queue,
    counters: np.ndarray,
    limits: np.ndarray,
    begin: np.ndarray,
    buffer: Successors,
    key: Key,
    programs: Programs,
    best: np.ndarray,
    scratch: Scratch,
    pops: Integer,
) -> Integer:
    """Expand labels until a goal is found, memory runs out or enough were popped; return which.

    Arguments are as for `boa_star.run`, except:
        key: the layout of the entries. programs: the terms of mu that are formulas or functions.
        best: (2,) float64, mu must stay below the first, and must not exceed the second; both are rounded up.
        scratch: for one label.
    """
    while True:
        while counters[AT.NEXT] < counters[AT.COUNT]:
            memory = states, labels, queue, counters, limits, begin, buffer
            end = _enter(space, growth, bounds, *memory, key, programs, best, scratch)
            if end != END.ENTERED:
                return end
            counters[AT.NEXT] += 1
        if counters[AT.OPEN] == 0:
            return END.EXHAUSTED
        if pops == 0:
            return END.PAUSED
        pops -= 1
        label = pop(queue, counters)
        known = states.known[labels.row[label]]
        if labels.mu[label] >= best[0] or _superseded(labels, key, known[COL.HEAD], label):
            continue
        if known[COL.SATISFIED] < 0:
            counters[AT.FOUND] = label
            return END.GOAL
        expand(space, buffer, counters, label, known[COL.CODE])


@bare_kernel
def _enter(
    space: Space,
    growth: Growth,
    bounds: Bounds,
    states: States,
    labels: VectorLabels,
    queue: Queue,
    counters: np.ndarray,
    limits: np.ndarray,
    begin: np.ndarray,
    buffer: Successors,
    key: Key,
    programs: Programs,
    best: np.ndarray,
    scratch: Scratch,
) -> Integer:
    """Make a label of the next successor unless it is pruned; return ENTERED, or why that is not possible (`END`)."""
    parent = counters[AT.PARENT]
    cost = satisfied = np.int64(0)
    if parent != NONE:
        cost, satisfied = labels.cost[parent], states.known[labels.row[parent], COL.SATISFIED]
    k = next_successor(counters)
    after = cost + buffer.cost[k]
    before, spent = cost >> space.shift, after >> space.shift
    if after > limits[1]:
        return END.ENTERED
    if spent >= growth.cost_limit:
        return END.TOO_LARGE
    most = min(limits[1] - after, INFINITE - 1)
    slot = slot_of(states, buffer.code[k])
    row = np.int64(states.slots[slot])
    if row == NONE:
        row = counters[AT.ROWS]
        if row == states.known.shape[0]:
            return END.MORE_ROWS
        states.known[row, LIKELY] = 0
        bound_state(space, bounds, buffer.code[k], UNBOUNDED, most, states.known[row], buffer.automata)
    known = states.known[row]
    if known[COST_BOUND] > most:
        return END.ENTERED
    if states.slots[slot] == NONE:
        states.slots[slot] = row
        counters[AT.ROWS] += 1
    estimate = after + known[COST_BOUND]
    if parent == NONE:
        satisfied = known[COL.SATISFIED]
    for d in range(scratch.key.shape[0]):
        scratch.key[d] = begin[k, d] if parent == NONE else labels.key[parent, d]
    if parent != NONE:
        _grow(growth, key, satisfied, before, spent, buffer.violation[k], space.automata.pays, scratch.key)
    _fill_costs(key, scratch, space.automata.ends.shape[0], spent, satisfied, known[COL.SATISFIED])
    mu, error = _value(key, programs, scratch, spent)
    if mu != mu:
        return END.TOO_LARGE
    if parent != NONE and mu + error < labels.mu[parent]:
        return END.FALLS
    mu -= error
    if mu >= best[0] or mu > best[1] or _dominated(labels, key, known[COL.HEAD], after, scratch.key, space.shift):
        return END.ENTERED
    if estimate >= INFINITE:
        return END.TOO_LARGE
    label = counters[AT.LABELS]
    if label == labels.row.shape[0]:
        return END.MORE_LABELS
    push(queue, counters, label, estimate)
    labels.row[label], labels.cost[label], labels.mu[label], labels.parent[label] = row, after, mu, parent
    for d in range(scratch.key.shape[0]):
        labels.key[label, d] = scratch.key[d]
    labels.sibling[label], known[COL.HEAD] = known[COL.HEAD], label
    counters[AT.LABELS] += 1
    return END.ENTERED


@bare_kernel
def _grow(
    growth: Growth,
    key: Key,
    satisfied: Integer,
    before: Integer,
    after: Integer,
    violation: np.ndarray,
    pays: bool,
    entry: np.ndarray,
) -> None:
    """Add a step from cost `before` to `after`, and the violation costs (N,) that it pays, if any, to a key."""
    if pays:
        for i in range(violation.shape[0]):
            entry[0] += growth.violation[i] * violation[i]
        first = entry.shape[0] - key.violations.shape[0]
        for b in range(key.violations.shape[0]):
            entry[first + b] += violation[key.violations[b]]
    entry[0] += added_mu(growth, satisfied, before, after)
    for m in range(key.maxima):
        entry[1 + m] = max(entry[1 + m], np.float64(growth.maximum[m, satisfied] * after))


@bare_kernel
def _fill_costs(key: Key, scratch: Scratch, tasks: Integer, spent: Integer, satisfied: Integer, now: Integer) -> None:
    """Write all task costs and violation costs of a label; enter the costs of tasks satisfied now but not before."""
    first_violation = scratch.key.shape[0] - key.violations.shape[0]
    first_cost = first_violation - key.costs.shape[0]
    for i in range(tasks):
        scratch.costs[i] = spent
    for a in range(key.costs.shape[0]):
        i = key.costs[a]
        if satisfied >> i & 1:
            scratch.costs[i] = scratch.key[first_cost + a]
        elif now >> i & 1:
            scratch.key[first_cost + a] = spent
    for b in range(key.violations.shape[0]):
        scratch.violations[key.violations[b]] = scratch.key[first_violation + b]


@bare_kernel
def _value(key: Key, programs: Programs, scratch: Scratch, spent: Integer) -> tuple[float, float]:
    """Return mu of a label, in units, and a bound of its error; write the values of formulas that are entries.

    mu is NaN if an entry exceeds 2^53, if a formula's value is negative, above HUGE or undefined, or if one that is an
    entry is rounded.
    """
    entry = scratch.key
    first_value = 1 + key.maxima
    first_cost = first_value + key.values.shape[0]
    for d in range(entry.shape[0]):
        if entry[d] > LARGEST_WHOLE and not first_value <= d < first_cost:
            return np.nan, 0.0
    mu = 0.0
    for d in range(first_value):
        mu += entry[d]
    if mu > LARGEST_WHOLE or spent > LARGEST_WHOLE:
        return np.nan, 0.0
    error = 0.0
    value = 0
    for f in range(programs.first.shape[0] - 1):
        amount, wrong = evaluate(programs, f, scratch.costs, scratch.violations)
        rounded = wrong > 0 and programs.operation[programs.first[f]] != CALL
        kept = value < key.values.shape[0] and key.values[value] == f
        if not (-wrong <= amount <= HUGE) or (rounded and kept):
            return np.nan, 0.0
        mu += amount
        error += wrong
        if error > 0 or abs(mu) > LARGEST_WHOLE:
            error = error * (1 + ROUNDING) + abs(mu) * ROUNDING
        if kept:
            entry[first_value + value] = amount
            value += 1
    return mu, error


@bare_kernel
def _no_worse(key: Key, one: np.ndarray, label: Integer, other: np.ndarray) -> bool:
    """Return whether a label's key is no worse than another key."""
    for d in range(key.compare.shape[0]):
        if key.compare[d] == ORDERED and one[label, d] > other[d]:
            return False
        if key.compare[d] == EQUAL and one[label, d] != other[d]:
            return False
    return True


@bare_kernel
def _dominated(
    labels: VectorLabels, key: Key, label: Integer, cost: Integer, entry: np.ndarray, shift: Integer
) -> bool:
    """Return whether some label of a state dominates a new one."""
    while label != NONE:
        nearer = labels.cost[label] <= cost
        if key.same_cost:
            nearer &= labels.cost[label] >> shift == cost >> shift
        if nearer and _no_worse(key, labels.key, label, entry):
            return True
        label = labels.sibling[label]
    return False


@bare_kernel
def _superseded(labels: VectorLabels, key: Key, label: Integer, one: Integer) -> bool:
    """Return whether a label is dominated by one of its state that was made later."""
    while label != one:
        cheaper = labels.cost[label] <= labels.cost[one] and not key.same_cost
        if cheaper and _no_worse(key, labels.key, label, labels.key[one]):
            return True
        label = labels.sibling[label]
    return False
