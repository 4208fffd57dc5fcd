"""BOA* for (total cost, mu), compiled.

C. Hernandez Ulloa et al., "A Simple and Fast Bi-Objective Search Algorithm", ICAPS 2020, for measures of which (g, mu)
is a sufficient key (`Measure.bi_objective`). With a bound on mu it is Algorithm 1; comparing labels by cost only, A*.

The heuristic is consistent, so labels of one product state are expanded in order of cost, and a label is dominated if
the last one that was expanded there has no larger mu.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.heuristics.preprocessing import Bounds
from prefplan.product.successors import INFINITE, Integer, ProductView, Successors, bare_kernel, successors
from prefplan.search.labels import (
    COST_BOUND,
    COUNT,
    ENTERED,
    EXHAUSTED,
    EXPANDED,
    FOUND,
    GOAL,
    GROWTH_BOUND,
    HEAD,
    LABELS,
    MORE_LABELS,
    MORE_ROWS,
    NEXT,
    NONE,
    OPEN,
    PARENT,
    PAUSED,
    SATISFIED,
    TOO_LARGE,
    Growth,
    Queue,
    States,
    added_mu,
    enter_state,
    pop,
    push,
)


class Labels(NamedTuple):
    """Paths.

    Attributes:
        row: (L,) int32, where each leads. cost: (L,) int64, mu: (L,) int64. parent: (L,) int32, the path before, or -1.
    """

    row: np.ndarray
    cost: np.ndarray
    mu: np.ndarray
    parent: np.ndarray


@bare_kernel
def run(
    view: ProductView,
    growth: Growth,
    bounds: Bounds,
    states: States,
    labels: Labels,
    queue: Queue,
    counters: np.ndarray,
    limits: np.ndarray,
    buffer: Successors,
    cost_only: bool,
    pops: Integer,
) -> Integer:
    """Expand labels until a goal is found, memory is short or enough were expanded; return which.

    Args:
        view: the product.
        growth: how mu grows.
        bounds: heuristics.
        states: product states met.
        labels: paths.
        queue: the open list.
        counters: see `labels`.
        limits: (2,) int64, mu must stay below the first, and cost must not exceed the second.
        buffer: successors, and scratch.
        cost_only: whether labels are compared by cost alone (A*).
        pops: labels to take from the open list.
    """
    while True:
        while counters[NEXT] < counters[COUNT]:
            end = _enter(view, growth, bounds, states, labels, queue, counters, limits, buffer, cost_only)
            if end != ENTERED:
                return end
            counters[NEXT] += 1
        if counters[OPEN] == 0:
            return EXHAUSTED
        if pops == 0:
            return PAUSED
        pops -= 1
        label = pop(queue, counters)
        row = labels.row[label]
        mu = labels.mu[label]
        known = states.known[row]
        if mu + known[GROWTH_BOUND] >= limits[0] or _dominated(labels, known[HEAD], mu, cost_only):
            continue
        known[HEAD] = label
        if known[SATISFIED] < 0:
            limits[0] = mu
            counters[FOUND] = label
            return GOAL
        counters[EXPANDED] += 1
        counters[PARENT], counters[NEXT] = label, 0
        counters[COUNT] = successors(view, states.code[row], buffer)


@bare_kernel
def _enter(
    view: ProductView,
    growth: Growth,
    bounds: Bounds,
    states: States,
    labels: Labels,
    queue: Queue,
    counters: np.ndarray,
    limits: np.ndarray,
    buffer: Successors,
    cost_only: bool,
) -> Integer:
    """Make a label of the next successor, unless it is dominated or out of bounds; return why if it cannot be done."""
    parent = counters[PARENT]
    cost = mu = satisfied = np.int64(0)
    if parent != NONE:
        cost, mu = labels.cost[parent], labels.mu[parent]
        satisfied = states.known[labels.row[parent], SATISFIED]
    # Of equal labels the last made is expanded first: entering the model's first action last prefers it.
    k = counters[COUNT] - 1 - counters[NEXT]
    after = cost + buffer.cost[k]
    before, spent = cost >> view.shift, after >> view.shift
    if after > limits[1]:
        return ENTERED
    if spent >= growth.cost_limit:
        return TOO_LARGE
    mu += added_mu(growth, satisfied, before, spent)
    if view.relaxed or parent == NONE:
        for i in range(growth.violation.shape[0]):
            mu += growth.violation[i] * buffer.violation[k, i]
    for m in range(growth.maximum.shape[0]):
        mu = max(mu, growth.maximum[m, satisfied] * spent)
    if mu >= limits[0]:
        return ENTERED
    row = enter_state(view, bounds, states, counters, buffer, buffer.code[k])
    if row == NONE:
        return MORE_ROWS
    known = states.known[row]
    estimate = after + known[COST_BOUND]
    if known[COST_BOUND] >= INFINITE or estimate > limits[1] or mu + known[GROWTH_BOUND] >= limits[0]:
        return ENTERED
    if _dominated(labels, known[HEAD], mu, cost_only):
        return ENTERED
    if estimate >= INFINITE or mu >= INFINITE:
        return TOO_LARGE
    label = counters[LABELS]
    if label == labels.row.shape[0]:
        return MORE_LABELS
    push(queue, counters, label, estimate)
    labels.row[label], labels.cost[label], labels.mu[label], labels.parent[label] = row, after, mu, parent
    counters[LABELS] += 1
    return ENTERED


@bare_kernel
def _dominated(labels: Labels, expanded: Integer, mu: Integer, cost_only: bool) -> bool:
    """Return whether the label that was last expanded at a product state, if any, is no worse than a new one."""
    return expanded != NONE and (cost_only or labels.mu[expanded] <= mu)
