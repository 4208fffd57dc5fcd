"""Labels: how their keys grow along a step and are compared; memory for labels, product states and the open list.

`keys` says which entries a key has. Memory is doubled between two runs of a kernel, so that memory can be limited, and
a search interrupted.
"""

from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np

from prefplan.errors import LimitError
from prefplan.limits import check_limits
from prefplan.models.kernels import Integer, inner_kernel, kernel
from prefplan.product.successors import Successors

PRODUCT_LIMIT = 2**61
"""Products of a cost and a weight stay below this."""

COST, SUM, MAXIMUM, TASK, VIOLATION, VALUE = range(6)
"""How an entry grows: with a cost; at a rate; to a maximum; with a cost until a task is satisfied; only where violation
costs are paid; as computed by `Keys.evaluate`."""


class Keys(NamedTuple):
    """The K entries of label keys, for N tasks of which P may have violation costs, and how they grow.

    Attributes:
        entries: (K, 3) int64, how each entry grows, the cost that it grows with, and the row of its rates or its task.
        rates: (R, 2^N) int64, by set of satisfied tasks: the growth of a sum per unit of its cost, or the weight w of
            a maximum, which is at least w times its cost.
        late: (L, 4) int64, entry, task, slope and offset: until the task is satisfied, a sum grows with
            max(0, slope * cost - offset).
        violation: (K, P) int64, growth of each entry per unit of violation cost.
        edge_costs: (D, E) int64, costs of each edge, or of each price where states are generated;
            (1, 0) where successors come with their only cost.
        compared: (W,) int64, entries by which labels of a product state are compared; ~e for e in opposite direction.
        shift: number of low bits of the first cost, which count actions.
        objectives: O, the number of objectives, which are the first entries.
        first: the objective in whose order goals are found.
        lexicographic: whether a label is no worse than another only if its objectives are lexicographically no larger,
            too. Of labels with equal bounds of the first objective, the lexicographically smallest is expanded first.
        lazy: whether labels are compared with expanded ones only; `compared` then lacks the first objective.
        cost_limit: from this cost on, cost times weight might not fit 64 bits.
        computed: whether some entries are values.
        evaluate: (label) -> ENTERED once the values are in its key, or TOO_LARGE (`END`); None in Python.
    """

    entries: np.ndarray
    rates: np.ndarray
    late: np.ndarray
    violation: np.ndarray
    edge_costs: np.ndarray
    compared: np.ndarray
    shift: int
    objectives: int
    first: int
    lexicographic: bool
    lazy: bool
    cost_limit: int
    computed: bool
    evaluate: Any


@inner_kernel
def spent(keys: Keys, key: np.ndarray, d: Integer) -> Integer:
    """Return one of the total costs, in units: without the low bits of the first cost, which count actions."""
    return key[d] >> keys.shift if d == 0 else key[d]


@inner_kernel
def grow(keys: Keys, satisfied: Integer, step: Integer, violation: np.ndarray, key: np.ndarray) -> bool:
    """Replace a label's `key` by that of a successor, except for values; return whether it fits 64 bits for sure.

    `satisfied` are the tasks before the step, as bits; `step` is its cost, or the number of its edge or price, and
    `violation` (P,) the violation costs that it pays, or (0,) if no step pays any.
    """
    numbered = keys.edge_costs.shape[1] > 0
    for d in range(keys.edge_costs.shape[0]):
        key[d] += keys.edge_costs[d, step] if numbered else step
        if spent(keys, key, d) >= keys.cost_limit:
            return False
    for e in range(keys.edge_costs.shape[0], key.shape[0]):
        how, d, row = keys.entries[e, 0], keys.entries[e, 1], keys.entries[e, 2]
        after = spent(keys, key, d)
        if how == SUM:
            key[e] += keys.rates[row, satisfied] * (after - _before(keys, key, d, step))
        elif how == MAXIMUM:
            key[e] = max(key[e], keys.rates[row, satisfied] * after)
        elif how == TASK and not satisfied >> row & 1:
            key[e] = after
        for i in range(violation.shape[0]):
            key[e] += keys.violation[e, i] * violation[i]
    for t in range(keys.late.shape[0]):
        e, i, slope, offset = keys.late[t, 0], keys.late[t, 1], keys.late[t, 2], keys.late[t, 3]
        if not satisfied >> i & 1:
            d = keys.entries[e, 1]
            before, after = _before(keys, key, d, step), spent(keys, key, d)
            key[e] += max(0, slope * after - offset) - max(0, slope * before - offset)
    return True


@inner_kernel
def _before(keys: Keys, key: np.ndarray, d: Integer, step: Integer) -> Integer:
    """Return a total cost before the step that the costs in `key` already count."""
    before = key[d] - (keys.edge_costs[d, step] if keys.edge_costs.shape[1] else step)
    return before >> keys.shift if d == 0 else before


NONE = -1
"""Stands for a row or label that does not exist."""

DOMINATED = -2
"""Sibling of a label that another label dominates."""

# Indices of a search's counters. The buffer has COUNT successors of label PARENT (of no label at the start), of which
# NEXT are entered: a run of a kernel continues where the last one ended.
Counters = namedtuple("Counters", "ROWS LABELS OPEN LOWEST EXPANDED FOUND PARENT NEXT COUNT GOALS")
AT = Counters(*range(10))

# Columns of a product state's row: satisfied tasks as bits (with GOAL_BIT if no task is left, which makes them
# negative), the last of its labels, its code, whether the bound by landmarks was looked up, and from BOUND on lower
# bounds of the growth of each objective to a goal.
SATISFIED, HEAD, CODE, LOOKED, BOUND = range(5)

GOAL_BIT = -(2**31)

