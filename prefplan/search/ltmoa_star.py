"""LTMOA*: all non-dominated vectors of any number of costs and preferences, compiled.

C. Hernandez, W. Yeoh, J. A. Baier, A. Felner, O. Salzman, H. Zhang, S.-H. Chan and S. Koenig, "Multi-objective Search
via Lazy and Efficient Dominance Checks", IJCAI 2023, with the dimensionality reduction of NAMOA*dr (F. J. Pulido,
L. Mandow and J. L. Perez-de-la-Cruz, "Dimensionality reduction in multiobjective shortest path search", 2015).

Labels are expanded in lexicographic order of their bounds. Bounds never fall along a path, so that the first entry of a
label of some product state is never less than that of those expanded there before: only the other entries, the
*truncated* vectors, need be compared, with a list for each state from which dominated vectors are removed. Goals are
one more such list. Of labels in the open list none is compared with another.

A label's entries are: every cost; for each preference what its additive terms amount to; each maximum; and for formulas
the costs of satisfied tasks and violation costs that they mention (`prefplan.preferences.objective`). If one label of a
product state is no worse than another one in all of these, it stays so for every objective, however they go on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.heuristics.objective_bounds import ObjectiveBounds, write_bounds
from prefplan.product.kernels import Integer, bare_kernel
from prefplan.product.successors import INFINITE, UNBOUNDED, ProductView, Successors, decode
from prefplan.search.labels import (
    COLUMNS,
    COUNT,
    COUNTERS,
    ENTERED,
    EXHAUSTED,
    FALLS,
    FOUND,
    GOAL,
    GOAL_BIT,
    LABELS,
    LOWEST,
    MORE_LABELS,
    MORE_ROWS,
    NEXT,
    NONE,
    OPEN,
    PARENT,
    PAUSED,
    ROWS,
    SATISFIED,
    TOO_LARGE,
    Memory,
    States,
    enter_state,
    expand,
    next_successor,
)

GOALS, VECTORS = COUNTERS, COUNTERS + 1
"""Places in the counters for the number of truncated vectors of goals, and of all others with the gaps between them."""

# Columns of a product state's row after those of `labels`: where its truncated vectors begin, how many there are and
# may be, and the bounds of the entries that have one.
FIRST, SIZE, CAPACITY, BOUND = range(COLUMNS, COLUMNS + 4)

MORE_VECTORS, MORE_GOALS = FALLS + 1, FALLS + 2
"""More reasons why a run of the kernel ended."""

VECTORS_AT_FIRST = 4
"""Truncated vectors for which a product state has memory at first."""


class Entries(NamedTuple):
    """What the K entries of a label are: [costs, additive, maxima, costs of satisfied tasks, violation costs].

    Attributes:
        edge_costs: (D, E) int64, costs of each edge, or of each entry of `Moves.costs` where states are generated;
            (1, 0) where what successors cost is the only cost itself.
        of: (A,) int64, the cost that each additive entry grows with. rate: (A, 2^N) int64, units of mu for each unit of
            it. violation: (A, N) int64, units of mu for each unit of violation cost.
        late: (L, 2) int64, additive entry and task of each deadline, late_slope: (L,) int64, late_offset: (L,) int64:
            tardiness is max(0, slope * cost - offset).
        of_maximum: (M,) int64, the cost of each maximum. maximum: (M, 2^N) int64: it is at least that times the cost.
        frozen: (C, 2) int64, the cost and the task of each entry for the cost of a satisfied task.
        paid: (V,) int64, the task of each entry for a violation cost.
        cost_limit: (D,) int64, costs from which on one of these products might not fit 64 bits.
        order: (K,) int64, the entries in the order of comparison.
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


class Paths(NamedTuple):
    """Labels.

    Attributes:
        row: (L,) int32, where each leads. parent: (L,) int32, the path before, or -1.
        step: (L,) int32, the last edge, or the number of its costs; of a label without parent its start.
        key: (L, K) int64, entries; costs of tasks that are not satisfied are entered as 0.
    """

    row: np.ndarray
    parent: np.ndarray
    step: np.ndarray
    key: np.ndarray


class Vectors(NamedTuple):
    """Truncated vectors: of_states: (X, K - 1) int64, in one piece for each product state, and of_goals: (G, K - 1)."""

    of_states: np.ndarray
    of_goals: np.ndarray


