"""The map from a model's states to the nodes of its projections (`abstraction`)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from prefplan.models.kernels import Integer, bare_kernel
from prefplan.models.manipulation.successors import unpack


class Projections(NamedTuple):
    """M projections of a model of S slots, H poses of the hand, O objects and D digits.

    Attributes:
        weights: (M, D) int64, weight of each digit in a projection's states, 0 if it is not seen, negative for marks.
        slots: (M, S + 1) int64, location in the projection, -1 for merged ones.
        hands: (M, H) int64, pose in the projection, -1 over merged locations.
        places: (M, n) int64, the locations of the projection that stand for merged ones.
        above: (S + 1,) int64, pose of the hand over each slot.
        radices: (D,) int64, number of values of each digit, and seen: (D,) int64, scratch: digits of a state.
        first: (M,) int64, numbers: (X,) int32: numbers[first[m] + state] is the node of a projection's state.
    """

    weights: np.ndarray
    slots: np.ndarray
    hands: np.ndarray
    places: np.ndarray
    above: np.ndarray
    radices: np.ndarray
    seen: np.ndarray
    first: np.ndarray
    numbers: np.ndarray


@bare_kernel
def observe(projections: Projections | None, node: Integer) -> None:
    """Write the digits of a state whose bounds are looked up; nothing to do where states are listed."""
    if projections is not None:
        unpack(projections.radices, node, projections.seen)


@bare_kernel
def place_of(projections: Projections | None, projection: Any, p: Integer, node: Integer) -> Integer:
    """Return the node that table p has for the observed state: that of its projection; the state's, if there is none.

    Args:
        projections: of the model, None where states are listed.
        projection: (P,) the projection of each table, None where states are listed.
        p: number of the table.
        node: the state.
    """
    if projections is None:
        return node
    return _projected(projections, projection[p], projections.seen)


@bare_kernel
def _projected(projections: Projections, m: Integer, digits: np.ndarray) -> Integer:
    """Return the node of a projection for the digits of a state."""
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
