"""Node-link diagrams: nodes, and arrows with labels. Lengths are in points; y points downwards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import BoxStyle, Ellipse, FancyArrowPatch, FancyBboxPatch
from matplotlib.path import Path as Path2D

from experiments.figures.diagrams.curves import LOOP_PT, RADIUS_PT, curve_between, loop_above
from experiments.figures.diagrams.edge_labels import edge_labels, wrapped
from experiments.figures.diagrams.layered import Box, place
from experiments.figures.figures import POINTS_PER_INCH, drawing, inline_svg, write_figure

LETTER_PT = 13.0
"""Font size."""

ADVANCE_PT = 0.602 * LETTER_PT
"""Width of a letter of the monospaced font, so that the width of a label is known, points."""

LINE_PT = 1.25 * LETTER_PT
"""Distance between two lines of text."""

SPACING = 1.3
"""The same in matplotlib's unit, the height from the top of a line to its baseline."""

INK = "#222222"

FILL = {"plain": "#ffffff", "accepting": "#d9efdc", "dead": "#f2f2f2"}
"""Fill of a node by its kind."""

FONT: dict[str, Any] = {"family": "monospace", "fontsize": LETTER_PT, "color": INK}

PLAIN: dict[str, Any] = {"color": INK}
TAKEN: dict[str, Any] = {"color": "#0072b2", "linewidth": 2.4}
"""Styles of edges: plain, and taken by a plan."""

HEAD_PT = (9.0, 3.6)
"""Length and half the width of an arrow head, points."""

NOTE_LETTERS = 48
"""Letters in a line of the notes below a narrow diagram."""

GAP_PT = (32.0, 12.0)
"""Least distance between columns and within them, points."""

MARGIN_PT = 6.0
"""Empty border of a diagram, points."""

START_PT = 30.0
"""Length of the arrow that points at the first node, points."""

TITLE_LETTER_PT = 15.0
"""Font size of titles."""

TITLE_PT = 26.0
"""Height of the title of a diagram in a file, points."""

APART_PT = 18.0
"""Distance between two diagrams in a file, points."""


@dataclass(frozen=True)
class Node:
    """A node.

    Attributes:
        name: its class in SVG.
        text: the lines of text in it.
        kind: `plain`, `accepting` or `dead`.
    """

    name: str
    text: tuple[str, ...]
    kind: str = "plain"


@dataclass(frozen=True)
class Edge:
    """An edge between two nodes, given by index, with its label; `kind` is `plain` or `taken` (by a plan)."""

    source: int
    target: int
    label: str
    kind: str = "plain"


@dataclass(frozen=True)
class Arrow:
    """A laid out edge.

    Attributes:
        edge: the edge.
        curve: (1 + 3 n, 2) control points of n joined cubic Bezier curves.
        lines: the lines of the label.
        at: (2,) midpoint of the label's lower edge.
    """

    edge: Edge
    curve: np.ndarray
    lines: tuple[str, ...]
    at: np.ndarray


@dataclass(frozen=True)
class NodeLinkDiagram:
    """A laid out diagram; x to the right, y downwards.

    Attributes:
        nodes: the nodes; the first is the start.
        middles: (N, 2) centres of the nodes.
        sizes: (N, 2) widths and heights of the nodes.
        start: (4, 2) the curve of the arrow that points at the start.
        arrows: the edges.
        size: width and height of the diagram, with its notes.
        notes: lines of text below the drawing.
    """

    nodes: tuple[Node, ...]
    middles: np.ndarray
    sizes: np.ndarray
    start: np.ndarray
    arrows: tuple[Arrow, ...]
    size: tuple[float, float]
    notes: tuple[str, ...] = ()


def arrange(nodes: Sequence[Node], edges: Sequence[Edge], *, widest: float | None = None) -> NodeLinkDiagram:
    """Lay out a diagram in which every node can be reached from the first.

    If it would be wider than `widest`, it is laid out downwards, if that is narrower and no edge is a self-loop.
    """
    diagram = _arranged(nodes, edges, down=False)
    if widest is None or diagram.size[0] <= widest or any(edge.source == edge.target for edge in edges):
        return diagram
    return min(diagram, _arranged(nodes, edges, down=True), key=lambda found: found.size[0])


