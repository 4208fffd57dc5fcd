"""Numbers, plans and tables as plain text."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from decimal import Decimal
from itertools import accumulate, groupby
from typing import TYPE_CHECKING

from prefplan.text.printable import printable

if TYPE_CHECKING:
    from prefplan.exact_costs import Number  # would load numpy

COLUMN_GAP = "  "
"""Between the columns of a table."""


def number(value: Number) -> str:
    """Return a cost as a short decimal that reads back as the same number."""
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < 2**53 else repr(value)
    return str(value) if abs(int(value)) < 10**21 else f"{Decimal(int(value)).normalize():g}"


def condense(actions: Sequence[str]) -> str:
    """Return a plan on one line; n equal actions in a row are written `n x ACTION`, those of one letter `nACTION`."""
    runs = _runs(actions)
    if _are_letters(actions):
        return " ".join(_moves(runs))
    return ", ".join(action if n == 1 else f"{n} x {action}" for action, n in runs)


def numbered(actions: Sequence[str], *, most: int | None = None, whole: str = "") -> str:
    """Return a plan in lines as wide as the terminal, or of 80 columns if there is none.

    Each action has its number; n equal actions in a row are one entry, and those of one letter are written `nACTION`
    without a number.

    Args:
        actions: (K,) in order.
        most: greatest number of entries to show; None for all.
        whole: how to see the rest, for the line that says how much was left out.
    """
    runs, columns = _runs(actions), shutil.get_terminal_size().columns
    if _are_letters(actions):
        entries, gap = _moves(runs), ""
    else:
        last = list(accumulate(n for _, n in runs))
        spans = [str(end) if n == 1 else f"{end - n + 1}-{end}" for end, (_, n) in zip(last, runs, strict=True)]
        entries, gap = [f"{span}. {action}" for span, (action, _) in zip(spans, runs, strict=True)], ","
    if most is None or len(entries) <= most:
        return "\n".join(_wrapped(entries, gap, columns))
    left = sum(n for _, n in runs[most:])
    rest = f"... and {counted(left, 'more action')}; {whole}"
    return "\n".join([*_wrapped(entries[:most], gap, columns), rest])


def _runs(actions: Sequence[str]) -> list[tuple[str, int]]:
    """Return each action with how often it is repeated in a row."""
    return [(printable(action), len(list(run))) for action, run in groupby(actions)]


def _are_letters(actions: Sequence[str]) -> bool:
    """Return whether all actions are of one letter, like the moves on a grid."""
    return all(len(action) == 1 for action in actions)


def _moves(runs: Sequence[tuple[str, int]]) -> list[str]:
    return [action if n == 1 else f"{n}{action}" for action, n in runs]


def _wrapped(entries: Sequence[str], gap: str, columns: int) -> list[str]:
    """Return entries with a gap after all but the last, in lines that are broken only between entries."""
    lines: list[str] = []
    for i, entry in enumerate(entries):
        piece = entry + gap * (i < len(entries) - 1)
        if lines and len(lines[-1]) + 1 + len(piece) <= columns:
            lines[-1] += f" {piece}"
        else:
            lines.append(piece)
    return lines


def counted(number: int, noun: str) -> str:
    """Return a number of things, such as `1 plan` or `2 plans`."""
    return f"{number} {noun}{'s' * (number != 1)}"


def listed(words: Sequence[str]) -> str:
    """Return words as `a, b and c`."""
    return "".join(words) if len(words) < 2 else f"{', '.join(words[:-1])} and {words[-1]}"


def in_columns(rows: Sequence[Sequence[str]]) -> str:
    """Return a table as lines with its columns aligned at the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(COLUMN_GAP.join(map(str.rjust, row, widths)) for row in rows)
