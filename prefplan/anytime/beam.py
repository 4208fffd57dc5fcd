"""Beam search: wider beams take longer and find better plans.

In each layer only the best product states are expanded, at most as many as the beam is wide: those with the least sum
of cost so far and estimated cost-to-go, to which weighted mu may be added (B. Lowerre, "The Harpy speech recognition
system", 1976). Every plan found is valid; beam search does not bound how far it is from optimal.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from prefplan.heuristics.landmarks import landmark_bound
from prefplan.heuristics.pattern_database import added_bound
from prefplan.heuristics.preference_bound import preference_bound
from prefplan.heuristics.preprocessing import Bounds
from prefplan.limits import check_limits
from prefplan.product.contraction import NODE_LIMIT
from prefplan.product.kernels import INFINITE, Integer, kernel
from prefplan.product.moves import unpack
from prefplan.product.product_view import ProductView, decode, masks
from prefplan.product.successors import Successors, successors
from prefplan.search.bi_objective_search import BiObjectiveSearch
from prefplan.search.driver import Found
from prefplan.search.labels import Growth, mu_after

PORTION = 2**14
"""Successors generated between two checks of the limits."""


class Beam(NamedTuple):
    """Product states of a layer.

    Attributes:
        code: (n,) int64. cost: (n,) int64, mu: (n,) int64, of the path there. origin: (n,) int64, index of the
            predecessor in the layer before.
        rank: (n,) float64, cost plus weighted mu, both so far and estimated ahead.
        done: (n,) bool, whether no task is left.
    """

    code: np.ndarray
    cost: np.ndarray
    mu: np.ndarray
    origin: np.ndarray
    rank: np.ndarray
    done: np.ndarray

    def of(self, kept: np.ndarray) -> Beam:
        """Return some of the product states, given by index or mask."""
        return Beam(*(column[kept] for column in self))


def beam_search(search: BiObjectiveSearch, width: int, most: float, weight: float = 0.0) -> Found | None:
    """Return the plan of the least weighted sum of cost and mu that a beam finds, or None.

    Args:
        search: made with `Prepared.for_beams`; only its start, bounds and buffers are used.
        width: most product states of a layer that are expanded.
        most: exclusive bound of the plan's cost, in units.
        weight: weight of a unit of mu, in units of cost.

    Raises:
        LimitError: a limit was reached.
    """
    search.reset()
    starts = len(search.product.starts)
    nothing = np.zeros(starts, dtype=np.int64)
    paid = search.buffer.violation[:starts] @ search.growth.violation
    now = Beam(search.buffer.code[:starts].copy(), nothing, paid, np.arange(starts), nothing * 0.0, nothing > 0)
    limit = INFINITE if most == math.inf else int(most) << search.product.shift
    passed, path, best = [now], list[tuple[int, int]](), math.inf
    # Where automata have cycles, the beam might go on forever; where they have none, it ends much earlier.
    for _ in range(int(search.product.sizes.sum()) * min(search.prepared.view.nodes, NODE_LIMIT)):
        after = _expanded(search, now, limit, weight)
        goals = np.flatnonzero(after.done & (after.rank < best))
        if len(goals):
            goal = int(goals[after.rank[goals].argmin()])
            best, path = after.rank[goal], _path([*passed, after], goal)
        now = _narrowed(after.of(np.flatnonzero(~after.done & (after.rank < best))), width)
        if not len(now.code):
            break
        passed.append(now)
    if not path:
        return None
    codes, costs = map(np.array, zip(*path, strict=True))
    return search.found_along(codes, costs)


def _expanded(search: BiObjectiveSearch, now: Beam, limit: int, weight: float) -> Beam:
    """Return the successors of a layer."""
    prepared, buffer = search.prepared, search.buffer
    capacity = PORTION + len(buffer.code)
    first, found = 0, list[Beam]()
    per_mu = weight * 2**search.product.shift
    while first < len(now.code):
        check_limits()
        code, cost, mu, origin = np.empty((4, capacity), dtype=np.int64)
        made = Beam(code, cost, mu, origin, np.empty(capacity), np.empty(capacity, dtype=np.bool_))
        args = prepared.view, prepared.bounds, search.growth, now, first, limit, per_mu, buffer, made
        first, count = map(int, expand_layer(*args))
        found.append(made.of(np.arange(count)))
    return Beam(*map(np.concatenate, zip(*found, strict=True)))


def _narrowed(layer: Beam, width: int) -> Beam:
    """Return the `width` product states of least rank, each with its path of least rank."""
    order = np.lexsort((layer.rank, layer.code))
    code = layer.code[order]
    layer = layer.of(order[np.concatenate([[True], code[1:] != code[:-1]])] if len(code) else order)
    return layer.of(np.argsort(layer.rank, kind="stable")[:width])


def _path(layers: list[Beam], at: int) -> list[tuple[int, int]]:
    """Return (code, cost) of the product states on the path to one of the last layer."""
    path = []
    for layer in reversed(layers):
        path.append((int(layer.code[at]), int(layer.cost[at])))
        at = int(layer.origin[at])
    return path[::-1]


@kernel
def expand_layer(
    view: ProductView,
    bounds: Bounds,
    growth: Growth,
    layer: Beam,
    first: Integer,
    limit: Integer,
    weight: float,
    buffer: Successors,
    made: Beam,
) -> tuple[Integer, Integer]:
    """Write the successors of a layer's states from number `first` on, as far as the buffer reaches.

    Returns:
        the first state whose successors are not written, and the number of those written.
    """
    count, digits = 0, buffer.digits.seen
    while first < layer.code.shape[0] and count + buffer.code.shape[0] <= made.code.shape[0]:
        before = layer.cost[first]
        for k in range(successors(view, layer.code[first], buffer)):
            after = before + buffer.cost[k]
            if after >= limit or after >> view.shift >= growth.cost_limit:
                continue
            satisfied, _ = masks(view, buffer.automata)
            spent = before >> view.shift
            mu = mu_after(
                growth, layer.mu[first], satisfied, spent, after >> view.shift, buffer.violation[k], view.pays
            )
            node = decode(view, buffer.code[k], buffer.choice)
            if view.generated:
                unpack(view.moves, node, digits)
            satisfied, done = masks(view, buffer.choice)
            estimate = added_bound(bounds.added, bounds.projections, digits, node, buffer.choice)
            left = landmark_bound(bounds.landmarks, node, buffer.choice)
            rising = preference_bound(bounds.blocks, bounds.projections, digits, node, buffer.choice, satisfied)
            if max(estimate, left, rising, mu) >= INFINITE or after + left >= limit:
                continue
            made.code[count], made.cost[count], made.mu[count], made.origin[count] = buffer.code[k], after, mu, first
            made.rank[count] = float(after + estimate + left) + weight * float(mu + rising)
            made.done[count] = done == (1 << buffer.choice.shape[0]) - 1
            count += 1
        first += 1
    return first, count
