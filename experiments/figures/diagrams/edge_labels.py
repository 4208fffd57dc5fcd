"""Labels of edges in lines; one that needs too many is a number on its edge, and a note below the diagram."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

WIDEST, WIDEST_LOOP = 36, 9
"""Most letters in a line of a label that can be broken: of an edge, of a self-loop (edges leave the node beside it)."""

MOST_LINES = 6
"""Most lines of a label beside its edge."""


def edge_labels(labels: Iterable[tuple[str, bool]]) -> tuple[list[tuple[str, ...]], list[str]]:
    """Return labels, each with whether its edge is a loop, in lines, and the notes; equal labels share a note."""
    notes: dict[str, str] = {}
    found = []
    for label, loop in labels:
        lines = _lines(label, WIDEST_LOOP if loop else WIDEST)
        if len(lines) > MOST_LINES:
            lines = (notes.setdefault(label, f"({len(notes) + 1})"),)
        found.append(lines)
    return found, [f"{number} {label}" for label, number in notes.items()]


def wrapped(note: str, letters: int) -> list[str]:
    """Return a note in lines, broken before `|` and `&`."""
    bound = note.replace(" | ", " |\N{NO-BREAK SPACE}").replace(" & ", " &\N{NO-BREAK SPACE}")
    lines = textwrap.wrap(bound, letters, subsequent_indent=4 * "\N{NO-BREAK SPACE}", break_long_words=False)
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in lines]


def _lines(label: str, widest: int) -> tuple[str, ...]:
    """Return a label in lines, one for each term of a sum if it is too long for one, broken before `&` if need be."""
    lines: list[str] = []
    for term in [label] if len(label) <= widest else label.replace(" | ", "\n| ").split("\n"):
        lines.append("")
        for word in [term] if len(term) <= widest else term.replace(" & ", "\n& ").split("\n"):
            if lines[-1] and len(lines[-1]) + 1 + len(word) > widest:
                lines.append("")
            lines[-1] = f"{lines[-1]} {word}".strip()
    return tuple(lines)
