"""Costs of actions: a number, or a table of named costs, with the same names for all actions."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from prefplan.errors import ModelError
from prefplan.exact_costs import Number, exact, whole_numbers
from prefplan.text.names import check_names

DEFAULT_COST = "cost"
"""Name of a cost that is given as a number."""

Cost = Number | Mapping[str, Number]
"""The cost of an action: a number, whose name is then `cost`, or several costs by name."""

UNMEASURED = -1
"""Entry of a cost table for an action whose cost was not measured: the action does not exist."""


@dataclass(frozen=True)
class CostTable:
    """One of the costs of a system's actions.

    Attributes:
        name: name of the cost.
        entries: costs >= 0 in whole multiples of `unit`, or `UNMEASURED`: int64, or Python's integers if one does not
            fit; (E,) by edge where states are listed, else (K, H, H) by kind of action and by the hand's poses before
            and after it.
        unit: unit of `entries`, in the user's units.
    """

    name: str
    entries: np.ndarray
    unit: Fraction

    @property
    def greatest(self) -> Fraction:
        """The greatest cost, in the user's units; 0 if there are none."""
        return self.unit * int(max(self.entries.ravel().tolist(), default=0))

    def counts(self, unit: Fraction) -> np.ndarray:
        """Return the flattened entries in a unit that divides `self.unit`: int64 if all fit, else Python's integers."""
        ratio, entries = int(self.unit / unit), self.entries.ravel()
        return entries if ratio == 1 else whole_numbers([cost * ratio for cost in entries.tolist()])


def by_name(cost: Cost) -> Mapping[str, Number]:
    """Return the costs of an action by name."""
    return cost if isinstance(cost, Mapping) else {DEFAULT_COST: cost}


def check_costs_agree(costs: Iterable[tuple[str, Cost]]) -> None:
    """Check all costs of a model, each given with its key.

    Raises:
        ModelError: a cost is negative, has no names, or other names than the first; the message begins with the key.
    """
    first: tuple[str, Cost] | None = None
    checked = set[Number]()
    for where, cost in costs:
        if isinstance(cost, int | float) and cost in checked:
            continue
        named = by_name(cost)
        if first is None:
            if not named:
                raise ModelError(f"{where}: names no cost")
            check_names(named, where=where)
            first = where, cost
        if named.keys() != by_name(first[1]).keys():
            gives = f"{where}: gives {_text_of(cost)}, but {first[0]} gives {_text_of(first[1])}"
            raise ModelError(f"{gives}; every cost has the same names")
        for name, value in named.items():
            at = f"{where}.{name}" if isinstance(cost, Mapping) else where
            if exact(value, at) < 0:
                raise ModelError(f"{at}: negative cost {value}")
        if isinstance(cost, int | float):
            checked.add(cost)


def _text_of(cost: Cost) -> str:
    if isinstance(cost, Mapping):
        return f"the costs {', '.join(cost)}" if cost else "no cost"
    return "a number (the cost 'cost')"
