"""Costs of actions: one for each kind, or measured between every two poses of the hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from prefplan.errors import ModelError, check_known, choices
from prefplan.models.several_costs import Cost, check_costs_agree, names_of
from prefplan.models.transition_system import DEFAULT_COST

QUANTITIES = {"time": "s", "travel": "rad", "energy": "J"}
"""Quantities that can be measured, with their units."""

Pair = tuple[str, str, str]
"""An action's kind, and the hand's poses before and after it: a location, one of its slots, or the start pose."""

UNMEASURED = -1
"""Entry of a cost matrix for an action that was not measured."""


@dataclass(frozen=True)
class MeasuredCosts:
    """Costs of actions by the hand's poses before and after them.

    Attributes:
        measured: one of `QUANTITIES`, or several, each a separate cost.
        entries: the cost, in the quantity's unit, of each (kind, hand before, hand after) that was measured.
    """

    measured: str | tuple[str, ...]
    entries: Mapping[Pair, Cost] = field(default_factory=dict, metadata={"key": None})

    @property
    def quantities(self) -> tuple[str, ...]:
        """The measured quantities, in the order of the costs."""
        return (self.measured,) if isinstance(self.measured, str) else self.measured

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
    return names_of(next(iter(costs.values()))) if costs else (DEFAULT_COST,)


def check_costs(costs: ActionCosts, kinds: Sequence[str]) -> None:
    """Check that exactly these kinds of actions have costs; of measured costs, that each is of one of these kinds.

    Raises:
        ModelError: that is not so, or a cost is invalid; the message starts with the key as in a scenario file.
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
