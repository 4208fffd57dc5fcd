"""What the actions of a manipulation model cost: one number a kind, or measured between every two poses of the hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from prefplan.errors import ModelError, choices
from prefplan.exact_costs import Number, exact

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

    quantity: str = field(metadata={"key": "measured"})
    entries: Mapping[Pair, Number] = field(default_factory=dict, metadata={"key": None})


ActionCosts = Mapping[str, Number] | MeasuredCosts
"""A cost for each kind of action, or measured ones."""


def check_costs(costs: ActionCosts, kinds: Sequence[str]) -> None:
    """Check that each kind of action has a cost, and no other; of measured costs, that each is of one of the kinds.

    Raises:
        ModelError: they are not; the message starts with the key as in a scenario file.
    """
    if isinstance(costs, MeasuredCosts):
        if costs.quantity not in QUANTITIES:
            valid = choices(costs.quantity, QUANTITIES)
            raise ModelError(f"costs.measured: unknown quantity {costs.quantity!r} {valid}")
        for pair, cost in costs.entries.items():
            if pair[0] not in kinds:
                raise ModelError(f"costs.measured: unknown action {pair[0]!r} {choices(pair[0], kinds)}")
            if exact(cost, f"costs.measured: {_described(pair)}") < 0:
                raise ModelError(f"costs.measured: {_described(pair)}: negative cost {cost}")
        return
    for kind in costs:
        if kind not in kinds:
            raise ModelError(f"costs: unknown action {kind!r} {choices(kind, kinds)}")
    for kind in kinds:
        if kind not in costs:
            raise ModelError(f"costs: no cost for {kind!r}")
        if exact(costs[kind], f"costs.{kind}") < 0:
            raise ModelError(f"costs.{kind}: negative cost {costs[kind]}")


def _described(pair: Pair) -> str:
    kind, before, after = pair
    return f"{kind} at {after!r}" if before == after else f"{kind} from {before!r} to {after!r}"
