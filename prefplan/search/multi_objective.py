"""Best-first search with label keys of several entries, for measures that (g, mu) is not enough for.

What an entry is, and how it is compared, follows from the terms of mu (`prefplan.preferences.objective`). A label
dominates another one of its product state if it is no worse in cost and in every entry; entries marked `equal` must be
the same for that.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from prefplan.heuristics.pattern_database import COST_BOUND, Patterns, cost_bound
from prefplan.product.successors import (
    INFINITE,
    Integer,
    ProductView,
    Successors,
    bare_kernel,
    decode,
    masks,
    successors,
)
from prefplan.search.boa_star import EXHAUSTED, GOAL, MORE_LABELS, MORE_ROWS, PAUSED, TOO_LARGE, Growth
from prefplan.search.formula_programs import CALL, LARGEST_WHOLE, ROUNDING, Programs, evaluate
from prefplan.search.labels import (
    COUNT,
    EXPANDED,
    FOUND,
    GENERATED,
    HEAD,
    LABELS,
    NEXT,
    NONE,
    OPEN,
    PARENT,
    ROWS,
    SATISFIED,
    Queue,
    States,
    first_slot,
    pop,
    push,
)

HUGE = 1e200
"""A formula's value beyond this, or below 0, ends the search."""

FALLS = 6
"""Why a run of the kernel ended, beside those of `boa_star`: mu is less than on the path before."""

CARRIED, ORDERED, EQUAL = 0, 1, 2
"""How entries are compared: not at all, smaller is better, or must be the same."""


class Key(NamedTuple):
    """What the entries of a label's key are: [additive, maxima, formula values, costs, violation costs].

    Attributes:
        compare: (D,) int8: CARRIED, ORDERED or EQUAL.
        same_cost: whether only labels of equal cost are compared.
        maxima: how many maxima there are. values: (V,) int64, the formulas whose values are entries.
        costs: (A,) int64 and violations: (B,) int64, the tasks whose costs are entries.
    """

    compare: np.ndarray
    same_cost: bool
    maxima: int
    values: np.ndarray
    costs: np.ndarray
    violations: np.ndarray


class VectorLabels(NamedTuple):
    """Paths.

    Attributes:
        row: (L,) int32, cost: (L,) int64, parent: (L,) int32, sibling: (L,) int32: as in `boa_star.Labels`.
        key: (L, D) float64, whole units; costs of unsatisfied tasks are entered as 0.
        mu: (L,) float64 units, never more than the exact value, and equal to it where no formula rounds.
    """

    row: np.ndarray
    cost: np.ndarray
    parent: np.ndarray
    sibling: np.ndarray
    key: np.ndarray
    mu: np.ndarray


class Scratch(NamedTuple):
    """Room for one label: key: (D,), costs: (N,) and violations: (N,) float64."""

    key: np.ndarray
    costs: np.ndarray
    violations: np.ndarray


@bare_kernel
def run_vector(
    view: ProductView,
    growth: Growth,
    key: Key,
    programs: Programs,
    callback: Any,
    patterns: Patterns,
    states: States,
    labels: VectorLabels,
    queue: Queue,
    counters: np.ndarray,
    best: np.ndarray,
    bounds: np.ndarray,
    buffer: Successors,
    scratch: Scratch,
    budget: Integer,
) -> Integer:
    """Expand labels until a goal is found, memory is short or the budget is spent; return which.

    Arguments are as for `boa_star.run`, but for:
        key: what the entries are. programs, callback: formulas.
        best: (2,) float64, mu must stay below the first, and must not exceed the second; neither is less than the exact
            number that it stands for.
        scratch: room for one label.
    """
    codes, known, slots = states.code, states.known, states.slots
    slot_mask = slots.shape[0] - 1
    tasks = buffer.choice.shape[0]
    everything = (1 << tasks) - 1
    entries = key.compare.shape[0]
    parent, k, count = counters[PARENT], counters[NEXT], counters[COUNT]
    while True:
        while k < count:
            cost = satisfied = np.int64(0)
            if parent != NONE:
                cost = np.int64(labels.cost[parent])
                satisfied = np.int64(known[labels.row[parent], SATISFIED])
            # The open list is last in, first out: entering the model's first action last prefers it among equals.
            j = count - 1 - k
            after = cost + buffer.cost[j]
            if after > bounds[1]:
                k += 1
                continue
            code = buffer.code[j]
            slot = first_slot(code, slot_mask)
            row = slots[slot]
            while row >= 0 and codes[row] != code:
                slot = (slot + 1) & slot_mask
                row = slots[slot]
            if row < 0:
                if counters[ROWS] == codes.shape[0]:
                    counters[PARENT], counters[NEXT], counters[COUNT] = parent, k, count
                    return MORE_ROWS
                row = counters[ROWS]
                counters[ROWS] += 1
                slots[slot] = row
                codes[row] = code
                node = decode(view, code, buffer.choice)
                now, done = masks(view, buffer.choice)
                known[row, SATISFIED] = now | (-(2**31) if done == everything else 0)
                known[row, COST_BOUND] = cost_bound(patterns, node, buffer.choice)
                known[row, HEAD] = NONE
            if known[row, COST_BOUND] >= INFINITE or after + known[row, COST_BOUND] > bounds[1]:
                k += 1
                continue
            now = known[row, SATISFIED] & (2**31 - 1)
            before, spent = cost >> view.shift, after >> view.shift
            if spent >= growth.cost_limit:
                counters[PARENT], counters[NEXT], counters[COUNT] = parent, k, count
                return TOO_LARGE
            mu, error = _follow(
                view, growth, key, programs, callback, labels, buffer, scratch, parent, j, before, spent, satisfied, now
            )
            if mu != mu:
                counters[PARENT], counters[NEXT], counters[COUNT] = parent, k, count
                return TOO_LARGE
            if parent != NONE and mu + error < labels.mu[parent]:
                return FALLS
            mu -= error
            if (
                mu >= best[0]
                or mu > best[1]
                or _dominated(labels, key, known[row, HEAD], after, scratch.key, view.shift)
            ):
                k += 1
                continue
            estimate = after + known[row, COST_BOUND]
            if estimate >= INFINITE:
                return TOO_LARGE
            label = counters[LABELS]
            if label == labels.row.shape[0]:
                counters[PARENT], counters[NEXT], counters[COUNT] = parent, k, count
                return MORE_LABELS
            push(queue, counters, label, estimate)
            counters[LABELS] += 1
            labels.row[label] = row
            labels.cost[label] = after
            labels.parent[label] = parent
            labels.mu[label] = mu
            for d in range(entries):
                labels.key[label, d] = scratch.key[d]
            labels.sibling[label] = known[row, HEAD]
            known[row, HEAD] = label
            counters[GENERATED] += 1
            k += 1
        counters[PARENT], counters[NEXT], counters[COUNT] = NONE, 0, 0
        if counters[OPEN] == 0:
            return EXHAUSTED
        if budget == 0:
            return PAUSED
        budget -= 1
        label = pop(queue, counters)
        row = labels.row[label]
        mu = labels.mu[label]
        parent, k, count = np.int64(NONE), np.int64(0), np.int64(0)
        if mu >= best[0] or _superseded(labels, key, known[row, HEAD], label):
            continue
        if known[row, SATISFIED] < 0:
            counters[FOUND] = label
            return GOAL
        counters[EXPANDED] += 1
        parent = label
        count = np.int64(successors(view, codes[row], buffer))


