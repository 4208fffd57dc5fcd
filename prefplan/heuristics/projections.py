"""The map from a model's states to the nodes of its projections (`abstraction`)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from prefplan.product.kernels import Integer, bare_kernel


class Projections(NamedTuple):
    """M projections of a model of S slots, H poses of the hand, O objects and D digits.

    Attributes:
        weights: (M, D) int64, weight of each digit in a projection's states, 0 if it is not seen, negative for marks.
        slots: (M, S + 1) int64, location in the projection, -1 for merged ones.
        hands: (M, H) int64, pose in the projection, -1 over merged locations.
        places: (M, n) int64, the locations of the projection that stand for merged ones.
        above: (S + 1,) int64, pose of the hand over each slot.
        first: (M,) int64, numbers: (X,) int32: numbers[first[m] + state] is the node of a projection's state.
    """

    weights: np.ndarray
    slots: np.ndarray
    hands: np.ndarray
    places: np.ndarray
    above: np.ndarray
    first: np.ndarray
    numbers: np.ndarray


def no_projections() -> Projections:
    """Return what stands in the place of projections where states are listed."""
    grid, none = np.zeros((0, 0), dtype=np.int64), np.zeros(0, dtype=np.int64)
    return Projections(grid, grid, grid, grid, none, none, none.astype(np.int32))


@bare_kernel
def projected(projections: Projections, m: Integer, digits: np.ndarray, node: Integer) -> Integer:
    """Return the node of a projection for the digits of a state; the node itself if there are no projections."""
    if projections.first.shape[0] == 0:
        return node
    hand, held = digits[0], projections.slots.shape[1] - 1
    state, moved, rank = np.int64(0), projections.hands[m, hand], 0
    for d in range(1, digits.shape[0]):
        weight = projections.weights[m, d]
        if weight == 0:
            continue
        value = digits[d]
        if weight < 0:
            # A mark: it has no location.
            state -= weight * value
            continue
        slot = projections.slots[m, value]
        if slot < 0:
            slot = projections.places[m, rank]
            rank += 1
            if value < held and projections.above[value] == hand:
                moved = slot
        state += weight * slot
    if moved < 0:
        moved = projections.places[m, rank]
    return np.int64(projections.numbers[projections.first[m] + state + moved])
