"""Foreign text as it is printed: characters that would act on a terminal, or turn the text around, are escaped."""

from __future__ import annotations

CONTROLS = [*range(0x20), *range(0x7F, 0xA0)]
"""C0, delete and C1: they move the cursor, colour the text, set the window's title."""

BIDI = [0x61C, 0x200E, 0x200F, *range(0x202A, 0x202F), *range(0x2066, 0x206A)]
"""Marks, embeddings, overrides and isolates that reorder what is shown."""

BREAKS = [0x2028, 0x2029]
"""Separators of lines and paragraphs."""

_ESCAPES = {code: chr(code).encode("unicode_escape").decode() for code in (*CONTROLS, *BIDI, *BREAKS)}

_ESCAPES_BUT_LAYOUT = {code: text for code, text in _ESCAPES.items() if chr(code) not in "\n\t"}


def printable(text: str) -> str:
    r"""Return a text on one line, in which each control character is its escape, such as `\x1b` or `\n`."""
    return text.translate(_ESCAPES)


def printable_lines(text: str) -> str:
    """Return a text of several lines, as `printable`, but with its line breaks and tabs."""
    return text.translate(_ESCAPES_BUT_LAYOUT)
