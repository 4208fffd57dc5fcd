"""Memory of a search: product states met, their hash table, labels, and the open list.

Everything grows by doubling between two runs of a kernel, so that memory can be limited and a search interrupted.
"""

from __future__ import annotations

from collections import namedtuple
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.pattern_database import LIKELY
from prefplan.models.kernels import Integer, bare_kernel
from prefplan.product.heap import heap_pop, heap_push
from prefplan.product.product_automaton import Product
from prefplan.product.space import Space, masks
from prefplan.product.successors import Successors, successors

NONE = -1
"""Stands for a row or a label that does not exist."""

PRODUCT_LIMIT = 2**61
"""Products of a cost and a weight stay below this."""

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


class Growth(NamedTuple):
    """How mu grows along a path.

    Attributes:
        rate: (2^N,) int64, units of mu for each unit of cost while that set of tasks is satisfied.
        maximum: (M, 2^N) int64, by satisfied set: mu is at least this times the cost so far.
        late: (D, 3) int64, the task, slope and offset of each tardiness max(0, slope * cost - offset), in units of mu.
        violation: (P,) int64, units of mu for each unit of violation cost.
        cost_limit: from this cost on a product with it might not fit 64 bits.
    """

    rate: np.ndarray
    maximum: np.ndarray
    late: np.ndarray
    violation: np.ndarray
    cost_limit: int


def growth_of(product: Product) -> Growth:
    """Return how mu grows along the paths of a product."""
    measure, units = product.problem.measure, product.units
    maximum = measure.maximum_table(units.factor)
    late = [
        (term.task, int(term.weight * units.factor), min(int(term.weight * term.by / units.mu), PRODUCT_LIMIT))
        for term in measure.tardiness
    ]
    prices = [int(weight * units.price / units.mu) for weight in measure.violation_weights]
    return Growth(
        rate=product.rates,
        maximum=maximum,
        late=np.array(late, dtype=np.int64).reshape(-1, 3),
        violation=np.array(prices, dtype=np.int64),
        cost_limit=PRODUCT_LIMIT // max(1, *(slope for _, slope, _ in late), int(maximum.max(initial=0))),
    )


class States(NamedTuple):
    """Product states met so far, one row each.

    Attributes:
        known: (R, F) int64, columns COST_BOUND, LOOKED, LIKELY and `COL`, and those of the search.
        slots: (H,) int32, open-addressing hash table of row numbers, -1 where empty; H is a power of two.
    """

    known: np.ndarray
    slots: np.ndarray


class Queue(NamedTuple):
    """The open list: a binary heap of labels by cost + bound; of equal ones the last made comes first.

    Attributes:
        keys: (L,) int64 and items: (L,) int64.
    """

    keys: np.ndarray
    items: np.ndarray


@bare_kernel
def added_mu(growth: Growth, satisfied: Integer, before: Integer, after: Integer) -> Integer:
    """Return what a step from cost `before` to `after` adds to mu, but for maxima, given the tasks satisfied before."""
    added = growth.rate[satisfied] * (after - before)
    for d in range(growth.late.shape[0]):
        if not satisfied >> growth.late[d, 0] & 1:
            slope, offset = growth.late[d, 1], growth.late[d, 2]
            added += max(0, slope * after - offset) - max(0, slope * before - offset)
    return added


@bare_kernel
def mu_after(
    growth: Growth, mu: Integer, satisfied: Integer, before: Integer, after: Integer, violation: np.ndarray, pays: bool
) -> Integer:
    """Return a label's mu after a step from cost `before` to `after` that pays violation costs (P,), if it pays any."""
    mu += added_mu(growth, satisfied, before, after)
    if pays:
        for i in range(growth.violation.shape[0]):
            mu += growth.violation[i] * violation[i]
    for m in range(growth.maximum.shape[0]):
        mu = max(mu, growth.maximum[m, satisfied] * after)
    return mu


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
