"""The open list of `ltmoa_star`: a binary heap of labels by their bounds in lexicographic order.

The key of a label in the heap is the bound of its first objective in the order of comparison; the others are compared
only if the first ones are equal.
"""

from __future__ import annotations

import numpy as np

from prefplan.models.kernels import Integer, bare_kernel
from prefplan.search.labels import AT, Queue, States
from prefplan.search.multi_objective.entries import BOUND, Entries, KeyedLabels


@bare_kernel
def _precedes(
    shift: Integer, entries: Entries, states: States, labels: KeyedLabels, label: Integer, other: Integer
) -> bool:
    """Return whether a label precedes another with the same first bound.

    It does by the other bounds, then by the number of actions, which the low bits of the first cost count, and then if
    it is the later one.
    """
    row, other_row = labels.row[label], labels.row[other]
    for o in range(1, entries.order.shape[0]):
        e = entries.order[o]
        here = labels.key[label, e] + states.known[row, BOUND + e]
        there = labels.key[other, e] + states.known[other_row, BOUND + e]
        if e == 0:
            here, there = here >> shift, there >> shift
        if here != there:
            return bool(here < there)
    here = labels.key[label, 0] + states.known[row, BOUND]
    there = labels.key[other, 0] + states.known[other_row, BOUND]
    return bool(here < there or (here == there and label > other))


@bare_kernel
def lexicographic_push(
    shift: Integer,
    queue: Queue,
    counters: np.ndarray,
    states: States,
    entries: Entries,
    labels: KeyedLabels,
    bound: Integer,
    label: Integer,
) -> None:
    """Insert a label into the open list."""
    at = counters[AT.OPEN]
    while at > 0:
        up = (at - 1) // 2
        if queue.keys[up] < bound or (
            queue.keys[up] == bound and _precedes(shift, entries, states, labels, queue.items[up], label)
        ):
            break
        queue.keys[at], queue.items[at] = queue.keys[up], queue.items[up]
        at = up
    queue.keys[at], queue.items[at] = bound, label
    counters[AT.OPEN] += 1


@bare_kernel
def lexicographic_pop(
    shift: Integer, queue: Queue, counters: np.ndarray, states: States, entries: Entries, labels: KeyedLabels
) -> None:
    """Remove the first label from the open list."""
    counters[AT.OPEN] -= 1
    count = counters[AT.OPEN]
    bound, label = queue.keys[count], queue.items[count]
    at = 0
    while True:
        down = 2 * at + 1
        if down >= count:
            break
        if down + 1 < count:
            right, left = queue.keys[down + 1], queue.keys[down]
            if right < left or (
                right == left and _precedes(shift, entries, states, labels, queue.items[down + 1], queue.items[down])
            ):
                down += 1
        if bound < queue.keys[down] or (
            bound == queue.keys[down] and _precedes(shift, entries, states, labels, label, queue.items[down])
        ):
            break
        queue.keys[at], queue.items[at] = queue.keys[down], queue.items[down]
        at = down
    queue.keys[at], queue.items[at] = bound, label