class Vector(NamedTuple):
    """Scratch for one label: key: (K,), bound: (K,) and growth: (D + A,) int64."""

    key: np.ndarray
    bound: np.ndarray
    growth: np.ndarray


@bare_kernel
def run(
    memory: Memory,
    entries: Entries,
    bounds: ObjectiveBounds,
    paths: Paths,
    vectors: Vectors,
    scratch: Vector,
    pops: Integer,
) -> Integer:
    """Expand labels until a goal is found, memory is short or enough were expanded; return which.

    Arguments are as for `boa_star.run`, but for:
        memory: where edges of its product have numbers, these stand for their costs. Its bounds are empty, its queue is
            by the bound of the first entry, and its limits are (K,) those that no bound of an entry may exceed.
        entries: what labels hold. bounds: heuristics.
        paths: labels. vectors: truncated vectors. scratch: for one label.
    """
    counters, queue, states = memory.counters, memory.queue, memory.states
    while True:
        while counters[NEXT] < counters[COUNT]:
            end = _enter(memory, entries, bounds, paths, vectors, scratch)
            if end != ENTERED:
                return end
            counters[NEXT] += 1
        if counters[OPEN] == 0:
            return EXHAUSTED
        if pops == 0:
            return PAUSED
        if counters[VECTORS] + 2 * _most_vectors(states, paths.row[queue.items[0]]) > vectors.of_states.shape[0]:
            return MORE_VECTORS
        if counters[GOALS] == vectors.of_goals.shape[0]:
            return MORE_GOALS
        pops -= 1
        counters[LOWEST] = queue.keys[0]
        label = queue.items[0]
        _pop(memory, entries, paths)
        known = states.known[paths.row[label]]
        for e in range(scratch.key.shape[0]):
            scratch.key[e] = paths.key[label, e]
        _write_bound(memory.product, entries, known, scratch)
        if _is_beaten(memory, entries, vectors, known, scratch):
            continue
        _close(entries, vectors, counters, known, scratch)
        if known[SATISFIED] < 0:
            counters[GOALS] = _insert(entries, vectors.of_goals, 0, counters[GOALS], scratch.bound)
            counters[FOUND] = label
            return GOAL
        expand(memory, label, paths.row[label])


@bare_kernel
def _enter(
    memory: Memory, entries: Entries, bounds: ObjectiveBounds, paths: Paths, vectors: Vectors, scratch: Vector
) -> Integer:
    """Make a label of the next successor, unless it is dominated or out of bounds; return why if it cannot be done."""
    view, states, counters, buffer = memory.product, memory.states, memory.counters, memory.buffer
    parent, k = counters[PARENT], next_successor(counters)
    satisfied = np.int64(0) if parent == NONE else states.known[paths.row[parent], SATISFIED]
    if not _write_key(view, entries, paths, parent, satisfied, buffer, k, scratch.key):
        return TOO_LARGE
    rows = counters[ROWS]
    code = buffer.code[k]
    row = enter_state(memory, code, 0, UNBOUNDED, UNBOUNDED, UNBOUNDED)
    if row == NONE:
        return MORE_ROWS
    known = states.known[row]
    if row == rows:
        known[FIRST], known[SIZE], known[CAPACITY] = 0, 0, 0
        node = decode(view, code, buffer.choice)
        write_bounds(bounds, buffer.digits.seen, node, buffer.choice, known[SATISFIED] & ~GOAL_BIT, scratch.growth)
        for e in range(scratch.growth.shape[0]):
            known[BOUND + e] = scratch.growth[e]
    if known[BOUND] >= INFINITE:
        return ENTERED
    _freeze(view, entries, satisfied, known[SATISFIED], scratch.key)
    _write_bound(view, entries, known, scratch)
    if _is_beaten(memory, entries, vectors, known, scratch):
        return ENTERED
    for e in range(scratch.bound.shape[0]):
        if scratch.bound[e] >= INFINITE:
            return TOO_LARGE
    label = counters[LABELS]
    if label == paths.row.shape[0]:
        return MORE_LABELS
    paths.row[label], paths.parent[label] = row, parent
    paths.step[label] = k if parent == NONE else (buffer.cost[k] if entries.edge_costs.shape[1] else NONE)
    for e in range(scratch.key.shape[0]):
        paths.key[label, e] = scratch.key[e]
    _push(memory, entries, paths, scratch.bound[entries.order[0]], label)
    counters[LABELS] += 1
    return ENTERED


