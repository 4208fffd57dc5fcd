"""BOA* for (total cost, mu), compiled.

C. Hernandez Ulloa et al., "A Simple and Fast Bi-Objective Search Algorithm", ICAPS 2020, for measures for which (g, mu)
is a sufficient key (`Measure.bi_objective`). With a bound on mu it is Algorithm 1; comparing labels by cost only, A*.

A new label is compared with all undominated labels of its product state, expanded or not. Heuristic tables are looked
up only until the bound puts the label behind those expanded now, and the others when the label is popped: most states
are never expanded.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.heuristics.lagrangian import lagrangian_bound
from prefplan.heuristics.pattern_database import COST_BOUND, LIKELY, LOOKED, raise_bound
from prefplan.product.kernels import INFINITE, Integer, bare_kernel
from prefplan.product.product_view import decode
from prefplan.search.labels import (
    AT,
    COL,
    END,
    NONE,
    PRUNED,
    Memory,
    enter_state,
    expand,
    mu_after,
    next_successor,
    pop,
    push,
)


class Labels(NamedTuple):
    """Labels: paths to product states.

    Attributes:
        row: (L,) int32, of the product state. cost: (L,) int64, mu: (L,) int64. parent: (L,) int32, or -1.
        sibling: (L,) int32, the next of the product state's undominated labels, or -1.
    """

    row: np.ndarray
    cost: np.ndarray
    mu: np.ndarray
    parent: np.ndarray
    sibling: np.ndarray


DOMINATED = INFINITE
"""Stands for the mu of a label that another label of its product state dominates."""


@bare_kernel
def run(memory: Memory, labels: Labels, cost_only: bool, pops: Integer) -> Integer:
    """Expand labels until a goal is found, memory runs out or enough were popped; return which (`END`).

    Args:
        memory: of the search. Its limits: mu must stay below the first, and cost must not exceed the second.
        labels: of the search.
        cost_only: whether labels are compared by cost alone (A*).
        pops: most labels to pop from the open list.
    """
    counters = memory.counters
    while True:
        while counters[AT.NEXT] < counters[AT.COUNT]:
            end = _enter(memory, labels, cost_only)
            if end != END.ENTERED:
                return end
            counters[AT.NEXT] += 1
        if counters[AT.OPEN] == 0:
            return END.EXHAUSTED
        if pops == 0:
            return END.PAUSED
        pops -= 1
        label = _take(memory, labels)
        if label == NONE:
            continue
        if memory.states.known[labels.row[label], COL.SATISFIED] < 0:
            memory.limits[0], counters[AT.FOUND] = labels.mu[label], label
            return END.GOAL
        expand(memory, label, labels.row[label])


@bare_kernel
def _take(memory: Memory, labels: Labels) -> Integer:
    """Pop a label and return it; NONE if it is pruned, or put back with a larger bound."""
    view, bounds, limits, buffer = memory.product, memory.bounds, memory.limits, memory.buffer
    label = pop(memory)
    lowest = memory.counters[AT.LOWEST]
    cost, mu, known = labels.cost[label], labels.mu[label], memory.states.known[labels.row[label]]
    if mu == DOMINATED or mu + known[COL.GROWTH_BOUND] >= limits[0]:
        return NONE
    if known[LOOKED] <= bounds.patterns.base.shape[0]:
        node = decode(view, known[COL.CODE], buffer.choice)
        raise_bound(bounds.patterns, bounds.landmarks, node, buffer.choice, known, lowest - cost)
    rest = known[COST_BOUND]
    if bounds.lagrangian.weights.shape[0]:
        node = decode(view, known[COL.CODE], buffer.choice)
        within = lagrangian_bound(bounds.lagrangian, node, buffer.choice, limits[0] - 1 - mu)
        rest = max(rest, within << view.shift)
    estimate = cost + rest
    if estimate <= lowest:
        return label
    if rest < INFINITE and estimate <= limits[1]:
        push(memory, label, estimate)
    return NONE


@bare_kernel
def _enter(memory: Memory, labels: Labels, cost_only: bool) -> Integer:
    """Make a label of the next successor unless it is pruned; return ENTERED, or why that is not possible (`END`)."""
    view, growth, states, limits = memory.product, memory.growth, memory.states, memory.limits
    counters, buffer = memory.counters, memory.buffer
    parent = counters[AT.PARENT]
    cost = mu = satisfied = likely = np.int64(0)
    if parent != NONE:
        cost, mu = labels.cost[parent], labels.mu[parent]
        satisfied, likely = states.known[labels.row[parent], COL.SATISFIED], states.known[labels.row[parent], LIKELY]
    k = next_successor(counters)
    after = cost + buffer.cost[k]
    before, spent = cost >> view.shift, after >> view.shift
    if after > limits[1]:
        return END.ENTERED
    if spent >= growth.cost_limit:
        return END.TOO_LARGE
    if parent == NONE:
        mu = memory.begin[k, 0]
    else:
        mu = np.int64(mu_after(growth, mu, satisfied, before, spent, buffer.violation[k], view.pays))
    if mu >= limits[0]:
        return END.ENTERED
    slack, most, next_lookup = limits[0] - mu, min(limits[1] - after, INFINITE - 1), counters[AT.LOWEST] - after
    row = enter_state(memory, buffer.code[k], likely, slack, most, next_lookup)
    if row == NONE:
        return END.MORE_ROWS
    if row == PRUNED or states.known[row, COL.GROWTH_BOUND] >= slack or states.known[row, COST_BOUND] > most:
        return END.ENTERED
    known = states.known[row]
    if _dominated(labels, known[COL.HEAD], after, mu, cost_only):
        return END.ENTERED
    estimate = max(after + known[COST_BOUND], counters[AT.LOWEST])
    if estimate >= INFINITE or mu >= INFINITE:
        return END.TOO_LARGE
    label = counters[AT.LABELS]
    if label == labels.row.shape[0]:
        return END.MORE_LABELS
    push(memory, label, estimate)
    labels.row[label], labels.cost[label], labels.mu[label], labels.parent[label] = row, after, mu, parent
    labels.sibling[label], known[COL.HEAD] = _undominated(labels, known[COL.HEAD], after, mu), label
    counters[AT.LABELS] += 1
    return END.ENTERED


@bare_kernel
def _dominated(labels: Labels, label: Integer, cost: Integer, mu: Integer, cost_only: bool) -> bool:
    """Return whether some label of a product state is no worse than a new one."""
    while label != NONE:
        if labels.cost[label] <= cost and (cost_only or labels.mu[label] <= mu):
            return True
        label = labels.sibling[label]
    return False


@bare_kernel
def _undominated(labels: Labels, label: Integer, cost: Integer, mu: Integer) -> Integer:
    """Mark the labels of a product state that a new one dominates, and return the first of the others."""
    first = last = np.int64(NONE)
    while label != NONE:
        following = labels.sibling[label]
        if labels.cost[label] >= cost and labels.mu[label] >= mu:
            labels.mu[label] = DOMINATED
        else:
            if last == NONE:
                first = np.int64(label)
            else:
                labels.sibling[last] = label
            last = np.int64(label)
        label = following
    if last != NONE:
        labels.sibling[last] = NONE
    return first
