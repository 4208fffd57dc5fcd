"""A binary heap of (key, item) in two arrays, for compiled kernels."""

from __future__ import annotations

import numpy as np

from prefplan.product.successors import Integer, bare_kernel


@bare_kernel
def heap_push(keys: np.ndarray, items: np.ndarray, count: Integer, key: Integer, item: Integer) -> Integer:
    """Insert a pair and return the new count; the arrays must have room."""
    at = count
    while at > 0:
        up = (at - 1) // 2
        if keys[up] <= key:
            break
        keys[at] = keys[up]
        items[at] = items[up]
        at = up
    keys[at] = key
    items[at] = item
    return count + 1


@bare_kernel
def heap_pop(keys: np.ndarray, items: np.ndarray, count: Integer) -> Integer:
    """Remove the pair of the smallest key, which stands first, and return the new count."""
    count -= 1
    key, item = keys[count], items[count]
    at = 0
    while True:
        down = 2 * at + 1
        if down >= count:
            break
        if down + 1 < count and keys[down + 1] < keys[down]:
            down += 1
        if keys[down] >= key:
            break
        keys[at] = keys[down]
        items[at] = items[down]
        at = down
    keys[at] = key
    items[at] = item
    return count