@bare_kernel
def _follow(
    view: ProductView,
    growth: Growth,
    key: Key,
    programs: Programs,
    callback: Any,
    labels: VectorLabels,
    buffer: Successors,
    scratch: Scratch,
    parent: Integer,
    k: Integer,
    before: Integer,
    after: Integer,
    satisfied: Integer,
    now: Integer,
) -> tuple[float, float]:
    """Write the key of a successor of a label and return its mu in units, and by how much that may be wrong.

    mu is not a number if an entry is no whole number up to 2^53, or the value of a formula that is one is rounded.
    `satisfied` are the tasks satisfied before the step and `now` after it; a task's cost is frozen when it joins.
    """
    entry = scratch.key
    tasks = scratch.costs.shape[0]
    for d in range(entry.shape[0]):
        entry[d] = 0.0 if parent == NONE else labels.key[parent, d]
    step = after - before
    added = np.float64(growth.rate[satisfied] * step)
    for d in range(growth.late_task.shape[0]):
        if not satisfied >> growth.late_task[d] & 1:
            slope, offset = growth.late_slope[d], growth.late_offset[d]
            added += max(0, slope * after - offset) - max(0, slope * before - offset)
    if view.relaxed or parent == NONE:
        for i in range(tasks):
            added += growth.violation[i] * buffer.violation[k, i]
    entry[0] += added
    mu = entry[0]
    for m in range(key.maxima):
        entry[1 + m] = max(entry[1 + m], np.float64(growth.maximum[m, satisfied] * after))
        mu += entry[1 + m]
    first_value = 1 + key.maxima
    first_cost = first_value + key.values.shape[0]
    first_violation = first_cost + key.costs.shape[0]
    for i in range(tasks):
        scratch.costs[i] = after
    for a in range(key.costs.shape[0]):
        i = key.costs[a]
        if satisfied >> i & 1:
            scratch.costs[i] = entry[first_cost + a]
        elif now >> i & 1:
            entry[first_cost + a] = after
    for b in range(key.violations.shape[0]):
        i = key.violations[b]
        if view.relaxed or parent == NONE:
            entry[first_violation + b] += buffer.violation[k, i]
        scratch.violations[i] = entry[first_violation + b]
    for d in range(entry.shape[0]):
        if entry[d] > LARGEST_WHOLE and not first_value <= d < first_cost:
            return np.nan, 0.0
    if mu > LARGEST_WHOLE or after > LARGEST_WHOLE:
        return np.nan, 0.0
    error = 0.0
    value = 0
    for f in range(programs.first.shape[0] - 1):
        amount, wrong = evaluate(programs, f, scratch.costs, scratch.violations, callback)
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
    """Return whether some label of a state makes a new one superfluous."""
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
    """Return whether a label that was made later than another one of its state makes that superfluous."""
    while label != one:
        cheaper = labels.cost[label] <= labels.cost[one] and not key.same_cost
        if cheaper and _no_worse(key, labels.key, label, labels.key[one]):
            return True
        label = labels.sibling[label]
    return False
