"""LTMOA*: all non-dominated vectors of any number of costs and preferences, compiled.

C. Hernandez, W. Yeoh, J. A. Baier, A. Felner, O. Salzman, H. Zhang, S.-H. Chan and S. Koenig, "Multi-objective Search
via Lazy and Efficient Dominance Checks", IJCAI 2023, with the dimensionality reduction of NAMOA*dr (F. J. Pulido,
L. Mandow and J. L. Perez-de-la-Cruz, "Dimensionality reduction in multiobjective shortest path search", 2015).

Labels are expanded in lexicographic order of their bounds. Bounds never fall along a path, so that the first entry of a
label is never less than those of the labels expanded before at the same product state: only the other entries, the
*truncated* vectors, need be compared, with a list for each state from which dominated vectors are removed. Goals have
one more such list. Labels in the open list are not compared with one another.

If one objective is wanted and all are sums along paths, then the first label expanded at a state has the
lexicographically least continuation: no entry need be compared but those that have a bound, so that without bounds this
is A* with ties broken by the other objectives.

`entry_map` describes the entries of a label. At a product state all that are compared count; against goals, objectives.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.heuristics.pattern_database import cost_bound
from prefplan.heuristics.preference_bound import growth_bound
from prefplan.heuristics.prepare import Bounds
from prefplan.heuristics.projection import observe
from prefplan.models.kernels import INFINITE, Integer, bare_kernel
from prefplan.product.space import Space, decode
from prefplan.search.labels import (
    AT,
    COL,
    END,
    GOAL_BIT,
    NONE,
    Memory,
    States,
    describe,
    expand,
    next_successor,
    slot_of,
)
from prefplan.search.multi_objective.entries import (
    BOUND,
    CAPACITY,
    FIRST,
    SIZE,
    Entries,
    Program,
    Vector,
    compute,
    follow,
    freeze,
    write_vectors,
)
from prefplan.search.multi_objective.open_list import lexicographic_pop, lexicographic_push

GOALS, VECTORS = len(AT), len(AT) + 1
"""Indices of the counters of goals' truncated vectors, and of all others with the gaps between them."""

MORE_VECTORS, MORE_GOALS = END.FALLS + 1, END.FALLS + 2
"""More reasons why a run of the kernel ended."""

VECTORS_AT_FIRST = 4
"""Truncated vectors for which an expanded product state has memory at first."""


class Vectors(NamedTuple):
    """Truncated vectors: of_states: (X, W) int64, contiguous for each product state, and of_goals: (G, O - 1)."""

    of_states: np.ndarray
    of_goals: np.ndarray


@bare_kernel
def run(
    space: Space,
    entries: Entries,
    program: Program,
    bounds: Bounds,
    memory: Memory,
    vectors: Vectors,
    scratch: Vector,
    pops: Integer,
) -> Integer:
    """Expand labels until a goal is found, memory runs out or enough were popped; return which (`END`).

    Args:
        space: what is searched.
        entries: the layout of labels.
        program: how some of the entries are computed.
        bounds: heuristics.
        memory: of the search. `labels` with their keys; `queue`: by the bound of the first objective; `limits`: (O,),
            inclusive, of the objectives in the order of comparison; in `buffer`, a successor's `cost` is the number of
            its edge or action if `entries.edge_costs` has columns.
        vectors: truncated vectors.
        scratch: for one label.
        pops: most labels to pop from the open list.
    """
    states, labels, queue, counters = memory.states, memory.labels, memory.queue, memory.counters
    while True:
        while counters[AT.NEXT] < counters[AT.COUNT]:
            end = _enter(space, entries, program, bounds, memory, vectors, scratch)
            if end != END.ENTERED:
                return end
            counters[AT.NEXT] += 1
        if counters[AT.OPEN] == 0:
            return END.EXHAUSTED
        if pops == 0:
            return END.PAUSED
        if counters[VECTORS] + 2 * _most_vectors(states, labels.row[queue.items[0]]) > vectors.of_states.shape[0]:
            return MORE_VECTORS
        if counters[GOALS] == vectors.of_goals.shape[0]:
            return MORE_GOALS
        pops -= 1
        counters[AT.LOWEST] = queue.keys[0]
        label = queue.items[0]
        lexicographic_pop(space.shift, queue, counters, states, entries, labels)
        known = states.known[labels.row[label]]
        for e in range(scratch.key.shape[0]):
            scratch.key[e] = labels.key[label, e]
        write_vectors(space.shift, entries, known, scratch)
        if _is_beaten(memory.limits, counters[GOALS], vectors, known, scratch):
            continue
        _close(vectors, counters, known, scratch)
        if known[COL.SATISFIED] < 0:
            counters[GOALS] = _insert(vectors.of_goals, 0, counters[GOALS], scratch.bound[1:])
            counters[AT.FOUND] = label
            return END.GOAL
        expand(space, memory.buffer, counters, label, known[COL.CODE])


