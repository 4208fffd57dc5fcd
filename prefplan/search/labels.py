"""Memory of a search: product states met, their hash table, labels, and the open list.

Everything grows by doubling between two runs of a kernel, so that memory can be limited and a search interrupted.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np

from prefplan.heuristics.pattern_database import LIKELY
from prefplan.models.kernels import INFINITE, Integer, bare_kernel
from prefplan.product.heap import heap_pop, heap_push
from prefplan.product.space import Space, masks
from prefplan.product.successors import Successors, successors

NONE = -1
"""Stands for a row or a label that does not exist."""

# Indices of a search's counters. The successors from NEXT to COUNT in the buffer are those of label PARENT (of no label
# at the start) and still to be entered, so that a run of a kernel continues where the last one ended.
Counters = namedtuple("Counters", "ROWS LABELS OPEN LOWEST EXPANDED FOUND PARENT NEXT COUNT")
AT = Counters(*range(9))

# Columns of a product state's row, after those of its bound: satisfied tasks as bits (with GOAL_BIT if no task is left,
# which makes them negative), the bound of mu's growth, the last of its labels, and its code.
Columns = namedtuple("Columns", "SATISFIED GROWTH_BOUND HEAD CODE")
COL = Columns(*range(LIKELY + 1, LIKELY + 5))
COLUMNS = LIKELY + 5

GOAL_BIT = -(2**31)

# Why a run of a kernel ended; ENTERED: it did not; FALLS: mu falls along a trajectory.
Ends = namedtuple("Ends", "ENTERED EXHAUSTED GOAL PAUSED MORE_ROWS MORE_LABELS TOO_LARGE FALLS")
END = Ends(*range(8))


class States(NamedTuple):
    """Product states met so far, one row each.

    Attributes:
        known: (R, F) int64, columns COST_BOUND, LOOKED, LIKELY and `COL`, and those of the search.
        slots: (H,) int32, open-addressing hash table of row numbers, -1 where empty; H is a power of two.
    """

    known: np.ndarray
    slots: np.ndarray


class Labels(NamedTuple):
    """Labels of one cost and one preference: paths to product states.

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


class Queue(NamedTuple):
    """The open list: a binary heap of labels by cost + bound; of equal ones the last made comes first.

    Attributes:
        keys: (L,) int64 and items: (L,) int64.
    """

    keys: np.ndarray
    items: np.ndarray


class Memory(NamedTuple):
    """What a kernel works on, and continues from where its last run ended.

    Attributes:
        states: product states met.
        labels: of the search.
        queue: the open list.
        counters: int64, by index `AT`.
        limits: int64, of the objectives; see each kernel.
        begin: (K, E) int64, the entries of each start's label.
        buffer: successors, and scratch.
    """

    states: States
    labels: Any
    queue: Queue
    counters: np.ndarray
    limits: np.ndarray
    begin: np.ndarray
    buffer: Successors


@bare_kernel
def slot_of(states: States, code: Integer) -> Integer:
    """Return the slot of a product state in the hash table: that of its row, or the empty one for it."""
    mask = states.slots.shape[0] - 1
    slot = _first_slot(code, mask)
    while states.slots[slot] >= 0 and states.known[states.slots[slot], COL.CODE] != code:
        slot = (slot + 1) & mask
    return slot


@bare_kernel
def describe(ends: np.ndarray, code: Integer, automata: np.ndarray, known: np.ndarray) -> None:
    """Write what a new product state's row says of it, but for bounds."""
    satisfied, done = masks(ends, automata)
    known[COL.SATISFIED] = satisfied | (GOAL_BIT if done == (1 << ends.shape[0]) - 1 else 0)
    known[COL.HEAD], known[COL.CODE] = NONE, code


@bare_kernel
def _first_slot(code: Integer, mask: Integer) -> Integer:
    """Return where to start looking for a product state in a hash table of mask + 1 slots."""
    return np.int64((np.uint64(code) * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(20)) & mask


@bare_kernel
def rehash(states: States, rows: Integer) -> None:
    """Fill an emptied hash table with the first rows."""
    mask = states.slots.shape[0] - 1
    for row in range(rows):
        slot = _first_slot(states.known[row, COL.CODE], mask)
        while states.slots[slot] >= 0:
            slot = (slot + 1) & mask
        states.slots[slot] = row


@bare_kernel
def is_dominated(labels: Labels, label: Integer, cost: Integer, mu: Integer, cost_only: bool) -> bool:
    """Return whether some label of a product state is no worse than a new one."""
    while label != NONE:
        if labels.cost[label] <= cost and (cost_only or labels.mu[label] <= mu):
            return True
        label = labels.sibling[label]
    return False


@bare_kernel
def undominated(labels: Labels, label: Integer, cost: Integer, mu: Integer) -> Integer:
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


@bare_kernel
def next_successor(counters: np.ndarray) -> Integer:
    """Return the index of the next successor to be entered.

    Of equal labels the last made is expanded first; so the model's first action is entered last, to be preferred.
    """
    return counters[AT.COUNT] - 1 - counters[AT.NEXT]


@bare_kernel
def expand(space: Space, buffer: Successors, counters: np.ndarray, label: Integer, code: Integer) -> None:
    """Generate the successors of a label, to be entered next."""
    counters[AT.EXPANDED] += 1
    counters[AT.PARENT], counters[AT.NEXT] = label, 0
    counters[AT.COUNT] = successors(space, code, buffer)


@bare_kernel
def push(queue: Queue, counters: np.ndarray, label: Integer, estimate: Integer) -> None:
    """Insert a label into the open list."""
    counters[AT.OPEN] = heap_push(queue.keys, queue.items, counters[AT.OPEN], estimate, label)


@bare_kernel
def pop(queue: Queue, counters: np.ndarray) -> Integer:
    """Remove a label of the smallest estimate, write the estimate to LOWEST, and return the label."""
    counters[AT.LOWEST] = queue.keys[0]
    label = queue.items[0]
    counters[AT.OPEN] = heap_pop(queue.keys, queue.items, counters[AT.OPEN])
    return label
