"""A binary heap of (key, item) in two arrays, for compiled kernels.

The smallest key comes first; of equal keys the item with the lexicographically least rank, if items have ranks, and
then the largest item.
"""

from typing import Any

import numpy as np

from prefplan.models.kernels import Integer, inner_kernel


@inner_kernel
def heap_push(
    keys: np.ndarray, items: np.ndarray, count: Integer, key: Integer, item: Integer, ranks: np.ndarray | None
) -> Integer:
    """Insert a pair and return the new count; the arrays must be longer than `count`, `ranks` is (L, n) by item."""
    at = count
    while at > 0:
        up = (at - 1) // 2
        if _precedes(keys[up], items[up], key, item, ranks):
            break
        keys[at] = keys[up]
        items[at] = items[up]
        at = up
    keys[at] = key
    items[at] = item
    return count + 1


@inner_kernel
def heap_pop(keys: np.ndarray, items: np.ndarray, count: Integer, ranks: np.ndarray | None) -> Integer:
    """Remove the first pair and return the new count; `ranks` as for `heap_push`."""
    count -= 1
    key, item = keys[count], items[count]
    at = 0
    while True:
        down = 2 * at + 1
        if down >= count:
            break
        if down + 1 < count and _precedes(keys[down + 1], items[down + 1], keys[down], items[down], ranks):
            down += 1
        if _precedes(key, item, keys[down], items[down], ranks):
            break
        keys[at] = keys[down]
        items[at] = items[down]
        at = down
    keys[at] = key
    items[at] = item
    return count


@inner_kernel
def _precedes(key: Any, item: Any, other_key: Any, other_item: Any, ranks: np.ndarray | None) -> bool:
    if ranks is not None and key == other_key:
        for e in range(ranks.shape[1]):
            if ranks[item, e] != ranks[other_item, e]:
                return bool(ranks[item, e] < ranks[other_item, e])
    return bool(key < other_key or (key == other_key and item >= other_item))