@bare_kernel
def _enter(
    space: Space,
    entries: Entries,
    program: Program,
    bounds: Bounds,
    memory: Memory,
    vectors: Vectors,
    scratch: Vector,
) -> Integer:
    """Make a label of the next successor unless it is pruned; return ENTERED, or why that is not possible (`END`)."""
    states, labels, counters = memory.states, memory.labels, memory.counters
    limits, buffer = memory.limits, memory.buffer
    parent, k = counters[AT.PARENT], next_successor(counters)
    satisfied = np.int64(0) if parent == NONE else states.known[labels.row[parent], COL.SATISFIED]
    for e in range(scratch.key.shape[0]):
        scratch.key[e] = memory.begin[k, e] if parent == NONE else labels.key[parent, e]
    if parent != NONE:
        paid = buffer.violation[k]
        if not follow(space.shift, entries, satisfied, buffer.cost[k], paid, space.automata.pays, scratch.key):
            return END.TOO_LARGE
    slot = slot_of(states, buffer.code[k])
    row = np.int64(states.slots[slot])
    if row == NONE:
        row = counters[AT.ROWS]
        if row == states.known.shape[0]:
            return END.MORE_ROWS
        _bound_state(space, bounds, buffer.code[k], states.known[row], buffer.automata)
        states.slots[slot] = row
        counters[AT.ROWS] += 1
    known = states.known[row]
    if known[BOUND] >= INFINITE:
        return END.ENTERED
    if parent != NONE:
        freeze(space.shift, entries, satisfied, known[COL.SATISFIED], scratch.key)
    write_vectors(space.shift, entries, known, scratch)
    if _is_beaten(limits, counters[GOALS], vectors, known, scratch):
        return END.ENTERED
    if program.computed.shape[0]:
        end = compute(space.shift, entries, program, known[COL.SATISFIED], scratch.key)
        if end != END.ENTERED:
            return end
        write_vectors(space.shift, entries, known, scratch)
        if _is_beaten(limits, counters[GOALS], vectors, known, scratch):
            return END.ENTERED
    for o in range(scratch.bound.shape[0]):
        if scratch.bound[o] >= INFINITE:
            return END.TOO_LARGE
    label = counters[AT.LABELS]
    if label == labels.row.shape[0]:
        return END.MORE_LABELS
    labels.row[label], labels.parent[label] = row, parent
    labels.step[label] = k if parent == NONE else (buffer.cost[k] if entries.edge_costs.shape[1] else NONE)
    for e in range(scratch.key.shape[0]):
        labels.key[label, e] = scratch.key[e]
    lexicographic_push(space.shift, memory.queue, counters, states, entries, labels, scratch.bound[0], label)
    counters[AT.LABELS] += 1
    return END.ENTERED


@bare_kernel
def _bound_state(space: Space, bounds: Bounds, code: Integer, known: np.ndarray, automata: np.ndarray) -> None:
    """Fill the row of a new product state; `automata` is scratch."""
    node = decode(space.automata.nodes, space.automata.sizes, code, automata)
    describe(space.automata.ends, code, automata, known)
    observe(bounds.projections, node)
    known[FIRST], known[SIZE], known[CAPACITY] = 0, 0, 0
    costs, satisfied = bounds.patterns.table.shape[0], known[COL.SATISFIED] & ~GOAL_BIT
    for o in range(known.shape[0] - BOUND):
        if o < costs:
            known[BOUND + o] = cost_bound(bounds.patterns, bounds.projections, node, automata, o)
        else:
            known[BOUND + o] = growth_bound(bounds.blocks, bounds.projections, node, automata, satisfied, o - costs)


@bare_kernel
def _is_beaten(limits: np.ndarray, goals: Integer, vectors: Vectors, known: np.ndarray, scratch: Vector) -> bool:
    """Return whether a label exceeds a limit, or is no better than one expanded at its state, or than a goal."""
    for o in range(limits.shape[0]):
        if scratch.bound[o] > limits[o]:
            return True
    if _is_dominated(vectors.of_states, known[FIRST], known[SIZE], scratch.truncated):
        return True
    return _is_dominated(vectors.of_goals, 0, goals, scratch.bound[1:])


@bare_kernel
def _is_dominated(vectors: np.ndarray, first: Integer, size: Integer, one: np.ndarray) -> bool:
    """Return whether a truncated vector is no worse than another one, and swap it halfway to the front."""
    width = vectors.shape[1]
    for v in range(first, first + size):
        no_worse = True
        for t in range(width):
            if vectors[v, t] > one[t]:
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
def _insert(vectors: np.ndarray, first: Integer, size: Integer, one: np.ndarray) -> Integer:
    """Add a truncated vector, remove those that it dominates, and return the new number."""
    width = vectors.shape[1]
    kept = first
    for v in range(first, first + size):
        better = False
        for t in range(width):
            if vectors[v, t] < one[t]:
                better = True
                break
        if better:
            if kept < v:
                for t in range(width):
                    vectors[kept, t] = vectors[v, t]
            kept += 1
    for t in range(width):
        vectors[kept, t] = one[t]
    return kept + 1 - first


@bare_kernel
def _most_vectors(states: States, row: Integer) -> Integer:
    """Return how many vectors a state has memory for, or VECTORS_AT_FIRST if that is more."""
    return max(np.int64(VECTORS_AT_FIRST), states.known[row, CAPACITY])


@bare_kernel
def _close(vectors: Vectors, counters: np.ndarray, known: np.ndarray, scratch: Vector) -> None:
    """Add a label's truncated vector to those of its state, which move to the end if their memory is full."""
    if known[SIZE] == known[CAPACITY]:
        first = counters[VECTORS]
        for v in range(known[SIZE]):
            for t in range(vectors.of_states.shape[1]):
                vectors.of_states[first + v, t] = vectors.of_states[known[FIRST] + v, t]
        known[FIRST] = first
        known[CAPACITY] = max(np.int64(VECTORS_AT_FIRST), 2 * known[CAPACITY])
        counters[VECTORS] += known[CAPACITY]
    known[SIZE] = _insert(vectors.of_states, known[FIRST], known[SIZE], scratch.truncated)
