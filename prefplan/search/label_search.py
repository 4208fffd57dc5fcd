"""BOA* for any number of costs and preferences, compiled.

C. Hernandez Ulloa et al., "A Simple and Fast Bi-Objective Search Algorithm", ICAPS 2020; for more than two objectives
as NAMOA* (L. Mandow and J. L. Perez de la Cruz, "Multiobjective A* search with consistent heuristics", Journal of the
ACM 2010). If only one objective is wanted, this is Algorithm 1 with bounds on the others, and A* without.

A new label is compared with all undominated labels of its product state, expanded or not: it is dropped if one of them
is no worse in every compared entry of the label key (`keys`). It is dropped, too, if the lower bounds of its objectives
exceed a limit, or are no better than a goal. Labels are expanded in order of the bound of the first objective.

For more than two objectives a new label is compared with expanded labels only, and again when it is popped (LTMOA*:
C. Hernandez et al., "Multi-objective Search via Lazy and Efficient Dominance Checks", IJCAI 2023). Expanded labels have
no more of the first objective: only the other entries are compared, and few labels need be kept (NAMOA*dr: F. J.
Pulido, L. Mandow and J. L. Perez-de-la-Cruz, "Dimensionality reduction in multiobjective shortest path search", 2015).

Tables of `pattern_database` are looked up when a product state is first met; the bounds by landmarks and Lagrangian
relaxation only when a label is popped: most states are never expanded.
"""

import numpy as np

from prefplan.heuristics.lagrangian import lagrangian_bound
from prefplan.heuristics.landmarks import landmark_bound
from prefplan.heuristics.pattern_database import Tables, bound_of
from prefplan.heuristics.prepare import Bounds
from prefplan.heuristics.projection import observe
from prefplan.models.kernels import INFINITE, UNBOUNDED, Integer, bare_kernel, inner_kernel
from prefplan.product.heap import heap_pop, heap_push
from prefplan.product.space import Automata, Space, decode
from prefplan.product.successors import successors
from prefplan.search.labels import (
    AT,
    BOUND,
    CODE,
    DOMINATED,
    END,
    GOAL_BIT,
    HEAD,
    LOOKED,
    NONE,
    SATISFIED,
    Keys,
    Memory,
    grow,
    insert,
    is_dominated,
    slot_of,
)


@bare_kernel
def run(space: Space, keys: Keys, bounds: Bounds, memory: Memory, pops: Integer) -> Integer:
    """Expand labels until enough goals are found, memory is used up or `pops` are popped; return the reason (`END`)."""
    labels, queue, counters, limits = memory.labels, memory.queue, memory.counters, memory.limits
    ranks = labels.key[:, : keys.objectives * keys.lexicographic]
    while True:
        while counters[AT.NEXT] < counters[AT.COUNT]:
            end = _enter(space.automata, keys, bounds.tables, memory)
            if end != END.ENTERED:
                return end
            counters[AT.NEXT] += 1
        if counters[AT.OPEN] == 0:
            return END.EXHAUSTED
        if pops == 0:
            return END.PAUSED
        pops -= 1
        counters[AT.LOWEST], label = queue.keys[0], queue.items[0]
        counters[AT.OPEN] = heap_pop(queue.keys, queue.items, counters[AT.OPEN], ranks)
        estimate = _estimate(space.automata, keys, bounds, memory, label)
        if estimate > counters[AT.LOWEST]:
            if estimate < UNBOUNDED:
                counters[AT.OPEN] = heap_push(queue.keys, queue.items, counters[AT.OPEN], estimate, label, ranks)
            continue
        row = memory.states.table[labels.row[label]]
        if keys.lazy:
            insert(keys, labels, row, label)
        if row[SATISFIED] < 0:
            memory.found[counters[AT.FOUND]] = label
            counters[AT.FOUND] += 1
            if keys.objectives == 2:
                # Goals are found in order of the first objective: the next one must have less of the other.
                limits[1 - keys.first] = labels.key[label, 1 - keys.first] - 1
            else:
                _add_goal(keys, memory, label)
            if counters[AT.FOUND] == memory.found.shape[0]:
                return END.GOALS
            continue
        counters[AT.EXPANDED] += 1
        counters[AT.PARENT], counters[AT.NEXT] = label, 0
        counters[AT.COUNT] = successors(
            space.automata, space.edges, space.shortcuts, space.generated, row[CODE], memory.buffer
        )


@inner_kernel
def _estimate(automata: Automata, keys: Keys, bounds: Bounds, memory: Memory, label: Integer) -> Integer:
    """Return a lower bound of the first objective of a popped label's plans, UNBOUNDED if the label is pruned.

    If the first objective is the first cost, the bounds by landmarks and by Lagrangian relaxation are looked up here.
    """
    labels, limits, states = memory.labels, memory.limits, memory.buffer.automata
    row, first = memory.states.table[labels.row[label]], keys.first
    if (keys.lazy and is_dominated(keys, labels, row[HEAD], label)) or labels.sibling[label] == DOMINATED:
        return np.int64(UNBOUNDED)
    if _is_beaten(keys, memory, row, label):
        return np.int64(UNBOUNDED)
    estimate = labels.key[label, first] + row[BOUND + first]
    if first == 0:
        node = decode(automata, row[CODE], states)
        if not row[LOOKED]:
            row[BOUND], row[LOOKED] = max(row[BOUND], landmark_bound(bounds.landmarks, node, states)), 1
        within = lagrangian_bound(bounds.lagrangian, node, states, limits[1] - labels.key[label, 1])
        rest = max(row[BOUND], within << keys.shift)
        estimate = labels.key[label, 0] + rest if rest < INFINITE else np.int64(UNBOUNDED)
    return estimate if estimate <= limits[first] else np.int64(UNBOUNDED)