# Why a run of a kernel ended; ENTERED: it did not.
Ends = namedtuple("Ends", "ENTERED EXHAUSTED GOALS PAUSED MORE_ROWS MORE_LABELS TOO_LARGE")
END = Ends(*range(7))


class States(NamedTuple):
    """Product states met so far, one row each.

    Attributes:
        table: (R, F) int64, columns SATISFIED, HEAD, CODE, LOOKED, and those of bounds.
        slots: (H,) int32, open-addressing hash table of row numbers, -1 where empty; H is a power of two.
    """

    table: np.ndarray
    slots: np.ndarray


class Labels(NamedTuple):
    """Paths to product states.

    Attributes:
        row: (L,) int32, row of the product state.
        parent: (L,) int32, label of the path without its last step, or NONE.
        step: (L,) int32, number of the last edge or its price, NONE if contracted; without a parent, of the start.
        sibling: (L,) int32, the next of the product state's undominated labels, NONE or DOMINATED.
        key: (L, K) int64, entries as in `Keys`.
    """

    row: np.ndarray
    parent: np.ndarray
    step: np.ndarray
    sibling: np.ndarray
    key: np.ndarray


class Queue(NamedTuple):
    """The open list: a binary heap of labels (L,) int64 by their bounds (L,) int64 of the first objective."""

    keys: np.ndarray
    items: np.ndarray


class Memory(NamedTuple):
    """The state of a search, from which the next run of a kernel continues.

    Attributes:
        states: product states met so far.
        labels: labels made so far.
        queue: the open list.
        found: (F,) int32, labels of the goals that the last run of a kernel found.
        goals: (L,) int32, labels of the goals that prune most, if there are more than two objectives.
        counters: int64, by index `AT`.
        limits: (O,) int64, inclusive limits of the objectives.
        begin: (S, K) int64, the keys of the starts' labels.
        buffer: successors, and scratch.
    """

    states: States
    labels: Labels
    queue: Queue
    found: np.ndarray
    goals: np.ndarray
    counters: np.ndarray
    limits: np.ndarray
    begin: np.ndarray
    buffer: Successors


@inner_kernel
def slot_of(states: States, code: Integer) -> Integer:
    """Return the slot of a product state in the hash table; the slot is empty if the state has no row yet."""
    mask = states.slots.shape[0] - 1
    slot = _first_slot(code, mask)
    while states.slots[slot] >= 0 and states.table[states.slots[slot], CODE] != code:
        slot = (slot + 1) & mask
    return slot


@inner_kernel
def _first_slot(code: Integer, mask: Integer) -> Integer:
    """Return where to start looking for a product state in a hash table of mask + 1 slots."""
    return np.int64((np.uint64(code) * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(20)) & mask


@kernel
def rehash(states: States, rows: Integer) -> None:
    """Fill an emptied hash table with the first rows."""
    mask = states.slots.shape[0] - 1
    for row in range(rows):
        slot = _first_slot(states.table[row, CODE], mask)
        while states.slots[slot] >= 0:
            slot = (slot + 1) & mask
        states.slots[slot] = row


def enlarged(memory: Memory, end: int, free: float) -> Memory:
    """Return memory with arrays of twice the size for those that a run of the kernel used up; `end` is why it ended.

    Raises:
        LimitError: that would take more than the `free` bytes.
    """
    used_up = (*memory.states,) if end == END.MORE_ROWS else (*memory.labels, *memory.queue, memory.goals)
    if 2 * sum(array.nbytes for array in used_up) > free:
        raise LimitError("memory")
    if end == END.MORE_LABELS:
        labels, queue = Labels(*map(_longer, memory.labels)), Queue(*map(_longer, memory.queue))
        return memory._replace(labels=labels, queue=queue, goals=_longer(memory.goals))
    states = States(_longer(memory.states.table), np.full(2 * len(memory.states.slots), NONE, np.int32))
    rehash(states, int(memory.counters[AT.ROWS]))
    return memory._replace(states=states)


def _longer(array: np.ndarray) -> np.ndarray:
    """Return an array of twice the length that begins with the given one."""
    check_limits()
    longer = np.empty((2 * len(array), *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer


@inner_kernel
def no_worse(keys: Keys, one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether a label's key shows that it is no worse than another label of its product state."""
    for t in range(keys.compared.shape[0]):
        e = keys.compared[t]
        if (one[e] > other[e]) if e >= 0 else (spent(keys, one, ~e) < spent(keys, other, ~e)):
            return False
    if keys.lexicographic:
        if spent(keys, one, keys.first) != spent(keys, other, keys.first):
            return bool(one[keys.first] < other[keys.first])
        for e in range(keys.objectives):
            if spent(keys, one, e) != spent(keys, other, e):
                return bool(one[e] < other[e])
        return bool(one[0] <= other[0])
    return True


@inner_kernel
def is_dominated(keys: Keys, labels: Labels, head: Integer, new: Integer) -> bool:
    """Return whether some label of a product state, of which `head` is the last, is no worse than a new one."""
    label = head
    while label != NONE:
        if no_worse(keys, labels.key[label], labels.key[new]):
            return True
        label = labels.sibling[label]
    return False


@inner_kernel
def insert(keys: Keys, labels: Labels, row: np.ndarray, new: Integer) -> None:
    """Make a new label the last of its product state's, and mark those that it dominates."""
    label, last = np.int64(row[HEAD]), np.int64(new)
    while label != NONE:
        following = np.int64(labels.sibling[label])
        if no_worse(keys, labels.key[new], labels.key[label]):
            labels.sibling[label] = DOMINATED
        else:
            labels.sibling[last] = label
            last = label
        label = following
    labels.sibling[last] = NONE
    row[HEAD] = new
