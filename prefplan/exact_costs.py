"""Exact costs: every number is a rational, and costs are whole multiples of a common unit.

| number given                   | its exact value                                                                 |
| ------------------------------ | ------------------------------------------------------------------------------- |
| int, Fraction, Decimal         | itself; numbers of a scenario file are decimals                                 |
| float of whole value           | that integer                                                                    |
| float, at most 15 digits       | the decimal that a person would write: 0.1 is one tenth                         |
| float with more digits         | the nearest decimal of 15 significant digits: 0.1 + 0.2 is 0.3                  |

Floats of more than 12 digits, which were probably computed, are rounded to a *resolution* if sums of the model's costs
would not fit 64 bits (`in_units`); the front is exact for the rounded costs.
"""

import math
import numbers
from collections.abc import Iterable, Sequence
from decimal import Decimal
from fractions import Fraction

import numpy as np

from prefplan.errors import ModelError
from prefplan.limits import clocked

Number = int | float | Decimal | Fraction

FLOAT_DIGITS = 15
"""Significant digits of a decimal that are never lost when it is stored as a double."""

RESOLVED_DIGITS = 12
"""Digits of the largest cost as a multiple of the resolution: a thousand such costs add up to less than 2^53."""

LARGEST_EXPONENT = 400
"""Largest absolute exponent of ten of a number; positive doubles lie between 4.9e-324 and 1.8e308."""

INT64_LIMIT = 2**62
"""Whole numbers below this are held as int64, larger ones as Python's integers."""


def exact(value: Number, where: str = "") -> Fraction:
    """Return the exact value of a number, which may be one of numpy; `where` is its key, for messages.

    Raises:
        ModelError: it is not a number, not finite, beyond 1e400, or not 0 but below 1e-400.
    """
    if isinstance(value, Fraction):
        return value
    prefix = f"{where}: " if where else ""
    # The usual types come first: the test for an abstract class is slow.
    if isinstance(value, bool) or not isinstance(value, (float, int, Decimal, numbers.Real)):
        raise ModelError(f"{prefix}must be a number, not {value!r}")
    if not isinstance(value, (float, Decimal)) and isinstance(value, (int, numbers.Integral)):
        if abs(int(value)).bit_length() > LARGEST_EXPONENT * math.log2(10):
            raise ModelError(f"{prefix}must lie between -1e{LARGEST_EXPONENT} and 1e{LARGEST_EXPONENT}")
        return Fraction(int(value))
    # The text of a 32-bit numpy float has only the digits that this type can hold.
    number = value if isinstance(value, Decimal) else Decimal(str(value))
    if not number.is_finite():
        raise ModelError(f"{prefix}must be a finite number, not {value}")
    if not number:
        return Fraction(0)
    digits = len(number.as_tuple().digits)
    if abs(number.adjusted()) > LARGEST_EXPONENT or digits > LARGEST_EXPONENT:
        raise ModelError(
            f"{prefix}must be 0 or lie between 1e-{LARGEST_EXPONENT} and 1e{LARGEST_EXPONENT}, "
            f"with at most {LARGEST_EXPONENT} digits, not {number:.3e}"
        )
    if not isinstance(value, Decimal):
        if float(value).is_integer():
            return Fraction(int(value))
        if digits > FLOAT_DIGITS:
            number = Decimal(f"{float(value):.{FLOAT_DIGITS}g}")
    return Fraction(*number.as_integer_ratio())


def to_number(value: Fraction | float) -> int | float:
    """Return an exact value as it is printed: an int if it is whole or beyond all floats, else the nearest float."""
    if isinstance(value, Fraction) and (value.denominator == 1 or abs(value) >= 2**1023):
        return round(value)
    return float(value)


def inclusive(bound: Number, where: str = "") -> Fraction:
    """Return the largest rational that an inclusive bound admits.

    Results are printed as the nearest floats, so a bound that is a float or decimal admits all exact values that round
    to it. Whole results are printed exactly, so a bound that is written without a point or exponent is exact.

    Raises:
        ModelError: as in `exact`.
    """
    limit = exact(bound, where)
    written_whole = isinstance(bound, Decimal) and bound.as_tuple().exponent == 0
    if written_whole or isinstance(bound, (numbers.Integral, Fraction)) or abs(limit) >= 2**1022:
        return limit
    nearest = float(bound)
    halfway = (Fraction(nearest) + Fraction(math.nextafter(nearest, math.inf))) / 2
    if float(halfway) > nearest:
        # A tie is rounded to the even neighbour, here the next float; any smaller value is rounded to `nearest`.
        halfway -= abs(halfway) / 2**200
    return halfway


def prints_as(value: Number, printed: Number) -> bool:
    """Return whether a printed number is equal to a value, or is the float that `to_number` returns for it."""
    return exact(value) == exact(printed) or (isinstance(printed, float) and to_number(exact(value)) == printed)


def common_unit(values: Iterable[Fraction]) -> Fraction:
    """Return the largest rational of which all values are whole multiples; 1 if all are zero."""
    values = list(values)
    numerator = math.gcd(*(value.numerator for value in values))
    return Fraction(numerator, math.lcm(*(value.denominator for value in values))) if numerator else Fraction(1)


def whole_numbers(counts: list[int]) -> np.ndarray:
    """Return integers as an array: int64 if all fit, else Python's integers."""
    fits = max(map(abs, counts), default=0) < INT64_LIMIT
    return np.array(counts, dtype=np.int64 if fits else object)


def in_common_unit(values: Iterable[Fraction]) -> tuple[np.ndarray, Fraction]:
    """Return values as whole multiples of their common unit, and that unit."""
    values = list(values)
    unit = common_unit(set(map(clocked, values)))
    per, of = unit.denominator, unit.numerator
    return whole_numbers([value.numerator * (per // value.denominator) // of for value in map(clocked, values)]), unit


def in_units(costs: Sequence[Number]) -> tuple[np.ndarray, Fraction, Fraction | None]:
    """Return (E,) costs >= 0 as multiples of a unit, the unit, and the resolution (None if nothing was rounded).

    Floats of more than 12 digits are rounded to 12 digits of the largest cost if sums would not fit 64 bits.
    """
    values = {cost: exact(cost) for cost in map(clocked, dict.fromkeys(costs))}
    floats = [cost for cost in values if isinstance(cost, (float, np.floating))]
    rounded = [cost for cost in map(clocked, floats) if type(cost)(f"{cost:.{RESOLVED_DIGITS}g}") != cost]
    largest, resolution = max(values.values(), default=Fraction(0)), None
    if rounded and largest / common_unit(values.values()) >= 10**FLOAT_DIGITS:
        magnitude = (Decimal(largest.numerator) / Decimal(largest.denominator)).adjusted()
        resolution = Fraction(10) ** (magnitude + 1 - RESOLVED_DIGITS)
        values |= {cost: round(values[cost] / resolution) * resolution for cost in map(clocked, rounded)}
    multiples, unit = in_common_unit(values.values())
    counts = dict(zip(values, multiples.tolist(), strict=True))
    return np.array([counts[cost] for cost in costs], dtype=multiples.dtype), unit, resolution
