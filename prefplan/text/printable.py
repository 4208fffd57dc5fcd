"""Foreign text as it is printed: characters that would act on a terminal, or turn the text around, are escaped."""

from __future__ import annotations


def printable(text: str, *, layout: str = "") -> str:
    r"""Return a text in which each character that is not printable, but for some, is its escape, such as `\x1b`."""
    if text.isprintable():
        return text
    return "".join(one if one.isprintable() or one in layout else one.encode("unicode_escape").decode() for one in text)


def printable_lines(text: str) -> str:
    """Return a text of several lines, as `printable`, but with its line breaks and tabs."""
    return printable(text, layout="\n\t")