@inner_kernel
def _enter(automata: Automata, keys: Keys, tables: Tables, memory: Memory) -> Integer:
    """Make a label of the next successor unless it is pruned; return ENTERED, or why that is not possible (`END`)."""
    states, labels, counters, buffer = memory.states, memory.labels, memory.counters, memory.buffer
    # Of equal labels the last made is expanded first; so the model's first action is entered last, to be preferred.
    k, parent, label = counters[AT.COUNT] - 1 - counters[AT.NEXT], counters[AT.PARENT], counters[AT.LABELS]
    if label == labels.row.shape[0]:
        return END.MORE_LABELS
    key = labels.key[label]
    for e in range(key.shape[0]):
        key[e] = memory.begin[k, e] if parent == NONE else labels.key[parent, e]
    if parent != NONE:
        satisfied = states.table[labels.row[parent], SATISFIED]
        if not grow(keys, satisfied, buffer.step[k], buffer.violation[k], key):
            return END.TOO_LARGE
    for e in range(keys.objectives):
        if key[e] > memory.limits[e]:
            return END.ENTERED
    slot = slot_of(states, buffer.code[k])
    number = np.int64(states.slots[slot])
    if number == NONE:
        number = counters[AT.ROWS]
        if number == states.table.shape[0]:
            return END.MORE_ROWS
        _bound_state(automata, keys, tables, buffer.code[k], states.table[number], buffer.automata)
    row = states.table[number]
    if _is_beaten(keys, memory, row, label):
        return END.ENTERED
    if states.slots[slot] == NONE:
        states.slots[slot] = number
        counters[AT.ROWS] += 1
    elif is_dominated(keys, labels, row[HEAD], label):
        return END.ENTERED
    if keys.computed:
        end = keys.evaluate(label)
        if end != END.ENTERED:
            return end
        if _is_beaten(keys, memory, row, label) or is_dominated(keys, labels, row[HEAD], label):
            return END.ENTERED
    for e in range(keys.objectives):
        if key[e] + row[BOUND + e] >= INFINITE:
            return END.TOO_LARGE
    step = k if parent == NONE else (buffer.step[k] if keys.edge_costs.shape[1] else np.int64(NONE))
    labels.row[label], labels.parent[label], labels.step[label] = number, parent, step
    labels.sibling[label] = NONE
    if not keys.lazy:
        insert(keys, labels, row, label)
    estimate = max(key[keys.first] + row[BOUND + keys.first], counters[AT.LOWEST])
    ranks = labels.key[:, : keys.objectives * keys.lexicographic]
    counters[AT.OPEN] = heap_push(memory.queue.keys, memory.queue.items, counters[AT.OPEN], estimate, label, ranks)
    counters[AT.LABELS] += 1
    return END.ENTERED


@inner_kernel
def _bound_state(
    automata: Automata, keys: Keys, tables: Tables, code: Integer, row: np.ndarray, states: np.ndarray
) -> None:
    """Fill the row of a new product state."""
    node = decode(automata, code, states)
    satisfied, is_goal = 0, True
    for i in range(automata.ends.shape[0]):
        if states[i] == automata.ends[i, 0]:
            satisfied |= 1 << i
        elif states[i] != automata.ends[i, 1]:
            is_goal = False
    row[SATISFIED], row[HEAD], row[CODE] = satisfied | (GOAL_BIT if is_goal else 0), NONE, code
    row[LOOKED] = 0
    observe(tables.projections, node)
    for e in range(keys.objectives):
        row[BOUND + e] = bound_of(tables, node, states, np.int64(e))


@inner_kernel
def _is_beaten(keys: Keys, memory: Memory, row: np.ndarray, label: Integer) -> bool:
    """Return whether a label's lower bounds exceed a limit, or are no better than some goal."""
    key, goals = memory.labels.key, memory.goals
    for e in range(keys.objectives):
        if row[BOUND + e] >= INFINITE or key[label, e] + row[BOUND + e] > memory.limits[e]:
            return True
    for g in range(memory.counters[AT.GOALS]):
        better = False
        for e in range(keys.objectives):
            if e != keys.first and key[label, e] + row[BOUND + e] < key[goals[g], e]:
                better = True
                break
        if not better:
            goals[g], goals[g // 2] = goals[g // 2], goals[g]
            return True
    return False


@inner_kernel
def _add_goal(keys: Keys, memory: Memory, label: Integer) -> None:
    """Add a goal, and remove goals that prune no more than the new one.

    Goals are found in order of the first objective, so that only the others need be compared.
    """
    key, goals, counters = memory.labels.key, memory.goals, memory.counters
    kept = 0
    for g in range(counters[AT.GOALS]):
        for e in range(keys.objectives):
            if e != keys.first and key[goals[g], e] < key[label, e]:
                goals[kept] = goals[g]
                kept += 1
                break
    goals[kept] = label
    counters[AT.GOALS] = kept + 1
