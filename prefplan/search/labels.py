"""Memory of a search: product states met, their hash table, labels, and the open list.

Everything grows by doubling between two runs of a kernel, so that memory can be limited and a search interrupted.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.heuristics.pattern_database import BOUND_COLUMNS
from prefplan.product.heap import heap_pop, heap_push
from prefplan.product.successors import Integer, bare_kernel

NONE = -1

# Places in the counters of a search.
ROWS, LABELS, FREE, OPEN, LOWEST, EXPANDED, GENERATED, FOUND, PARENT, NEXT, COUNT = range(11)
COUNTERS = 11

# Columns of a product state's row, after those of its bound: satisfied tasks as bits (the sign bit is set where no
# others remain), the bound of mu's growth, and the first of its labels.
SATISFIED, GROWTH_BOUND, HEAD = range(BOUND_COLUMNS, BOUND_COLUMNS + 3)
COLUMNS = BOUND_COLUMNS + 3


class States(NamedTuple):
    """Product states met so far, one row each.

    Attributes:
        code: (R,) int64.
        known: (R, F) int64, what is known of each, side by side.
        slots: (H,) int32, open-addressing hash table of row numbers, -1 where empty; H is a power of two.
    """

    code: np.ndarray
    known: np.ndarray
    slots: np.ndarray


class Queue(NamedTuple):
    """The open list: a binary heap of labels by cost + bound, of equal ones the last made first.

    Attributes:
        keys: (L,) int64 and items: (L,) int64.
    """

    keys: np.ndarray
    items: np.ndarray


@bare_kernel
def first_slot(code: Integer, mask: Integer) -> Integer:
    """Return where to start looking for a product state in a hash table of mask + 1 slots."""
    return np.int64((np.uint64(code) * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(20)) & mask


@bare_kernel
def rehash(states: States, rows: Integer) -> None:
    """Fill an emptied hash table with the first rows."""
    mask = states.slots.shape[0] - 1
    for row in range(rows):
        slot = first_slot(states.code[row], mask)
        while states.slots[slot] >= 0:
            slot = (slot + 1) & mask
        states.slots[slot] = row


@bare_kernel
def push(queue: Queue, counters: np.ndarray, label: Integer, estimate: Integer) -> None:
    """Insert a label."""
    counters[OPEN] = heap_push(queue.keys, queue.items, counters[OPEN], estimate, label)


@bare_kernel
def pop(queue: Queue, counters: np.ndarray) -> Integer:
    """Remove a label of the smallest estimate, write that to the counters, and return the label."""
    counters[LOWEST] = queue.keys[0]
    label = queue.items[0]
    counters[OPEN] = heap_pop(queue.keys, queue.items, counters[OPEN])
    return label
