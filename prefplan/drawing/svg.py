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
"""Colour of a plan's own way or progress."""

AREAS = ("#9ecae1", "#fdd0a2", "#a8dba8", "#d4c5e8", "#f7b6c2", "#e6df9c", "#a9dfdb", "#d9c4a9")
"""Pale colours of areas and kinds of actions, used in turn."""


def picture(width: float, height: float, parts: Iterable[str]) -> str:
    """Return an SVG of a size in px."""
    size = f'width="{width:g}" height="{height:g}" viewBox="0 0 {width:g} {height:g}"'
    font = f'font-family="system-ui, DejaVu Sans, sans-serif" font-size="{FONT_PX}"'
    ground = rectangle(0, 0, width, height, fill=PAPER)
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} {font}>{ground}{"".join(parts)}</svg>'


def rectangle(x: float, y: float, width: float, height: float, *, title: str = "", **style: object) -> str:
    """Return a rectangle by its upper left corner and size, px; a title is shown when it is pointed at."""
    place = f'x="{x:.2f}" y="{y:.2f}" width="{width:.2f}" height="{height:.2f}"'
    inside = f"<title>{escape(title)}</title>" if title else ""
    return f"<rect {place}{_attributes(style)}>{inside}</rect>"


def line(points: Iterable[tuple[float, float]], **style: object) -> str:
    """Return a line through points, px."""
    return f'<polyline points="{" ".join(f"{x:.2f},{y:.2f}" for x, y in points)}" fill="none"{_attributes(style)}/>'


def area(points: Iterable[tuple[float, float]], **style: object) -> str:
    """Return a polygon, px."""
    return f'<polygon points="{" ".join(f"{x:.2f},{y:.2f}" for x, y in points)}"{_attributes(style)}/>'


def dot(x: float, y: float, radius: float, **style: object) -> str:
    """Return a circle, px."""
    return f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{radius:.2f}"{_attributes(style)}/>'


def text(x: float, y: float, words: str, *, turned: bool = False, halo: bool = False, **style: object) -> str:
    """Return text that begins at a point of its base line, px; turned, it runs upwards; a halo sets it off a map."""
    turn = f' transform="rotate(-90 {x:.2f} {y:.2f})"' if turned else ""
    around = f' stroke="{PAPER}" stroke-width="3" paint-order="stroke"' if halo else ""
    style = {"fill": INK, **style}
    return f'<text x="{x:.2f}" y="{y:.2f}"{turn}{around}{_attributes(style)}>{escape(words)}</text>'


def shortened(words: str, width: float) -> str:
    """Return text that is not wider than a number of px, with an ellipsis where it is cut."""
    letters = max(1, int(width / LETTER_PX))
    return words if len(words) <= letters else words[: letters - 1] + "…"


def _attributes(style: dict[str, object]) -> str:
    return "".join(f' {name.replace("_", "-")}="{escape(str(value))}"' for name, value in style.items())