def _arranged(nodes: Sequence[Node], edges: Sequence[Edge], *, down: bool) -> NodeLinkDiagram:
    """Lay out a diagram to the right or downwards; until the end x is the axis of the layers in both cases."""
    texts = [(max(map(len, node.text)), len(node.text)) for node in nodes]
    sizes = (np.array(texts) * (ADVANCE_PT, LINE_PT) + np.array((1.2, 0.8)) * RADIUS_PT).clip(min=2 * RADIUS_PT)
    turn = slice(None, None, -1 if down else 1)
    straight = [edge for edge in edges if edge.source != edge.target]
    round_edges = [edge for edge in edges if edge.source == edge.target]
    labels, notes = edge_labels([(edge.label, edge.source == edge.target) for edge in [*straight, *round_edges]])
    loops = {edge.source: lines for edge, lines in zip(round_edges, labels[len(straight) :], strict=True)}
    boxes = [_node_box(size[turn], loops.get(i, ())) for i, size in enumerate(sizes)]
    spaces = [_label_box(lines, down=down) for lines in labels[: len(straight)]]
    layout = place(boxes, [(edge.source, edge.target) for edge in straight], spaces, gap=GAP_PT)
    origin = np.array([MARGIN_PT + START_PT, MARGIN_PT])
    middles, halves = layout.nodes + origin, sizes[:, turn] / 2
    arrows = []
    for edge, route, lines, space, at in zip(straight, layout.routes, labels, spaces, layout.labels, strict=False):
        a, b = edge.source, edge.target
        clear = [boxes[end].width / 2 if end in loops else 0.0 for end in (a, b)]
        curve = curve_between(middles[a], halves[a], route + origin, middles[b], halves[b], clear)
        lower = [space.width / 2 - 2, space.below / 2] if down else [0, -2]
        arrows.append(Arrow(edge, curve[:, turn], lines, (at + origin + lower)[turn]))
    for edge in round_edges:
        top = middles[edge.source] - [0, halves[edge.source][1]]
        arrows.append(Arrow(edge, loop_above(top), loops[edge.source], top - [0, LOOP_PT - 1]))
    entry = middles[0] - [halves[0][0], 0]
    start = entry - np.outer([START_PT, START_PT / 2, START_PT / 2, 0], [1, 0])
    width, height = np.array([layout.size[0] + START_PT + 2 * MARGIN_PT, layout.size[1] + 2 * MARGIN_PT])[turn].tolist()
    diagram = NodeLinkDiagram(tuple(nodes), middles[:, turn], sizes, start[:, turn], tuple(arrows), (width, height))
    return _with_notes(diagram, notes)


def _node_box(size: np.ndarray, loop: Sequence[str]) -> Box:
    """Return the space for a node of a (2,) size and for the label of its self-loop, if it has one."""
    width, height = size
    above = height / 2 + (LOOP_PT + LINE_PT * len(loop) + 4 if loop else 0)
    return Box(max([width, *(ADVANCE_PT * len(line) for line in loop)]), above, height / 2)


def _label_box(lines: Sequence[str], *, down: bool) -> Box:
    """Return the space for the label of an edge: above the edge, or to the right of one that goes down."""
    width, height = ADVANCE_PT * max(map(len, lines)) + 8, LINE_PT * len(lines) + 4
    return Box(height, 4, width) if down else Box(width, height, 4)


def _with_notes(diagram: NodeLinkDiagram, notes: Sequence[str]) -> NodeLinkDiagram:
    """Return a diagram with notes below it."""
    if not notes:
        return diagram
    width, height = diagram.size
    letters = max(NOTE_LETTERS, int((width - 2 * MARGIN_PT) / ADVANCE_PT))
    lines = tuple(line for note in notes for line in wrapped(note, letters))
    widest = max(map(len, lines)) * ADVANCE_PT + 2 * MARGIN_PT
    return replace(diagram, notes=lines, size=(max(width, widest), height + LINE_PT * len(lines) + MARGIN_PT))


def svg(diagram: NodeLinkDiagram, *, title: str) -> str:
    """Return a diagram as inline SVG in the colour of the surrounding text.

    A node has the classes `node`, its kind and its name; an edge has `edge` and its nodes' names with a hyphen between.

    The title describes the diagram for screen readers.
    """
    with drawing(size=(diagram.size[0] / POINTS_PER_INCH, diagram.size[1] / POINTS_PER_INCH)) as figure:
        _draw(figure.add_axes((0, 0, 1, 1)), diagram)
        return inline_svg(figure, kind="diagram", title=title).replace(INK, "currentColor")


