"""BOA* for (total cost, mu), compiled.

C. Hernandez Ulloa et al., "A Simple and Fast Bi-Objective Search Algorithm", ICAPS 2020, for measures of which (g, mu)
is a sufficient key (`Measure.bi_objective`). With a bound on mu it is Algorithm 1; comparing labels by cost only, A*.

Labels wait by cost + bound. Once a goal is known, a label can matter only if mu grows by less than what separates it
from that goal's, so its bound is the cost-to-go under that budget of growth (`heuristic.patterns`). It is looked up
when the label's turn comes, and if it is larger than thought, the label goes back to wait. Budgets differ between
labels of one product state, so these are not expanded in order of cost as in BOA*, and a label is compared with all
undominated labels of its state. A goal is met in order of cost all the same: the bound under a budget is consistent
along a path.

The heuristic's sets are looked at only until the bound exceeds what the label at hand may still cost, and the rest when
its turn comes: most states are never expanded.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.heuristics.pattern_database import (
    COST_BOUND,
    LIKELY,
    LOOKED,
    TIGHT,
    Patterns,
    look_further,
    look_under_budget,
)
from prefplan.heuristics.preference_bound import Blocks, preference_bound
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
from prefplan.search.labels import (
    COUNT,
    EXPANDED,
    FOUND,
    FREE,
    GENERATED,
    GROWTH_BOUND,
    HEAD,
    LABELS,
    LOWEST,
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

# Why a run of the kernel ended.
EXHAUSTED, GOAL, PAUSED, MORE_ROWS, MORE_LABELS, TOO_LARGE = range(6)

DOMINATED = INFINITE
"""In place of a label's mu: another label of its product state is no worse."""


class Growth(NamedTuple):
    """How mu grows along a path, for measures with key (g, mu).

    Attributes:
        rate: (2^N,) int64, units of mu for each unit of cost while that set is satisfied.
        maximum: (M, 2^N) int64, M <= 1: mu is at least that times the cost so far.
        late_task: (D,) int64, late_slope: (D,) int64 units of mu for each unit of cost, late_offset: (D,) int64 units
            of mu: tardiness is max(0, slope * cost - offset).
        violation: (N,) int64, units of mu for each unit of violation cost.
        cost_limit: costs from which on one of these products might not fit 64 bits.
    """

    rate: np.ndarray
    maximum: np.ndarray
    late_task: np.ndarray
    late_slope: np.ndarray
    late_offset: np.ndarray
    violation: np.ndarray
    cost_limit: int


class Labels(NamedTuple):
    """Paths.

    Attributes:
        row: (L,) int32, where each leads. cost: (L,) int64, mu: (L,) int64. parent: (L,) int32, the path before, or -1.
        sibling: (L,) int32, the next of the labels of the same product state, none of which dominates another, or -1.
    """

    row: np.ndarray
    cost: np.ndarray
    mu: np.ndarray
    parent: np.ndarray
    sibling: np.ndarray


