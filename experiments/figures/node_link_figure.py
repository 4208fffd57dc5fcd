"""Node-link diagrams as figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyBboxPatch, Patch, PathPatch, Polygon
from matplotlib.path import Path as Curve

from experiments.figures.figures import drawing
from experiments.figures.node_link import LETTER, LINE, Diagram, corner_radius

PIXELS = 96.0
"""A browser's, and so a diagram's units, in an inch."""

POINTS = 72.0 / PIXELS
"""Size of a letter in points for its size in pixels."""

INK, BODY = "#222222", {"plain": "#ffffff", "accepting": "#d9efdc", "dead": "#f2f2f2"}

TITLE = 26.0
"""Height of a title."""

APART = 18.0
"""Between two diagrams."""


def draw(diagrams: dict[str, Diagram], path: Path) -> None:
    """Write diagrams one below the other, each with its title.

    Raises:
        PrefplanError: the file cannot be written.
    """
    width = max([len(title) * 0.6 * LETTER + 20 for title in diagrams] + [some.size[0] for some in diagrams.values()])
    height = sum(some.size[1] + TITLE for some in diagrams.values()) + APART * (len(diagrams) - 1)
    with drawing(path, size=(width / PIXELS, height / PIXELS)) as figure:
        figure.set_layout_engine("none")
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set_axis_off()
        axes.set_xlim(0, width)
        axes.set_ylim(height, 0)
        top = 0.0
        for title, diagram in diagrams.items():
            axes.text(8, top + 17, title, family="monospace", weight="bold", size=LETTER * POINTS, color=INK)
            _draw(axes, diagram, np.array([0, top + TITLE]))
            top += diagram.size[1] + TITLE + APART


def _draw(axes: Axes, diagram: Diagram, origin: np.ndarray) -> None:
    """Draw a diagram with its upper left corner at a point."""
    curve, head = diagram.start
    _arrow(axes, curve + origin, head + origin, "start")
    for arrow in diagram.arrows:
        name = "-".join(diagram.nodes[end].name for end in (arrow.edge.source, arrow.edge.target))
        _arrow(axes, arrow.curve + origin, arrow.head + origin, name)
        _text(axes, arrow.lines, arrow.at + origin)
    for node, middle, width, height in zip(
        diagram.nodes, diagram.middles + origin, diagram.widths, diagram.heights, strict=True
    ):
        dashed = (0, (4, 3)) if node.kind == "dead" else "-"
        _box(axes, middle, width, height, facecolor=BODY[node.kind], linestyle=dashed, gid=node.name)
        if node.kind == "accepting":
            _box(axes, middle, width - 7, height - 7, facecolor="none")
        _text(axes, node.text, middle + [0, LINE * (len(node.text) - 1) / 2 + 0.35 * LETTER])


def _arrow(axes: Axes, curve: np.ndarray, head: np.ndarray, name: str) -> None:
    path = Curve(curve, [Curve.MOVETO, *[Curve.CURVE4] * (len(curve) - 1)])
    axes.add_patch(PathPatch(path, facecolor="none", edgecolor=INK, linewidth=1.0, gid=name))
    axes.add_patch(Polygon(head, closed=True, facecolor=INK, linewidth=0))


def _box(axes: Axes, middle: np.ndarray, width: float, height: float, **look: Any) -> None:
    radius = corner_radius(height)
    shape: Patch
    if width == height == 2 * radius:
        shape = Circle(tuple(middle), radius)
    else:
        corner = middle - [width / 2, height / 2]
        shape = FancyBboxPatch(tuple(corner), width, height, boxstyle=f"round,pad=0,rounding_size={radius}")
    shape.set(edgecolor=INK, linewidth=1.0, **look)
    axes.add_patch(shape)


def _text(axes: Axes, lines: tuple[str, ...], base: np.ndarray) -> None:
    """Write lines of text, the last one standing on a point."""
    for i, line in enumerate(lines):
        y = base[1] - LINE * (len(lines) - 1 - i)
        axes.text(base[0], y, line, ha="center", family="monospace", size=LETTER * POINTS, color=INK)
