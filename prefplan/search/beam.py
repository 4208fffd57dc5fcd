"""Better plans with more work: beam search.

From layer to layer, only so many product states are followed, those of the least sum of the cost so far and an estimate
of what is left (B. Lowerre, "The Harpy speech recognition system", 1976). Whatever it finds is a plan; how far that is
from the best it does not tell.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.landmarks import landmark_bound
from prefplan.heuristics.pattern_database import added_bound
from prefplan.heuristics.preprocessing import Bounds, Prepared
from prefplan.limits import check_limits
from prefplan.product.contraction import NODE_LIMIT
from prefplan.product.kernels import Integer, kernel
from prefplan.product.moves import unpack
from prefplan.product.successors import INFINITE, ProductView, Successors, decode, masks, successors
from prefplan.search.driver import BiObjectiveSearch, Found, found_path

PORTION = 2**14
"""Successors that are worked out between two looks at the limits."""


class Beam(NamedTuple):
    """Product states of a layer.

    Attributes:
        code: (n,) int64. cost: (n,) int64, of getting there. origin: (n,) int64, place in the layer before.
        rank: (n,) int64, the cost so far and an estimate of what is left. done: (n,) bool, whether no task is left.
    """

    code: np.ndarray
    cost: np.ndarray
    origin: np.ndarray
    rank: np.ndarray
    done: np.ndarray

    def of(self, kept: np.ndarray) -> Beam:
        """Return some of them."""
        return Beam(*(column[kept] for column in self))


def beam_search(search: BiObjectiveSearch, width: int, most: float) -> Found | None:
    """Return the cheapest plan that a beam finds, or None.

    Args:
        search: begins where plans do; its added tables and its landmarks are the estimate.
        width: product states of a layer that are followed.
        most: bound of the plan's cost, in units; it must be less.

    Raises:
        LimitError: a limit was reached.
    """
    search.reset()
    prepared, starts = search.prepared, len(search.product.starts)
    nothing = np.zeros(starts, dtype=np.int64)
    now = Beam(search.buffer.code[:starts].copy(), nothing, np.arange(starts), nothing, nothing > 0)
    limit = INFINITE if most == math.inf else int(most) << search.product.shift
    passed, path = [now], list[tuple[int, int]]()
    # A plan that is worth its cost does not meet a product state twice; beams end much earlier.
    for _ in range(int(search.product.sizes.sum()) * min(prepared.view.nodes, NODE_LIMIT)):
        after = _expanded(prepared, now, search.buffer, limit)
        for goal in np.flatnonzero(after.done & (after.cost < limit)):
            if after.cost[goal] < limit:
                limit, path = int(after.cost[goal]), _path([*passed, after], int(goal))
        now = _narrowed(after.of(np.flatnonzero(~after.done & (after.cost < limit))), width)
        if not len(now.code):
            break
        passed.append(now)
    return found_path(search, path) if path else None


def _expanded(prepared: Prepared, now: Beam, buffer: Successors, limit: int) -> Beam:
    """Return the successors of a layer."""
    room = PORTION + len(buffer.code)
    first, found = 0, list[Beam]()
    while first < len(now.code):
        check_limits()
        code, cost, origin, rank = np.empty((4, room), dtype=np.int64)
        made = Beam(code, cost, origin, rank, np.empty(room, dtype=np.bool_))
        first, count = map(int, expand_layer(prepared.view, prepared.bounds, now, first, limit, buffer, made))
        found.append(made.of(np.arange(count)))
    return Beam(*map(np.concatenate, zip(*found, strict=True)))


def _narrowed(layer: Beam, width: int) -> Beam:
    """Return of each product state the cheapest, and of those so many of the least rank."""
    order = np.lexsort((layer.cost, layer.code))
    code = layer.code[order]
    layer = layer.of(order[np.concatenate([[True], code[1:] != code[:-1]])] if len(code) else order)
    return layer.of(np.argsort(layer.rank, kind="stable")[:width])


def _path(layers: list[Beam], at: int) -> list[tuple[int, int]]:
    """Return (code, cost) of the product states on the way to one of the last layer."""
    path = []
    for layer in reversed(layers):
        path.append((int(layer.code[at]), int(layer.cost[at])))
        at = int(layer.origin[at])
    return path[::-1]


@kernel
def expand_layer(
    view: ProductView, bounds: Bounds, layer: Beam, first: Integer, limit: Integer, buffer: Successors, made: Beam
) -> tuple[Integer, Integer]:
    """Write the successors of a layer's states from one on, as far as there is room.

    Returns:
        the first state whose successors are not written, and the number of those written.
    """
    count, digits = 0, buffer.digits.seen
    while first < layer.code.shape[0] and count + buffer.code.shape[0] <= made.code.shape[0]:
        for k in range(successors(view, layer.code[first], buffer)):
            cost = layer.cost[first] + buffer.cost[k]
            if cost >= limit:
                continue
            node = decode(view, buffer.code[k], buffer.choice)
            if view.generated:
                unpack(view.moves, node, digits)
            estimate = added_bound(bounds.added, bounds.projections, digits, node, buffer.choice)
            left = landmark_bound(bounds.landmarks, node, buffer.choice)
            if estimate >= INFINITE or cost + left >= limit:
                continue
            _, done = masks(view, buffer.choice)
            made.code[count], made.cost[count], made.origin[count] = buffer.code[k], cost, first
            made.rank[count], made.done[count] = cost + estimate + left, done == (1 << buffer.choice.shape[0]) - 1
            count += 1
        first += 1
    return first, count
