"""What the actions of a manipulation model cost: one number a kind, or measured between every two poses of the hand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from prefplan.errors import ModelError, choices
from prefplan.exact_costs import Number, exact, in_common_unit
from prefplan.models.slots import location_of

if TYPE_CHECKING:
    from prefplan.models.manipulation import ManipulationModel

ACTION_KINDS = ("transit", "grasp", "transport", "release")

QUANTITIES = {"time": "s", "travel": "rad", "energy": "J"}
"""What can be measured of an action, with its unit."""

Pair = tuple[str, str, str]
"""An action's kind, and the hand's pose before and after it: a location, one of its slots, or the start pose."""

UNMEASURED = -1
"""Stands for the cost of an action that was not measured."""


@dataclass(frozen=True)
class MeasuredCosts:
    """Costs of actions by where the hand is before and after them.

    Attributes:
        quantity: one of `QUANTITIES`.
        entries: the cost of each (kind, hand before, hand after) that was measured.
    """

    quantity: str
    entries: Mapping[Pair, Number] = field(default_factory=dict)


ActionCosts = Mapping[str, Number] | MeasuredCosts
"""A cost for each of `ACTION_KINDS`, or measured ones."""


def check_costs(costs: ActionCosts) -> None:
    """Check that costs are costs, and the actions known ones.

    Raises:
        ModelError: they are not; the message starts with the key as in a scenario file.
    """
    if isinstance(costs, MeasuredCosts):
        if costs.quantity not in QUANTITIES:
            valid = choices(costs.quantity, QUANTITIES)
            raise ModelError(f"costs.measured: unknown quantity {costs.quantity!r} {valid}")
        for pair, cost in costs.entries.items():
            if pair[0] not in ACTION_KINDS:
                raise ModelError(f"costs.measured: unknown action {pair[0]!r} {choices(pair[0], ACTION_KINDS)}")
            if exact(cost, f"costs.measured: {_described(pair)}") < 0:
                raise ModelError(f"costs.measured: {_described(pair)}: negative cost {cost}")
        return
    for kind in costs:
        if kind not in ACTION_KINDS:
            raise ModelError(f"costs: unknown action {kind!r} {choices(kind, ACTION_KINDS)}")
    for kind in ACTION_KINDS:
        if kind not in costs:
            raise ModelError(f"costs: no cost for {kind!r}")
        if exact(costs[kind], f"costs.{kind}") < 0:
            raise ModelError(f"costs.{kind}: negative cost {costs[kind]}")


def cost_matrix(model: ManipulationModel, hands: Sequence[str]) -> tuple[np.ndarray, Fraction]:
    """Return the cost of every kind of action between every two poses of the hand.

    A pose that was never measured, such as that of an object that fell, costs what the nearest measured one does; one
    that is over no location is as good as the start pose.

    Args:
        model: its costs and locations.
        hands: names of the H poses.

    Returns:
        (4, H, H) by kind, hand before and hand after, multiples of a unit, `UNMEASURED` where unknown; and that unit.
    """
    costs = model.costs
    if not isinstance(costs, MeasuredCosts):
        kinds, unit = in_common_unit([exact(costs[kind]) for kind in ACTION_KINDS])
        return np.broadcast_to(kinds[:, None, None], (4, len(hands), len(hands))), unit
    values, unit = in_common_unit([exact(cost) for cost in costs.entries.values()])
    entries = dict(zip(costs.entries, values.tolist(), strict=True))
    measured = sorted({hand for pair in entries for hand in pair[1:]})
    nearest = {hand: _nearest(model, hand, measured) for hand in hands}
    matrix = np.full((len(ACTION_KINDS), len(hands), len(hands)), UNMEASURED, dtype=values.dtype)
    for (k, kind), (i, before), (j, after) in product(enumerate(ACTION_KINDS), enumerate(hands), enumerate(hands)):
        options = [
            (far + near, entries[kind, a, b])
            for (a, far), (b, near) in product(nearest[before].items(), nearest[after].items())
            if (kind, a, b) in entries
        ]
        if options:
            matrix[k, i, j] = min(options)[1]
    return matrix, unit


def unmeasured(action: str, before: str) -> ModelError:
    """Return the error of an action that has no measured cost.

    Args:
        action: as in plans, e.g. `transit left`.
        before: the hand's pose before it.
    """
    return ModelError(
        f"costs.measured: {action!r} with the hand at {before!r} was not measured; `prefplan measure` measures it"
    )


def _nearest(model: ManipulationModel, hand: str, measured: Sequence[str]) -> dict[str, float]:
    """Return the measured poses that may stand in for one, each with its distance in m."""
    if hand in measured or not measured:
        return {hand: 0.0}
    here = _point(model, hand)
    if here is None:
        return {other: float(other != model.start) for other in measured}
    points = {other: _point(model, other) for other in measured}
    return {other: math.dist(here, point) for other, point in points.items() if point is not None}


def _point(model: ManipulationModel, name: str) -> tuple[float, float] | None:
    """Return the (x, y) of a pose's location in m, of one on others their middle; None if there is no such location."""
    place = next((place for place in model.locations if place.name == location_of(name)), None)
    if place is None or place.at is not None:
        return None if place is None else place.at
    below = [point for point in (_point(model, support) for support in place.on) if point is not None]
    return (sum(x for x, _ in below) / len(below), sum(y for _, y in below) / len(below)) if below else None


def _described(pair: Pair) -> str:
    kind, before, after = pair
    return f"{kind} at {after!r}" if before == after else f"{kind} from {before!r} to {after!r}"
