"""Fronts within p percent: what a plan that is known is good enough for, in whole numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from prefplan.errors import PrefplanError
from prefplan.exact_costs import Number, exact

NO_INFLATION = 2**60
"""Bounds of cost are smaller than this, so that a part in so many of them is nothing."""

FIRST_ROUND, ROUND_FACTOR = 100, 10
"""A front within few percent follows on fronts within more, at most the first many, each so many times the next."""


@dataclass(frozen=True)
class Percent:
    """How much worse a plan may be, in percent, than what it is good enough for."""

    value: Fraction

    def least(self, value: Any) -> Any:
        """Return the smallest value that another one exceeds by no more than this; the other one itself for 0 %."""
        return Fraction(value) / self.factor if self.value else value

    def least_cost(self, cost: int) -> int:
        """Return the smallest whole cost that another one exceeds by no more than this."""
        return math.ceil(cost / self.factor)

    @property
    def factor(self) -> Fraction:
        """How many times as large a value may be."""
        return 1 + self.value / 100

    @property
    def inflation(self) -> int:
        """The smallest whole number that one part in so many of anything is no more than this."""
        return math.ceil(100 / self.value) if self.value else NO_INFLATION

    @property
    def rounds(self) -> list[Percent]:
        """Larger ones, then this."""
        if not self.value:
            return [self]
        found = [self.value]
        while found[-1] * ROUND_FACTOR <= FIRST_ROUND:
            found.append(found[-1] * ROUND_FACTOR)
        return [Percent(value) for value in reversed(found)]


EXACT = Percent(Fraction(0))


def percent(value: Number) -> Percent:
    """Return a number of percent, which must not be negative."""
    number = Fraction(exact(value, "within"))
    if number < 0:
        raise PrefplanError(f"within: {value} is negative; it is a number of percent, 0 for the exact front")
    return Percent(number)