@bare_kernel
def _write_key(
    view: ProductView,
    entries: Entries,
    paths: Paths,
    parent: Integer,
    satisfied: Integer,
    buffer: Successors,
    k: Integer,
    key: np.ndarray,
) -> bool:
    """Write the entries of a successor, but for what becomes satisfied; return whether 64 bits hold them for sure."""
    costs, additive, maxima = entries.cost_limit.shape[0], entries.of.shape[0], entries.of_maximum.shape[0]
    for e in range(key.shape[0]):
        key[e] = 0 if parent == NONE else paths.key[parent, e]
    if parent != NONE:
        for a in range(additive):
            key[costs + a] += _growth(view, entries, a, satisfied, key, buffer.cost[k])
        for d in range(costs):
            key[d] += _step(entries, d, buffer.cost[k])
            if _spent(view, key, d) >= entries.cost_limit[d]:
                return False
    for m in range(maxima):
        at_least = entries.maximum[m, satisfied] * _spent(view, key, entries.of_maximum[m])
        key[costs + additive + m] = max(key[costs + additive + m], at_least)
    if view.relaxed or parent == NONE:
        for a in range(additive):
            for i in range(entries.violation.shape[1]):
                key[costs + a] += entries.violation[a, i] * buffer.violation[k, i]
        first = key.shape[0] - entries.paid.shape[0]
        for v in range(entries.paid.shape[0]):
            key[first + v] += buffer.violation[k, entries.paid[v]]
    return True


@bare_kernel
def _growth(
    view: ProductView, entries: Entries, a: Integer, satisfied: Integer, key: np.ndarray, edge: Integer
) -> Integer:
    """Return what a step adds to an additive entry, given the entries before."""
    d = entries.of[a]
    before = _spent(view, key, d)
    after = key[d] + _step(entries, d, edge)
    if d == 0:
        after >>= view.shift
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
def _spent(view: ProductView, key: np.ndarray, d: Integer) -> Integer:
    """Return one of the total costs, in units."""
    return key[d] >> view.shift if d == 0 else key[d]


@bare_kernel
def _freeze(view: ProductView, entries: Entries, before: Integer, after: Integer, key: np.ndarray) -> None:
    """Enter the costs of the tasks that become satisfied."""
    first = key.shape[0] - entries.paid.shape[0] - entries.frozen.shape[0]
    for c in range(entries.frozen.shape[0]):
        i = entries.frozen[c, 1]
        if after >> i & 1 and not before >> i & 1:
            key[first + c] = _spent(view, key, entries.frozen[c, 0])


@bare_kernel
def _write_bound(view: ProductView, entries: Entries, known: np.ndarray, scratch: Vector) -> None:
    """Write what each entry of a label will be at least at the end; of a task not yet satisfied, what is spent."""
    key, bounded = scratch.key, scratch.growth.shape[0]
    for e in range(key.shape[0]):
        scratch.bound[e] = key[e] + (known[BOUND + e] if e < bounded else 0)
    first = key.shape[0] - entries.paid.shape[0] - entries.frozen.shape[0]
    for c in range(entries.frozen.shape[0]):
        if not known[SATISFIED] >> entries.frozen[c, 1] & 1:
            scratch.bound[first + c] = _spent(view, key, entries.frozen[c, 0])


@bare_kernel
def _is_beaten(memory: Memory, entries: Entries, vectors: Vectors, known: np.ndarray, scratch: Vector) -> bool:
    """Return whether a label exceeds a limit, or is no better than one expanded at its state, or than a goal."""
    for e in range(memory.limits.shape[0]):
        if scratch.bound[e] > memory.limits[e]:
            return True
    if _is_dominated(entries, vectors.of_states, known[FIRST], known[SIZE], scratch.key):
        return True
    return _is_dominated(entries, vectors.of_goals, 0, memory.counters[GOALS], scratch.bound)


