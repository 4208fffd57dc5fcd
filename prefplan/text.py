"""Numbers, plans and tables as plain text."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from itertools import groupby

from prefplan.exact_costs import Number

COLUMN_GAP = "  "
"""Between the columns of a table."""


def number(value: Number) -> str:
    """Return a cost as a short decimal that reads back as the same number."""
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < 2**53 else repr(value)
    return str(value) if abs(int(value)) < 10**21 else f"{Decimal(int(value)).normalize():g}"


def condense(actions: Sequence[str]) -> str:
    """Return a plan on one line; n equal actions in a row are written `n x ACTION`, those of one letter `nACTION`."""
    runs = [(action, len(list(run))) for action, run in groupby(actions)]
    if all(len(action) == 1 for action in actions):
        return " ".join(action if n == 1 else f"{n}{action}" for action, n in runs)
    return ", ".join(action if n == 1 else f"{n} x {action}" for action, n in runs)


def listed(words: Sequence[str]) -> str:
    """Return words as `a, b and c`."""
    return "".join(words) if len(words) < 2 else f"{', '.join(words[:-1])} and {words[-1]}"


def in_columns(rows: Sequence[Sequence[str]]) -> str:
    """Return a table as lines with its columns aligned at the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(COLUMN_GAP.join(map(str.rjust, row, widths)) for row in rows)