@bare_kernel
def run(
    view: ProductView,
    growth: Growth,
    patterns: Patterns,
    budgeted: Patterns,
    blocks: Blocks,
    states: States,
    labels: Labels,
    queue: Queue,
    counters: np.ndarray,
    bounds: np.ndarray,
    buffer: Successors,
    cost_only: bool,
    budget: Integer,
) -> Integer:
    """Expand labels until a goal is found, memory is short or the budget is spent; return which.

    The successors in `buffer` from counters[NEXT] to counters[COUNT] are those of label counters[PARENT] (of no label
    at the start) and still to be entered, so that a run goes on exactly where the last one ended.

    Args:
        view: the product.
        growth: how mu grows.
        patterns: bounds of the cost-to-go.
        budgeted: bounds of the cost-to-go where mu may grow by so much only.
        blocks: bounds of mu's growth.
        states: product states met.
        labels: paths.
        queue: the open list.
        counters: see `labels`.
        bounds: (2,) int64, mu must stay below the first, and cost must not exceed the second.
        buffer: successors, and scratch.
        cost_only: whether labels are compared by cost alone (A*).
        budget: labels to take from the open list.
    """
    codes, known, slots = states.code, states.known, states.slots
    label_row, label_cost, label_mu, label_parent = labels.row, labels.cost, labels.mu, labels.parent
    next_code, next_cost, violation = buffer.code, buffer.cost, buffer.violation
    slot_mask = slots.shape[0] - 1
    everything = (1 << growth.violation.shape[0]) - 1
    parent, k, count = counters[PARENT], counters[NEXT], counters[COUNT]
    cost = mu = satisfied = np.int64(0)
    likely = tight = np.int64(0)
    if parent != NONE:
        cost, mu = np.int64(label_cost[parent]), np.int64(label_mu[parent])
        satisfied = np.int64(known[label_row[parent], SATISFIED])
        likely = np.int64(known[label_row[parent], LIKELY])
        tight = np.int64(known[label_row[parent], TIGHT])
    while True:
        while k < count:
            # The open list is last in, first out: entering the model's first action last prefers it among equals.
            j = count - 1 - k
            after = cost + next_cost[j]
            spent = after >> view.shift
            if after > bounds[1]:
                k += 1
                continue
            if spent >= growth.cost_limit:
                return _stop(counters, parent, k, count, TOO_LARGE)
            value = mu + growth.rate[satisfied] * (spent - (cost >> view.shift))
            value = _convex(growth, value, satisfied, cost >> view.shift, spent)
            if view.relaxed or parent == NONE:
                for i in range(growth.violation.shape[0]):
                    value += growth.violation[i] * violation[j, i]
            if value >= bounds[0]:
                k += 1
                continue
            code = next_code[j]
            slot = first_slot(code, slot_mask)
            row = slots[slot]
            while row >= 0 and codes[row] != code:
                slot = (slot + 1) & slot_mask
                row = slots[slot]
            if row < 0:
                node = decode(view, code, buffer.choice)
                now, done = masks(view, buffer.choice)
                growing = preference_bound(blocks, node, buffer.choice, now)
                if value + growing >= bounds[0]:
                    k += 1
                    continue
                if counters[ROWS] == codes.shape[0]:
                    return _stop(counters, parent, k, count, MORE_ROWS)
                row = counters[ROWS]
                known[row, SATISFIED] = now | (-(2**31) if done == everything else 0)
                known[row, GROWTH_BOUND] = growing
                known[row, HEAD] = NONE
                known[row, COST_BOUND] = known[row, LOOKED] = 0
                known[row, LIKELY] = likely
                known[row, TIGHT] = tight
                far = min(bounds[1] - after, INFINITE - 1)
                if look_further(patterns, node, buffer.choice, known[row], min(far, counters[LOWEST] - after)) > far:
                    k += 1
                    continue
                counters[ROWS] += 1
                slots[slot] = row
                codes[row] = code
            if (
                value + known[row, GROWTH_BOUND] >= bounds[0]
                or known[row, COST_BOUND] >= INFINITE
                or after + known[row, COST_BOUND] > bounds[1]
                or _dominated(labels, known[row, HEAD], after, value, cost_only)
            ):
                k += 1
                continue
            estimate = max(after + known[row, COST_BOUND], counters[LOWEST])
            if estimate >= INFINITE or value >= INFINITE:
                return _stop(counters, parent, k, count, TOO_LARGE)
            label = counters[FREE]
            if label == NONE:
                if counters[LABELS] == label_row.shape[0]:
                    return _stop(counters, parent, k, count, MORE_LABELS)
                label = counters[LABELS]
            push(queue, counters, label, estimate)
            if counters[FREE] == NONE:
                counters[LABELS] += 1
            else:
                counters[FREE] = label_parent[label]
            label_row[label] = row
            label_cost[label] = after
            label_mu[label] = value
            label_parent[label] = parent
            labels.sibling[label] = _keep_undominated(labels, known[row, HEAD], after, value)
            known[row, HEAD] = label
            counters[GENERATED] += 1
            k += 1
        if counters[OPEN] == 0:
            return _stop(counters, NONE, 0, 0, EXHAUSTED)
        if budget == 0:
            return _stop(counters, NONE, 0, 0, PAUSED)
        budget -= 1
        label = pop(queue, counters)
        row = label_row[label]
        mu = np.int64(label_mu[label])
        k = count = 0
        parent = NONE
        if mu == DOMINATED:
            label_parent[label] = counters[FREE]
            counters[FREE] = label
            continue
        if mu + known[row, GROWTH_BOUND] >= bounds[0]:
            _discard(labels, known, counters, label)
            continue
        level = budgeted.budgets.shape[0] - 1
        while budgeted.budgets[level] < bounds[0] - 1 - mu:
            level -= 1
        estimate = label_cost[label] + np.int64(known[row, COST_BOUND])
        if level > 0 or known[row, LOOKED] < patterns.base.shape[0]:
            node = decode(view, codes[row], buffer.choice)
            rest = counters[LOWEST] - label_cost[label]
            if level == 0:
                estimate = label_cost[label] + look_further(patterns, node, buffer.choice, known[row], rest)
            elif estimate <= counters[LOWEST]:
                estimate = label_cost[label] + look_under_budget(budgeted, node, buffer.choice, known[row], level, rest)
        if estimate > counters[LOWEST]:
            if estimate >= INFINITE or estimate > bounds[1]:
                _discard(labels, known, counters, label)
            else:
                push(queue, counters, label, estimate)
            continue
        if known[row, SATISFIED] < 0:
            bounds[0] = mu
            counters[FOUND] = label
            return _stop(counters, NONE, 0, 0, GOAL)
        counters[EXPANDED] += 1
        parent = label
        cost = np.int64(label_cost[label])
        satisfied = np.int64(known[row, SATISFIED])
        likely = np.int64(known[row, LIKELY])
        tight = np.int64(known[row, TIGHT])
        count = successors(view, codes[row], buffer)


