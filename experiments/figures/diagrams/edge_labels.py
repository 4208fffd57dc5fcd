"""Labels of edges, broken into lines; one with too many lines becomes a number, and a note below the diagram."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

WIDEST, WIDEST_LOOP = 36, 9
"""Greatest number of letters in a line of a label: of an edge, and of a self-loop, beside which edges leave."""

MOST_LINES = 6
"""Greatest number of lines of a label beside its edge."""


def edge_labels(labels: Iterable[tuple[str, bool]]) -> tuple[list[tuple[str, ...]], list[str]]:
    """Return labels, given with whether their edge is a self-loop, as lines, and the notes, one per long label."""
    notes: dict[str, str] = {}
    found = []
    for label, loop in labels:
        lines = _lines(label, WIDEST_LOOP if loop else WIDEST)
        if len(lines) > MOST_LINES:
            lines = (notes.setdefault(label, f"({len(notes) + 1})"),)
        found.append(lines)
    return found, [f"{number} {label}" for label, number in notes.items()]


def wrapped(note: str, letters: int) -> list[str]:
    """Return the lines of a note, broken before `|` and `&`."""
    bound = note.replace(" | ", " |\N{NO-BREAK SPACE}").replace(" & ", " &\N{NO-BREAK SPACE}")
    lines = textwrap.wrap(bound, letters, subsequent_indent=4 * "\N{NO-BREAK SPACE}", break_long_words=False)
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in lines]


def _lines(label: str, widest: int) -> tuple[str, ...]:
    """Return the lines of a label: one, or if that is too long one per term of a sum, broken before `&` if need be."""
    lines: list[str] = []
    for term in [label] if len(label) <= widest else label.replace(" | ", "\n| ").split("\n"):
        lines.append("")
        for word in [term] if len(term) <= widest else term.replace(" & ", "\n& ").split("\n"):
            if lines[-1] and len(lines[-1]) + 1 + len(word) > widest:
                lines.append("")
            lines[-1] = f"{lines[-1]} {word}".strip()
    return tuple(lines)
