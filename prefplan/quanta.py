"""Exact costs: numbers as integers, in quanta of a common power of ten."""

from __future__ import annotations

import numbers
from collections.abc import Iterable
from decimal import Decimal
from fractions import Fraction

from prefplan.errors import ModelError

Number = int | float | Decimal

LIMIT = 2**62
"""Costs of this many quanta or more are refused: sums of them could overflow an int64."""


def exact(value: Number, where: str = "") -> Decimal:
    """Return a number as the decimal a person would write for it (0.1 is one tenth).

    Args:
        value: an int, float or Decimal, or numpy's kinds of these.
        where: key for the error message.

    Raises:
        ModelError: if it is not a finite number.
    """
    prefix = f"{where}: " if where else ""
    if isinstance(value, bool) or not isinstance(value, (numbers.Real, Decimal)):
        raise ModelError(f"{prefix}must be a number, not {value!r}")
    if isinstance(value, (Decimal, numbers.Integral)):
        number = Decimal(value if isinstance(value, Decimal) else int(value))
    else:
        number = Decimal(repr(float(value)))
    if not number.is_finite():
        raise ModelError(f"{prefix}must be a finite number, not {value}")
    return number


def decimals_of(values: Iterable[Number]) -> int:
    """Return how many decimal places are needed to write every value exactly."""
    return max((max(0, -int(exact(v).normalize().as_tuple().exponent)) for v in values), default=0)


def to_quanta(values: Iterable[Number], decimals: int | None = None) -> tuple[list[int], int]:
    """Return values as integers in quanta of 10**-decimals, and decimals.

    Args:
        values: finite numbers.
        decimals: exponent of the quantum; the smallest exact one unless given.

    Raises:
        ModelError: if a value is not finite or too large to be held exactly.
    """
    values = list(values)
    if decimals is None:
        decimals = decimals_of(values)
    scaled = [int(exact(v).scaleb(decimals)) for v in values]
    for value, quanta in zip(values, scaled, strict=True):
        if abs(quanta) >= LIMIT:
            raise ModelError(f"{value} with {decimals} decimal places is too large to be held exactly")
    return scaled, decimals


def fraction_decimals(value: Fraction) -> int:
    """Return how many decimal places write a fraction exactly; it must have finitely many."""
    places = 0
    while value.denominator != 1:
        value *= 10
        places += 1
    return places


def to_number(value: Fraction | float) -> int | float:
    """Return an exact value as a person would write it: an int where it is whole, else the nearest float."""
    if isinstance(value, Fraction) and value.denominator == 1:
        return int(value)
    return float(value)


def from_quanta(quanta: int | float, decimals: int) -> int | float:
    """Return quanta in the user's units: an int where it is whole, else the nearest float."""
    if isinstance(quanta, float) and not quanta.is_integer():
        return quanta / 10**decimals
    whole, rest = divmod(int(quanta), 10**decimals)
    return whole if rest == 0 else float(Decimal(int(quanta)).scaleb(-decimals))