def draw(diagrams: Mapping[str, NodeLinkDiagram], path: Path) -> None:
    """Write diagrams one below the other, each below its title, as SVG, PNG or PDF by the ending of the file.

    Raises:
        PrefplanError: the file cannot be written.
    """
    width = max(max(0.602 * TITLE_LETTER_PT * len(title) + 20, diagram.size[0]) for title, diagram in diagrams.items())
    height = sum(TITLE_PT + diagram.size[1] + APART_PT for diagram in diagrams.values()) - APART_PT
    with drawing(size=(width / POINTS_PER_INCH, height / POINTS_PER_INCH)) as figure:
        below = height
        for title, diagram in diagrams.items():
            figure.text(
                8 / width, (below - 17) / height, title, parse_math=False, **FONT | {"fontsize": TITLE_LETTER_PT}
            )
            below -= TITLE_PT + diagram.size[1]
            _draw(figure.add_axes((0, below / height, diagram.size[0] / width, diagram.size[1] / height)), diagram)
            below -= APART_PT
        write_figure(figure, path)


def _draw(axes: Axes, diagram: NodeLinkDiagram) -> None:
    axes.set(xlim=(0, diagram.size[0]), ylim=(diagram.size[1], 0))
    axes.set_axis_off()
    _draw_arrow(axes, diagram.start, "start", PLAIN)
    for arrow in diagram.arrows:
        ends = "-".join(diagram.nodes[end].name for end in (arrow.edge.source, arrow.edge.target))
        gid, style = f"edge {ends}", PLAIN
        if arrow.edge.kind == "taken":
            gid, style = f"edge {ends} taken", TAKEN
        _draw_arrow(axes, arrow.curve, gid, style)
        _draw_text(axes, arrow.at, arrow.lines, va="bottom", gid=gid, color=style["color"])
    below = diagram.size[1] - MARGIN_PT - LINE_PT * (len(diagram.notes) - 1)
    for i, line in enumerate(diagram.notes):
        axes.text(MARGIN_PT, below + i * LINE_PT, line, ha="left", va="bottom", gid="note", parse_math=False, **FONT)
    for node, middle, size in zip(diagram.nodes, diagram.middles, diagram.sizes, strict=True):
        _draw_box(axes, middle, size, kind=node.kind, gid=f"node {node.kind} {node.name}")
        if node.kind == "accepting":
            _draw_box(axes, middle, size - 7, kind=node.kind, gid="inner")
        _draw_text(axes, middle, node.text, va="center", gid=f"text {node.name}")


def _draw_text(axes: Axes, at: np.ndarray, lines: Sequence[str], **place: Any) -> None:
    axes.text(at[0], at[1], "\n".join(lines), ha="center", linespacing=SPACING, parse_math=False, **FONT | place)


def _draw_arrow(axes: Axes, curve: np.ndarray, gid: str, line: Mapping[str, Any]) -> None:
    path = Path2D(curve, [Path2D.MOVETO, *[Path2D.CURVE4] * (len(curve) - 1)])
    style = f"-|>,head_length={HEAD_PT[0]},head_width={HEAD_PT[1]}"
    axes.add_patch(FancyArrowPatch(path=path, arrowstyle=style, mutation_scale=1, gid=gid, **line))


def _draw_box(axes: Axes, middle: np.ndarray, size: np.ndarray, *, kind: str, gid: str) -> None:
    style: dict[str, Any] = {"edgecolor": INK, "facecolor": FILL[kind], "linestyle": "--" if kind == "dead" else "-"}
    if size[0] == size[1]:
        axes.add_patch(Ellipse((middle[0], middle[1]), size[0], size[1], gid=gid, **style))
        return
    corner, radius = middle - size / 2, min(RADIUS_PT, size[1] / 2)
    rounded = BoxStyle.Round(pad=0, rounding_size=radius)
    axes.add_patch(FancyBboxPatch((corner[0], corner[1]), size[0], size[1], rounded, gid=gid, **style))
