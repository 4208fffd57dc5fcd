"""Costs of actions: one for each kind, or measured between every two poses of the hand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from prefplan.errors import ModelError, check_known, choices
from prefplan.exact_costs import exact, in_common_unit
from prefplan.models.costs import DEFAULT_COST, UNMEASURED, Cost, CostTable, by_name, check_costs_agree
from prefplan.models.manipulation.slots import location_of

if TYPE_CHECKING:
    from prefplan.models.manipulation.model import ManipulationModel

QUANTITIES = {"time": "s", "travel": "rad", "energy": "J"}
"""Quantities that can be measured, with their units."""

Pair = tuple[str, str, str]
"""An action's kind, and the hand's poses before and after it: a location, one of its slots, or the start pose."""


@dataclass(frozen=True)
class MeasuredCosts:
    """Costs of actions by the hand's poses before and after them.

    Attributes:
        measured: one of `QUANTITIES`, or several, each a separate cost.
        entries: the cost, in the quantity's unit, of each (kind, hand before, hand after) that was measured. Between
            other poses there is no action of this kind.
        failed: why other actions could not be measured.
    """

    measured: str | tuple[str, ...]
    entries: Mapping[Pair, Cost] = field(default_factory=dict, metadata={"key": None})
    failed: Mapping[Pair, str] = field(default_factory=dict, metadata={"key": None})

    @property
    def quantities(self) -> tuple[str, ...]:
        """The measured quantities, in the order of the costs."""
        return (self.measured,) if isinstance(self.measured, str) else self.measured

    @property
    def note(self) -> str:
        """The actions left out because they could not be measured, as one line; empty if there are none."""
        if not self.failed:
            return ""
        (pair, reason), *others = self.failed.items()
        more = f"; {len(others)} more" if others else ""
        return f"Not measured, and left out: {_described(pair)} ({reason}){more}."

    @property
    def quantity(self) -> str:
        """The quantity that is the first cost."""
        return self.quantities[0]


ActionCosts = Mapping[str, Cost] | MeasuredCosts
"""A cost for each kind of action, or measured ones."""


def cost_names(costs: ActionCosts) -> tuple[str, ...]:
    """Return the names of costs that `check_costs` accepts, in order."""
    if isinstance(costs, MeasuredCosts):
        return (DEFAULT_COST,) if isinstance(costs.measured, str) else costs.measured
    return tuple(by_name(next(iter(costs.values())))) if costs else (DEFAULT_COST,)


def check_costs(costs: ActionCosts, kinds: Sequence[str]) -> None:
    """Check that exactly these kinds of actions have costs; of measured costs, that each is of one of these kinds.

    Raises:
        ModelError: a check fails, or a cost is invalid; the message starts with the key as in a scenario file.
    """
    if isinstance(costs, MeasuredCosts):
        if not costs.quantities:
            raise ModelError(f"costs.measured: names no quantity {choices('', QUANTITIES)}")
        for quantity in costs.quantities:
            check_known("costs.measured", "quantity", quantity, QUANTITIES)
            if costs.quantities.count(quantity) > 1:
                raise ModelError(f"costs.measured: {quantity!r} is listed twice")
        for pair in costs.entries:
            check_known("costs.measured", "action", pair[0], kinds)
        check_costs_agree((f"costs.measured: {_described(pair)}", cost) for pair, cost in costs.entries.items())
        return
    for kind in costs:
        check_known("costs", "action", kind, kinds)
    for kind in kinds:
        if kind not in costs:
            raise ModelError(f"costs: no cost for {kind!r}")
    check_costs_agree((f"costs.{kind}", costs[kind]) for kind in kinds)


def _described(pair: Pair) -> str:
    kind, before, after = pair
    return f"{kind} at {after!r}" if before == after else f"{kind} from {before!r} to {after!r}"


def cost_tables(model: ManipulationModel, hands: Sequence[str]) -> tuple[CostTable, ...]:
    """Return every cost of the K kinds of actions between every two of the H poses of the hand, the first cost first.

    A pose that was not measured, such as one over an object that fell, takes the costs of the nearest measured pose;
    one over no location takes those of the start pose.
    """
    if isinstance(model.costs, MeasuredCosts):
        given, chosen = list(model.costs.entries.values()), _nearest_entries(model, model.costs, hands)
    else:
        given = [model.costs[kind] for kind in model.kinds]
        chosen = np.broadcast_to(np.arange(len(given))[:, None, None], (len(given), len(hands), len(hands)))
    tables = []
    for name in model.cost_names:
        values, unit = in_common_unit([exact(by_name(cost)[name]) for cost in given])
        # Where no entry is chosen, the index -1 takes the last value.
        tables.append(CostTable(name, np.append(values, UNMEASURED)[chosen], unit))
    return tuple(tables)


def _nearest_entries(model: ManipulationModel, costs: MeasuredCosts, hands: Sequence[str]) -> np.ndarray:
    """Return (K, H, H) the number of the measured entry for each kind and two poses, or -1."""
    number = {pair: n for n, pair in enumerate(costs.entries)}
    measured = sorted({hand for pair in (*costs.entries, *costs.failed) for hand in pair[1:]})
    nearest = {hand: _nearest(model, hand, measured) for hand in hands}
    chosen = np.full((len(model.kinds), len(hands), len(hands)), -1)
    for (k, kind), (i, before), (j, after) in product(enumerate(model.kinds), enumerate(hands), enumerate(hands)):
        options = [
            (far + near, number[kind, a, b])
            for (a, far), (b, near) in product(nearest[before].items(), nearest[after].items())
            if (kind, a, b) in number
        ]
        if options:
            chosen[k, i, j] = min(options)[1]
    return chosen


def _nearest(model: ManipulationModel, hand: str, measured: Sequence[str]) -> dict[str, float]:
    """Return the measured poses that may replace a pose, each with its distance from it, m."""
    if hand in measured or not measured:
        return {hand: 0.0}
    here = _point(model, hand)
    if here is None:
        return {other: float(other != model.start) for other in measured}
    points = {other: _point(model, other) for other in measured}
    return {other: math.dist(here, point) for other, point in points.items() if point is not None}


def _point(model: ManipulationModel, name: str) -> tuple[float, float] | None:
    """Return the (x, y) of a pose's location, m: the middle of its supports, if it is on any; None if not known."""
    place = next((place for place in model.locations if place.name == location_of(name)), None)
    if place is None or place.at is not None:
        return None if place is None or place.at is None else (place.at[0], place.at[1])
    below = [point for point in (_point(model, support) for support in place.on) if point is not None]
    return (sum(x for x, _ in below) / len(below), sum(y for _, y in below) / len(below)) if below else None
