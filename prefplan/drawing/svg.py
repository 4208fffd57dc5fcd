"""The elements of an SVG file as text."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

FONT_PX = 12
"""Height of text, px."""

LETTER_PX = 6.8
"""Mean width of a letter of that height, px."""

INK, SOFT, PAPER = "#1c2430", "#566170", "#ffffff"
"""Colours of text, of what matters less, and of the ground, which is there so that text can be read on any page."""

PATH = "#0072b2"
"""Colour of a plan's own path or progress."""

AREAS = ("#9ecae1", "#fdd0a2", "#a8dba8", "#d4c5e8", "#f7b6c2", "#e6df9c", "#a9dfdb", "#d9c4a9")
"""Pale colours of areas and kinds of actions, used in turn."""


def picture(width: float, height: float, title: str, parts: Iterable[str]) -> str:
    """Return an SVG of a size in px, with a title in its upper left corner."""
    ground = element("rect", width=width, height=height, fill=PAPER)
    return element(
        "svg",
        *(ground, text(4, 17, title, font_weight="bold"), *parts),
        xmlns="http://www.w3.org/2000/svg",
        width=width,
        height=height,
        font_family="system-ui, DejaVu Sans, sans-serif",
        font_size=FONT_PX,
    )


def element(tag: str, *inside: str, **attributes: object) -> str:
    """Return an element with other elements or escaped text inside; `_` in a name of an attribute stands for `-`."""
    given = (f' {name.replace("_", "-")}="{_value(value)}"' for name, value in attributes.items())
    return f"<{tag}{''.join(given)}>{''.join(inside)}</{tag}>"


def text(x: float, y: float, words: str, **attributes: object) -> str:
    """Return text that begins at a point of its base line, px, with a pale edge that sets it off a map."""
    edge = {"stroke": PAPER, "stroke_width": 3, "paint_order": "stroke"}
    return element("text", escape(words), x=x, y=y, **{"fill": INK, **edge, **attributes})


def shortened(words: str, width: float) -> str:
    """Return text that is not wider than a number of px, with an ellipsis where it is cut."""
    letters = int(width / LETTER_PX)
    return words if len(words) <= letters else f"{words[: letters - 1]}…"


def points(corners: Iterable[Iterable[float]]) -> str:
    """Return points as an attribute of a line, px."""
    return " ".join(",".join(f"{value:.2f}" for value in corner) for corner in corners)


def _value(value: object) -> str:
    return f"{value:.2f}" if isinstance(value, float) else escape(str(value))
