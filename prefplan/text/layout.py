"""Numbers, plans and tables as plain text, and escapes for characters that are not printable."""

from __future__ import annotations

import shutil
import textwrap
from collections.abc import Sequence
from decimal import Decimal
from itertools import accumulate, groupby
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from prefplan.exact_costs import Number  # would load numpy

JOINERS = "\u200c\u200d"
"""Characters that keep letters apart or join them, as in Persian words and in emoji."""

COLUMN_GAP = "  "
"""Space between the columns of a table."""


def number(value: Number) -> str:
    """Return a cost as a short decimal that reads back as the same number."""
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < 2**53 else repr(value)
    return str(value) if abs(int(value)) < 10**21 else f"{Decimal(int(value)).normalize():g}"


def condense(actions: Sequence[str]) -> str:
    """Return a plan on one line; n equal actions in a row are written `n x ACTION`, those of one letter `nACTION`."""
    if _are_letters(actions):
        return " ".join(_moves(actions))
    return ", ".join(action if n == 1 else f"{n} x {action}" for action, n in _runs(actions))


def numbered(actions: Sequence[str], *, most: int | None = None, whole: str = "") -> str:
    """Return a plan in lines as wide as the terminal, or of 80 columns if there is none.

    Each action has its number; n equal actions in a row are one entry, and those of one letter are written `nACTION`
    without a number.

    Args:
        actions: (K,) in order.
        most: greatest number of entries to show; None for all.
        whole: how to see the rest, for the line that says how much was left out.
    """
    entries, runs, gap = _moves(actions), _runs(actions), " "
    if not _are_letters(actions):
        last = list(accumulate(n for _, n in runs))
        spans = [str(end) if n == 1 else f"{end - n + 1}-{end}" for end, (_, n) in zip(last, runs, strict=True)]
        entries, gap = [f"{span}. {action}" for span, (action, _) in zip(spans, runs, strict=True)], ", "
    # Lines are broken between entries only.
    text = gap.join(entry.replace(" ", "\0") for entry in entries[:most])
    columns = shutil.get_terminal_size().columns
    text = textwrap.fill(text, columns, break_long_words=False, break_on_hyphens=False).replace("\0", " ")
    if most is None or len(entries) <= most:
        return text
    left = sum(n for _, n in runs[most:])
    return f"{text}\n... and {counted(left, 'more action')}; {whole}"


def _runs(actions: Sequence[str]) -> list[tuple[str, int]]:
    """Return each action with how often it is repeated in a row."""
    return [(printable(action), len(list(run))) for action, run in groupby(actions)]


def _are_letters(actions: Sequence[str]) -> bool:
    """Return whether all actions are of one letter, like the moves on a grid."""
    return all(len(action) == 1 for action in actions)


def _moves(actions: Sequence[str]) -> list[str]:
    return [action if n == 1 else f"{n}{action}" for action, n in _runs(actions)]


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


def is_printable(text: str) -> bool:
    """Return whether all characters of a text can be shown; `JOINERS` are part of words and of emoji."""
    return text.isprintable() or all(one.isprintable() or one in JOINERS for one in text)


def printable(text: str, *, layout: str = "") -> str:
    r"""Return a text with an escape, such as `\x1b`, for each character that is neither printable nor in `layout`.

    Such characters could control a terminal, or reverse the text.
    """
    if text.isprintable():
        return text
    return "".join(one if is_printable(one) or one in layout else one.encode("unicode_escape").decode() for one in text)


def printable_lines(text: str) -> str:
    """Return a text as `printable` does, but keep its line breaks and tabs."""
    return printable(text, layout="\n\t")
