"""Matrices of the cost of every kind of action between every two poses of the hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product

import numpy as np

from prefplan.errors import ModelError
from prefplan.exact_costs import exact, in_common_unit
from prefplan.models.manipulation.action_costs import UNMEASURED, MeasuredCosts, cost_names
from prefplan.models.manipulation.description import Description
from prefplan.models.manipulation.slots import location_of
from prefplan.models.several_costs import amount


@dataclass(frozen=True)
class CostMatrix:
    """One cost of K kinds of actions between H poses of the hand.

    Attributes:
        name: name of the cost.
        entries: (K, H, H) by kind, hand before and hand after, in multiples of `unit`; `UNMEASURED` where unknown.
        unit: unit of `entries`, in the user's units.
    """

    name: str
    entries: np.ndarray
    unit: Fraction

    @property
    def shared_unit(self) -> Fraction:
        """The largest unit of which every cost is a multiple, in the user's units."""
        known = self.entries[self.entries != UNMEASURED]
        return self.unit * (int(np.gcd.reduce(known, axis=None, initial=0)) or 1)

    def between(self, hands: Sequence[int]) -> CostMatrix:
        """Return the costs between some of the poses of the hand."""
        return replace(self, entries=self.entries[:, hands][:, :, hands])


def cost_matrices(model: Description, kinds: Sequence[str], hands: Sequence[str]) -> tuple[CostMatrix, ...]:
    """Return every cost of every kind of action between every two poses of the hand, the first cost first.

    A pose without measurements, such as one over an object that fell, takes those of the nearest measured pose; one
    over no location takes those of the start pose.

    Args:
        model: the model, with its costs and locations.
        kinds: the K kinds of actions.
        hands: names of the H poses.
    """
    return tuple(_cost_matrix(model, kinds, hands, name) for name in cost_names(model.costs))


def _cost_matrix(model: Description, kinds: Sequence[str], hands: Sequence[str], name: str) -> CostMatrix:
    costs = model.costs
    if not isinstance(costs, MeasuredCosts):
        values, unit = in_common_unit([exact(amount(costs[kind], name)) for kind in kinds])
        return CostMatrix(name, np.broadcast_to(values[:, None, None], (len(kinds), len(hands), len(hands))), unit)
    values, unit = in_common_unit([exact(amount(cost, name)) for cost in costs.entries.values()])
    entries = dict(zip(costs.entries, values.tolist(), strict=True))
    measured = sorted({hand for pair in entries for hand in pair[1:]})
    nearest = {hand: _nearest(model, hand, measured) for hand in hands}
    matrix = np.full((len(kinds), len(hands), len(hands)), UNMEASURED, dtype=values.dtype)
    for (k, kind), (i, before), (j, after) in product(enumerate(kinds), enumerate(hands), enumerate(hands)):
        options = [
            (far + near, entries[kind, a, b])
            for (a, far), (b, near) in product(nearest[before].items(), nearest[after].items())
            if (kind, a, b) in entries
        ]
        if options:
            matrix[k, i, j] = min(options)[1]
    return CostMatrix(name, matrix, unit)


def unmeasured(action: str, before: str) -> ModelError:
    """Return the error of an action, such as `transit left`, whose cost was not measured from a pose of the hand."""
    return ModelError(
        f"costs.measured: {action!r} with the hand at {before!r} was not measured; `prefplan measure` measures it"
    )


def _nearest(model: Description, hand: str, measured: Sequence[str]) -> dict[str, float]:
    """Return the measured poses that may replace a pose, each with its distance from it, m."""
    if hand in measured or not measured:
        return {hand: 0.0}
    here = _point(model, hand)
    if here is None:
        return {other: float(other != model.start) for other in measured}
    points = {other: _point(model, other) for other in measured}
    return {other: math.dist(here, point) for other, point in points.items() if point is not None}


def _point(model: Description, name: str) -> tuple[float, float] | None:
    """Return the (x, y) of a pose's location, m: for one on others their middle; None if its position is not known."""
    place = next((place for place in model.locations if place.name == location_of(name)), None)
    if place is None or place.at is not None:
        return None if place is None or place.at is None else (place.at[0], place.at[1])
    below = [point for point in (_point(model, support) for support in place.on) if point is not None]
    return (sum(x for x, _ in below) / len(below), sum(y for _, y in below) / len(below)) if below else None