@bare_kernel
def _is_dominated(entries: Entries, vectors: np.ndarray, first: Integer, size: Integer, entry: np.ndarray) -> bool:
    """Return whether one of some truncated vectors is no worse than that of some entries; move it to the front."""
    width = vectors.shape[1]
    for v in range(first, first + size):
        no_worse = True
        for t in range(width):
            if vectors[v, t] > entry[entries.order[t + 1]]:
                no_worse = False
                break
        if no_worse:
            if v > first:
                nearer = (first + v) // 2
                for t in range(width):
                    vectors[v, t], vectors[nearer, t] = vectors[nearer, t], vectors[v, t]
            return True
    return False


@bare_kernel
def _insert(entries: Entries, vectors: np.ndarray, first: Integer, size: Integer, entry: np.ndarray) -> Integer:
    """Add the truncated vector of some entries in place of those that it dominates, and return the new number."""
    width = vectors.shape[1]
    kept = first
    for v in range(first, first + size):
        better = False
        for t in range(width):
            if vectors[v, t] < entry[entries.order[t + 1]]:
                better = True
                break
        if better:
            if kept < v:
                for t in range(width):
                    vectors[kept, t] = vectors[v, t]
            kept += 1
    for t in range(width):
        vectors[kept, t] = entry[entries.order[t + 1]]
    return kept + 1 - first


@bare_kernel
def _most_vectors(states: States, row: Integer) -> Integer:
    """Return how many vectors a state may have, VECTORS_AT_FIRST at least."""
    return max(np.int64(VECTORS_AT_FIRST), states.known[row, CAPACITY])


@bare_kernel
def _close(entries: Entries, vectors: Vectors, counters: np.ndarray, known: np.ndarray, scratch: Vector) -> None:
    """Add a label's truncated vector to those of its state, which move where there is no room for one more."""
    if known[SIZE] == known[CAPACITY]:
        first = counters[VECTORS]
        for v in range(known[SIZE]):
            for t in range(vectors.of_states.shape[1]):
                vectors.of_states[first + v, t] = vectors.of_states[known[FIRST] + v, t]
        known[FIRST] = first
        known[CAPACITY] = max(np.int64(VECTORS_AT_FIRST), 2 * known[CAPACITY])
        counters[VECTORS] += known[CAPACITY]
    known[SIZE] = _insert(entries, vectors.of_states, known[FIRST], known[SIZE], scratch.key)


@bare_kernel
def _precedes(entries: Entries, states: States, paths: Paths, label: Integer, other: Integer) -> bool:
    """Return whether a label comes before another one of the same first bound: by the others, then the last made."""
    row, other_row = paths.row[label], paths.row[other]
    bounded = entries.cost_limit.shape[0] + entries.of.shape[0]
    for t in range(1, entries.order.shape[0]):
        e = entries.order[t]
        here, there = paths.key[label, e], paths.key[other, e]
        if e < bounded:
            here += states.known[row, BOUND + e]
            there += states.known[other_row, BOUND + e]
        if here != there:
            return bool(here < there)
    return bool(label > other)


@bare_kernel
def _push(memory: Memory, entries: Entries, paths: Paths, bound: Integer, label: Integer) -> None:
    """Insert a label into the open list."""
    queue, counters, states = memory.queue, memory.counters, memory.states
    at = counters[OPEN]
    while at > 0:
        up = (at - 1) // 2
        if queue.keys[up] < bound or (
            queue.keys[up] == bound and _precedes(entries, states, paths, queue.items[up], label)
        ):
            break
        queue.keys[at], queue.items[at] = queue.keys[up], queue.items[up]
        at = up
    queue.keys[at], queue.items[at] = bound, label
    counters[OPEN] += 1


@bare_kernel
def _pop(memory: Memory, entries: Entries, paths: Paths) -> None:
    """Remove the first label from the open list."""
    queue, counters, states = memory.queue, memory.counters, memory.states
    counters[OPEN] -= 1
    count = counters[OPEN]
    bound, label = queue.keys[count], queue.items[count]
    at = 0
    while True:
        down = 2 * at + 1
        if down >= count:
            break
        if down + 1 < count:
            right, left = queue.keys[down + 1], queue.keys[down]
            if right < left or (
                right == left and _precedes(entries, states, paths, queue.items[down + 1], queue.items[down])
            ):
                down += 1
        if bound < queue.keys[down] or (
            bound == queue.keys[down] and _precedes(entries, states, paths, label, queue.items[down])
        ):
            break
        queue.keys[at], queue.items[at] = queue.keys[down], queue.items[down]
        at = down
    queue.keys[at], queue.items[at] = bound, label
