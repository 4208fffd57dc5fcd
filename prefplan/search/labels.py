"""Memory of a search: product states met, their hash table, labels, and the open list.

Everything grows by doubling between two runs of a kernel, so that memory can be limited and a search interrupted.
"""

from __future__ import annotations

from collections import namedtuple
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.pattern_database import COST_BOUND, LIKELY, LOOKED, added_bound, raise_bound
from prefplan.heuristics.preference_bound import preference_bound
from prefplan.heuristics.preprocessing import Bounds
from prefplan.models.manipulation.successors import unpack
from prefplan.product.heap import heap_pop, heap_push
from prefplan.product.kernels import Integer, bare_kernel
from prefplan.product.product_automaton import Product
from prefplan.product.product_view import ProductView, decode, masks
from prefplan.product.successors import Successors, successors

NONE, PRUNED = -1, -2
"""Stand for a row or a label that does not exist, and for a product state that was pruned."""

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
        late_task: (D,) int64, late_slope: (D,) int64 units of mu for each unit of cost, late_offset: (D,) int64 units
            of mu: tardiness is max(0, slope * cost - offset).
        violation: (P,) int64, units of mu for each unit of violation cost.
        cost_limit: from this cost on a product with it might not fit 64 bits.
    """

    rate: np.ndarray
    maximum: np.ndarray
    late_task: np.ndarray
    late_slope: np.ndarray
    late_offset: np.ndarray
    violation: np.ndarray
    cost_limit: int


def growth_of(product: Product) -> Growth:
    """Return how mu grows along the paths of a product."""
    measure, units = product.problem.measure, product.units
    late, maximum = measure.tardiness, measure.maximum_table(units.factor)
    slopes = [int(term.weight * units.factor) for term in late]
    offsets = [min(int(term.weight * term.by / units.mu), PRODUCT_LIMIT) for term in late]
    prices = [int(weight * units.price / units.mu) for weight in measure.violation_weights]
    return Growth(
        rate=product.rates,
        maximum=maximum,
        late_task=np.array([term.task for term in late], dtype=np.int64),
        late_slope=np.array(slopes, dtype=np.int64),
        late_offset=np.array(offsets, dtype=np.int64),
        violation=np.array(prices, dtype=np.int64),
        cost_limit=PRODUCT_LIMIT // max(1, *slopes, int(maximum.max(initial=0))),
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


class Memory(NamedTuple):
    """The arrays that the kernels of all searches work on.

    Attributes:
        product: what is searched.
        growth: how mu grows.
        bounds: heuristics.
        states: product states met.
        queue: the open list.
        counters: int64, by index `AT`, and those of the search.
        limits: int64, bounds that labels must keep; see the kernel of each search.
        begin: (K, E) int64, by start, the entries of its label's key; see `Search._begin`.
        buffer: successors, and scratch.
    """

    product: ProductView
    growth: Growth
    bounds: Bounds
    states: States
    queue: Queue
    counters: np.ndarray
    limits: np.ndarray
    begin: np.ndarray
    buffer: Successors


@bare_kernel
def added_mu(growth: Growth, satisfied: Integer, before: Integer, after: Integer) -> Integer:
    """Return what a step from cost `before` to `after` adds to mu, but for maxima, given the tasks satisfied before."""
    added = growth.rate[satisfied] * (after - before)
    for d in range(growth.late_task.shape[0]):
        if not satisfied >> growth.late_task[d] & 1:
            slope, offset = growth.late_slope[d], growth.late_offset[d]
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
def enter_state(
    memory: Memory,
    code: Integer,
    likely: Integer,
    growth_limit: Integer,
    cost_limit: Integer,
    lookup_limit: Integer,
) -> Integer:
    """Return the row of a product state, a new one where it was not met before.

    Args:
        memory: of the search.
        code: the product state.
        likely: number of the table to look up first.
        growth_limit: exclusive limit of mu's growth to the end.
        cost_limit: inclusive limit of the cost-to-go.
        lookup_limit: tables are looked up only until the bound of the cost-to-go exceeds this.

    Returns:
        the row, NONE if no row is free, or PRUNED if the state is new and exceeds a limit.
    """
    view, bounds, states, buffer = memory.product, memory.bounds, memory.states, memory.buffer
    mask = states.slots.shape[0] - 1
    slot = _first_slot(code, mask)
    row = np.int64(states.slots[slot])
    while row >= 0 and states.known[row, COL.CODE] != code:
        slot = (slot + 1) & mask
        row = np.int64(states.slots[slot])
    if row >= 0:
        return row
    node = decode(view, code, buffer.choice)
    satisfied, done = masks(view, buffer.choice)
    digits = buffer.digits.seen
    if view.generated:
        unpack(view.moves, node, digits)
    growing = preference_bound(bounds.blocks, bounds.projections, digits, node, buffer.choice, satisfied)
    if growing >= growth_limit:
        return PRUNED
    row = memory.counters[AT.ROWS]
    if row == states.known.shape[0]:
        return NONE
    known = states.known[row]
    known[COL.SATISFIED] = satisfied | (GOAL_BIT if done == (1 << buffer.choice.shape[0]) - 1 else 0)
    known[LOOKED], known[LIKELY] = 0, likely
    known[COST_BOUND] = added_bound(bounds.added, bounds.projections, digits, node, buffer.choice)
    known[COL.GROWTH_BOUND] = growing
    known[COL.HEAD], known[COL.CODE] = NONE, code
    most = min(cost_limit, lookup_limit)
    if raise_bound(bounds.patterns, bounds.landmarks, node, buffer.choice, known, most) > cost_limit:
        return PRUNED
    memory.counters[AT.ROWS] += 1
    states.slots[slot] = row
    return row


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
def expand(memory: Memory, label: Integer, row: Integer) -> None:
    """Generate the successors of a label, to be entered next."""
    counters = memory.counters
    counters[AT.EXPANDED] += 1
    counters[AT.PARENT], counters[AT.NEXT] = label, 0
    counters[AT.COUNT] = successors(memory.product, memory.states.known[row, COL.CODE], memory.buffer)


@bare_kernel
def push(memory: Memory, label: Integer, estimate: Integer) -> None:
    """Insert a label into the open list."""
    queue, counters = memory.queue, memory.counters
    counters[AT.OPEN] = heap_push(queue.keys, queue.items, counters[AT.OPEN], estimate, label)


@bare_kernel
def pop(memory: Memory) -> Integer:
    """Remove a label of the smallest estimate, write the estimate to LOWEST, and return the label."""
    queue, counters = memory.queue, memory.counters
    counters[AT.LOWEST] = queue.keys[0]
    label = queue.items[0]
    counters[AT.OPEN] = heap_pop(queue.keys, queue.items, counters[AT.OPEN])
    return label