@bare_kernel
def _dominated(labels: Labels, label: Integer, cost: Integer, mu: Integer, cost_only: bool) -> bool:
    """Return whether some label of a state is no worse."""
    while label != NONE:
        if labels.cost[label] <= cost and (cost_only or labels.mu[label] <= mu):
            return True
        label = labels.sibling[label]
    return False


@bare_kernel
def _keep_undominated(labels: Labels, label: Integer, cost: Integer, mu: Integer) -> Integer:
    """Return the labels of a state without those that a new one dominates, which the search then drops."""
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


@bare_kernel
def _discard(labels: Labels, known: np.ndarray, counters: np.ndarray, label: Integer) -> None:
    """Take a label off its state's, and keep its place for another."""
    row = labels.row[label]
    known[row, HEAD] = _without(labels.sibling, known[row, HEAD], label)
    labels.parent[label] = counters[FREE]
    counters[FREE] = label


@bare_kernel
def _without(sibling: np.ndarray, first: Integer, label: Integer) -> Integer:
    """Return a list of labels without one of them."""
    if first == label:
        return sibling[label]
    at = first
    while sibling[at] != label:
        at = sibling[at]
    sibling[at] = sibling[label]
    return first


@bare_kernel
def _convex(growth: Growth, mu: Integer, satisfied: Integer, before: Integer, after: Integer) -> Integer:
    """Return mu with tardiness and a maximum added."""
    for d in range(growth.late_task.shape[0]):
        if not satisfied >> growth.late_task[d] & 1:
            slope, offset = growth.late_slope[d], growth.late_offset[d]
            mu += max(0, slope * after - offset) - max(0, slope * before - offset)
    for m in range(growth.maximum.shape[0]):
        mu = max(mu, growth.maximum[m, satisfied] * after)
    return mu


@bare_kernel
def _stop(counters: np.ndarray, parent: Integer, k: Integer, count: Integer, why: Integer) -> Integer:
    """Note where a run ends."""
    counters[PARENT], counters[NEXT], counters[COUNT] = parent, k, count
    return why
