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
from prefplan.heuristics.pattern_database import COST_BOUND, LIKELY, LOOKED, added_bound, raise_bound
from prefplan.heuristics.preference_bound import preference_bound
from prefplan.heuristics.preprocessing import Bounds
from prefplan.heuristics.projections import observe
from prefplan.models.kernels import INFINITE, UNBOUNDED, Integer, bare_kernel
from prefplan.product.space import Space, decode
from prefplan.product.successors import Successors
from prefplan.search.labels import (
    AT,
    COL,
    END,
    GOAL_BIT,
    NONE,
    Growth,
    Queue,
    States,
    describe,
    expand,
    mu_after,
    next_successor,
    pop,
    push,
    slot_of,
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
def run(
    space: Space,
    growth: Growth,
    bounds: Bounds,
    states: States,
    labels: Labels,
    queue: Queue,
    counters: np.ndarray,
    limits: np.ndarray,
    begin: np.ndarray,
    buffer: Successors,
    cost_only: bool,
    pops: Integer,
) -> Integer:
    """Expand labels until a goal is found, memory runs out or enough were popped; return which (`END`).

    Args:
        space: what is searched.
        growth: how mu grows.
        bounds: heuristics.
        states: product states met.
        labels: of the search.
        queue: the open list.
        counters: int64, by index `AT`.
        limits: (2,) int64, mu must stay below the first, and cost must not exceed the second.
        begin: (K, 1) int64, mu of each start's label.
        buffer: successors, and scratch.
        cost_only: whether labels are compared by cost alone (A*).
        pops: most labels to pop from the open list.
    """
    while True:
        while counters[AT.NEXT] < counters[AT.COUNT]:
            end = _enter(space, growth, bounds, states, labels, queue, counters, limits, begin, buffer, cost_only)
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
        cost, mu = labels.cost[label], labels.mu[label]
        estimate = _estimate(space, bounds, known, cost, mu, limits[0], counters[AT.LOWEST], buffer.automata)
        if estimate > counters[AT.LOWEST]:
            if estimate <= limits[1]:
                push(queue, counters, label, estimate)
            continue
        if known[COL.SATISFIED] < 0:
            limits[0], counters[AT.FOUND] = labels.mu[label], label
            return END.GOAL
        expand(space, buffer, counters, label, known[COL.CODE])


@bare_kernel
def _estimate(
    space: Space,
    bounds: Bounds,
    known: np.ndarray,
    cost: Integer,
    mu: Integer,
    mu_limit: Integer,
    lowest: Integer,
    automata: np.ndarray,
) -> Integer:
    """Return a lower bound of what a popped label costs at the end, UNBOUNDED if it is pruned.

    The bound of its product state is raised until it exceeds the `lowest` estimate, or nothing is left to raise it.
    """
    if mu == DOMINATED or mu + known[COL.GROWTH_BOUND] >= mu_limit:
        return np.int64(UNBOUNDED)
    node = decode(space.automata.nodes, space.automata.sizes, known[COL.CODE], automata)
    raise_bound(bounds.patterns, bounds.landmarks, node, automata, known, lowest - cost)
    within = lagrangian_bound(bounds.lagrangian, node, automata, mu_limit - 1 - mu)
    rest = max(known[COST_BOUND], within << space.shift)
    return cost + rest if rest < INFINITE else np.int64(UNBOUNDED)


@bare_kernel
def _enter(
    space: Space,
    growth: Growth,
    bounds: Bounds,
    states: States,
    labels: Labels,
    queue: Queue,
    counters: np.ndarray,
    limits: np.ndarray,
    begin: np.ndarray,
    buffer: Successors,
    cost_only: bool,
) -> Integer:
    """Make a label of the next successor unless it is pruned; return ENTERED, or why that is not possible (`END`)."""
    parent, shift = counters[AT.PARENT], space.shift
    cost = mu = satisfied = likely = np.int64(0)
    if parent != NONE:
        cost, mu = labels.cost[parent], labels.mu[parent]
        satisfied, likely = states.known[labels.row[parent], COL.SATISFIED], states.known[labels.row[parent], LIKELY]
    k = next_successor(counters)
    after = cost + buffer.cost[k]
    before, spent = cost >> shift, after >> shift
    if after > limits[1]:
        return END.ENTERED
    if spent >= growth.cost_limit:
        return END.TOO_LARGE
    if parent == NONE:
        mu = begin[k, 0]
    else:
        mu = np.int64(mu_after(growth, mu, satisfied, before, spent, buffer.violation[k], space.automata.pays))
    if mu >= limits[0]:
        return END.ENTERED
    slack, most = limits[0] - mu, min(limits[1] - after, INFINITE - 1)
    slot = slot_of(states, buffer.code[k])
    row = np.int64(states.slots[slot])
    if row == NONE:
        row = counters[AT.ROWS]
        if row == states.known.shape[0]:
            return END.MORE_ROWS
        states.known[row, LIKELY] = likely
        lookups = min(most, counters[AT.LOWEST] - after)
        _bound_state(space, bounds, buffer.code[k], slack, lookups, states.known[row], buffer.automata)
    known = states.known[row]
    if known[COL.GROWTH_BOUND] >= slack or known[COST_BOUND] > most:
        return END.ENTERED
    if states.slots[slot] == NONE:
        states.slots[slot] = row
        counters[AT.ROWS] += 1
    if _dominated(labels, known[COL.HEAD], after, mu, cost_only):
        return END.ENTERED
    estimate = max(after + known[COST_BOUND], counters[AT.LOWEST])
    if estimate >= INFINITE or mu >= INFINITE:
        return END.TOO_LARGE
    label = counters[AT.LABELS]
    if label == labels.row.shape[0]:
        return END.MORE_LABELS
    push(queue, counters, label, estimate)
    labels.row[label], labels.cost[label], labels.mu[label], labels.parent[label] = row, after, mu, parent
    labels.sibling[label], known[COL.HEAD] = _undominated(labels, known[COL.HEAD], after, mu), label
    counters[AT.LABELS] += 1
    return END.ENTERED


@bare_kernel
def _bound_state(
    space: Space,
    bounds: Bounds,
    code: Integer,
    growth_limit: Integer,
    cost_limit: Integer,
    known: np.ndarray,
    automata: np.ndarray,
) -> None:
    """Fill the row of a new product state.

    Args:
        space: what is searched.
        bounds: heuristics.
        code: the product state.
        growth_limit: stop if the growth of mu to the end is this much or more.
        cost_limit: stop looking up tables once the bound of the cost-to-go exceeds this.
        known: the row; LIKELY is the table to look up first.
        automata: (N + R,) scratch.
    """
    node = decode(space.automata.nodes, space.automata.sizes, code, automata)
    describe(space.automata.ends, code, automata, known)
    observe(bounds.projections, node)
    patterns, satisfied = bounds.patterns, known[COL.SATISFIED] & ~GOAL_BIT
    growth = preference_bound(bounds.blocks, bounds.projections, node, automata, satisfied)
    known[COL.GROWTH_BOUND], known[COST_BOUND], known[LOOKED] = growth, 0, 0
    if growth >= growth_limit:
        return
    if patterns.add_up:
        known[COST_BOUND] = added_bound(patterns, bounds.projections, node, automata)
        known[LOOKED] = patterns.base.shape[0]
    raise_bound(patterns, bounds.landmarks, node, automata, known, cost_limit)


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
