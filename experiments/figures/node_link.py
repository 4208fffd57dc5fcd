"""Node-link diagrams in SVG: nodes, and arrows with labels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from experiments.cli.files import write_bytes
from experiments.figures.layered import Box, place

LETTER = 13.0
"""Font size, px."""

ADVANCE = 0.602 * LETTER
"""Width of a letter, px; the same for all letters, so that the width of a label is known for every font."""

LINE = 1.25 * LETTER
"""Distance between two lines of text, px."""

FONT = "ui-monospace, 'DejaVu Sans Mono', Menlo, Consolas, monospace"

RADIUS = 17.0
"""Radius of a node with a short name, px; a node with a long name is a box with ends of this radius."""

LOOP = 30.0
"""Height of a self-loop above its node, px."""

HEAD = (9.0, 3.6)
"""Length and half the width of an arrow head, px."""

WIDEST, WIDEST_LOOP = 36, 9
"""Most letters in a line of a label that can be broken: of an edge, of a self-loop (edges leave the node beside it)."""

MOST_LINES = 6
"""Most lines of a label; the tooltip has the whole text."""

GAP = (32.0, 12.0)
"""Least distance between columns and within them, px."""

MARGIN = 6.0
"""Empty border of a diagram, px."""

START = 30.0
"""Length of the arrow that points at the first node, px."""

TITLE_LETTER = 15.0
"""Font size of titles, px; of the same font as all else, as the converter orders several fonts in a PDF at random."""

TITLE = 26.0
"""Height of the title of a diagram in a file, px."""

APART = 18.0
"""Distance between two diagrams in a file, px."""

SCALE = 2.1
"""Pixels of a PNG file per px."""

STYLE = ".plain .body { fill: #fff } .accepting .body { fill: #d9efdc } .dead .body { fill: #f2f2f2 }"
"""Fill of nodes in a file; on a page the page's own style sheet has it."""


@dataclass(frozen=True)
class Node:
    """A node.

    Attributes:
        name: its id.
        text: the lines of text in it.
        kind: `plain`, `accepting` or `dead`.
        about: its tooltip.
    """

    name: str
    text: tuple[str, ...]
    kind: str = "plain"
    about: str = ""


@dataclass(frozen=True)
class Edge:
    """An edge between two nodes, given by number, with its label."""

    source: int
    target: int
    label: str


@dataclass(frozen=True)
class Arrow:
    """A laid out edge.

    Attributes:
        edge: the edge.
        curve: (1 + 3 n, 2) control points of n joined cubic Bezier curves, up to the arrow head.
        head: (3, 2) corners of the arrow head.
        lines: the lines of the label.
        at: (2,) middle of the lowest base line of the label.
    """

    edge: Edge
    curve: np.ndarray
    head: np.ndarray
    lines: tuple[str, ...]
    at: np.ndarray


@dataclass(frozen=True)
class Diagram:
    """A laid out diagram; x to the right, y downwards.

    Attributes:
        nodes: the nodes; the first is the start.
        middles: (N, 2) centres of the nodes.
        widths: (N,) widths of the nodes.
        heights: (N,) heights of the nodes.
        start: `curve` and `head` of the arrow that points at the start.
        arrows: the edges.
        size: width and height of the diagram.
    """

    nodes: tuple[Node, ...]
    middles: np.ndarray
    widths: np.ndarray
    heights: np.ndarray
    start: tuple[np.ndarray, np.ndarray]
    arrows: tuple[Arrow, ...]
    size: tuple[float, float]


def arrange(nodes: Sequence[Node], edges: Sequence[Edge]) -> Diagram:
    """Lay out a diagram in which every node can be reached from the first."""
    widths = np.array([max(2 * RADIUS, ADVANCE * max(map(len, node.text)) + 1.2 * RADIUS) for node in nodes])
    heights = np.array([max(2 * RADIUS, LINE * len(node.text) + 0.8 * RADIUS) for node in nodes])
    loops = {edge.source: _lines(edge.label, WIDEST_LOOP) for edge in edges if edge.source == edge.target}
    boxes = []
    for i in range(len(nodes)):
        lines = loops.get(i, ())
        width = max([widths[i], *(ADVANCE * len(line) for line in lines)])
        above = heights[i] / 2 + (LOOP + LINE * len(lines) + 4 if lines else 0)
        boxes.append(Box(width, above, heights[i] / 2))
    straight = [edge for edge in edges if edge.source != edge.target]
    texts = [_lines(edge.label, WIDEST) for edge in straight]
    labels = [Box(ADVANCE * max(map(len, text)) + 8, LINE * len(text) + 4, 4) for text in texts]
    layout = place(boxes, [(edge.source, edge.target) for edge in straight], labels, gap=GAP)
    origin = np.array([MARGIN + START, MARGIN])
    middles = layout.nodes + origin
    halves = np.column_stack([widths, heights]) / 2
    arrows = []
    for edge, route, text, label in zip(straight, layout.routes, texts, layout.labels, strict=True):
        curve, head = _through(
            middles[edge.source], halves[edge.source], route + origin, middles[edge.target], halves[edge.target]
        )
        arrows.append(Arrow(edge, curve, head, text, label + origin - [0, 5]))
    for edge in edges:
        if edge.source == edge.target:
            top = middles[edge.source] - [0, halves[edge.source][1]]
            curve, head = _loop(top)
            arrows.append(Arrow(edge, curve, head, loops[edge.source], top - [0, LOOP + 2]))
    entry = middles[0] - [halves[0][0], 0]
    start = _headed(np.array([entry - [START, 0], entry - [START / 2, 0], entry - [START / 2, 0], entry]))
    size = (layout.size[0] + START + 2 * MARGIN, layout.size[1] + 2 * MARGIN)
    return Diagram(tuple(nodes), middles, widths, heights, start, tuple(arrows), size)


def svg(diagram: Diagram, *, title: str, prefix: str = "") -> str:
    """Return a diagram as inline SVG in the colour of the text around it.

    Nodes and edges are groups of the classes `node` and `edge`, a node's also of its kind, and have ids: a node its
    name, an edge its nodes' with a hyphen between. Each takes its `color` from the page.

    Args:
        diagram: the diagram.
        title: what it shows, for those who cannot see it.
        prefix: put before every id, which are to be unique in a page.
    """
    width, height = diagram.size
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" '
        f'height="{height:.0f}" role="img" aria-label={quoteattr(title)} class="diagram" fill="none" '
        f'stroke="currentColor" stroke-width="1.4" font-family="{FONT}" font-size="{LETTER:g}" text-anchor="middle">',
        f'<g class="start">{_arrow_svg(*diagram.start)}</g>',
    ]
    for arrow in diagram.arrows:
        names = [diagram.nodes[end].name for end in (arrow.edge.source, arrow.edge.target)]
        lines.append(f'<g class="edge" id={quoteattr(prefix + "-".join(names))}>{_about(arrow.edge.label)}')
        lines.append(_arrow_svg(arrow.curve, arrow.head))
        lines.append(_text_svg(arrow.lines, arrow.at, LINE) + "</g>")
    for node, (x, y), w, h in zip(diagram.nodes, diagram.middles, diagram.widths, diagram.heights, strict=True):
        lines.append(f'<g class="node {node.kind}" id={quoteattr(prefix + node.name)}>{_about(node.about)}')
        dashed = ' stroke-dasharray="4 3"' if node.kind == "dead" else ""
        lines.append(_box_svg(x, y, w, h, f'class="body"{dashed}'))
        if node.kind == "accepting":
            lines.append(_box_svg(x, y, w - 7, h - 7, 'class="inner"'))
        base = np.array([x, y + LINE * (len(node.text) - 1) / 2 + 0.35 * LETTER])
        lines.append(_text_svg(node.text, base, LINE) + "</g>")
    return "\n".join([*lines, "</svg>"])


def draw(diagrams: Mapping[str, Diagram], path: Path) -> None:
    """Write diagrams one below the other, each below its title, as SVG, PNG or PDF by the ending of the file.

    Raises:
        PrefplanError: the file cannot be written.
    """
    width = max(
        [0.602 * TITLE_LETTER * len(title) + 20 for title in diagrams]
        + [diagram.size[0] for diagram in diagrams.values()]
    )
    lines, top = [], 0.0
    for number, (title, diagram) in enumerate(diagrams.items()):
        lines.append(
            f'<text x="8" y="{top + 17:.1f}" font-family="{FONT}" font-size="{TITLE_LETTER:g}" fill="currentColor">'
            f"{escape(title)}</text>"
        )
        picture = svg(diagram, title=title, prefix=f"d{number}-")
        lines.append(f'<g transform="translate(0,{top + TITLE:.1f})">{picture}</g>')
        top += TITLE + diagram.size[1] + APART
    height = top - APART
    drawn = "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" '
            f'height="{height:.0f}" color="#222"><style>{STYLE}</style><rect width="100%" height="100%" fill="#fff"/>',
            *lines,
            "</svg>\n",
        ]
    )
    write_bytes(path, _converted(drawn, path.suffix.lower()))


def _converted(picture: str, ending: str) -> bytes:
    """Return an SVG picture as the content of a file with this ending."""
    if ending == ".svg":
        return picture.encode()
    import matplotlib
    import vl_convert

    vl_convert.register_font_directory(str(Path(matplotlib.get_data_path(), "fonts", "ttf")))
    return vl_convert.svg_to_png(picture, scale=SCALE) if ending == ".png" else vl_convert.svg_to_pdf(picture)


def _lines(label: str, widest: int) -> tuple[str, ...]:
    """Return a label in lines, one for each term of a sum if it is too long for one, broken before `&` if need be."""
    lines: list[str] = []
    for term in [label] if len(label) <= widest else label.replace(" | ", "\n| ").split("\n"):
        lines.append("")
        for word in [term] if len(term) <= widest else term.replace(" & ", "\n& ").split("\n"):
            if lines[-1] and len(lines[-1]) + 1 + len(word) > widest:
                lines.append("")
            lines[-1] = f"{lines[-1]} {word}".strip()
    return tuple(lines if len(lines) <= MOST_LINES else [*lines[: MOST_LINES - 1], "..."])


def _through(
    source: np.ndarray, half: np.ndarray, route: np.ndarray, target: np.ndarray, other: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return a smooth curve from node to node by way of some points in which it is level, and its head."""
    first, last = _border(source, half, route[0]), _border(target, other, route[-1])
    points = [first, *route, last]
    out, into = _outwards(source, first), -_outwards(target, last)
    level = np.array([np.sign(route[-1][0] - route[0][0]) or np.sign(target[0] - source[0]), 0.0])
    tangents = [out, *([level] * len(route)), into]
    curve = [first]
    for (a, b), (u, v) in zip(
        zip(points, points[1:], strict=False), zip(tangents, tangents[1:], strict=False), strict=True
    ):
        reach = 0.55 * abs(b[0] - a[0])
        curve += [a + reach * u / max(abs(u[0]), 0.7), b - reach * v / max(abs(v[0]), 0.7), b]
    return _headed(np.array(curve))


def _border(middle: np.ndarray, half: np.ndarray, towards: np.ndarray) -> np.ndarray:
    """Return where a curve that comes from some point meets a node: on its side, less steeply than it comes."""
    apart = towards - middle
    up = half[1] * np.sin(np.clip(np.arctan2(apart[1], abs(apart[0])), -1.0, 1.0))
    round_part = max(0.0, abs(up) - (half[1] - RADIUS))
    across = half[0] - RADIUS + np.sqrt(RADIUS**2 - round_part**2)
    return middle + [(np.sign(apart[0]) or 1.0) * across, up]


def _outwards(middle: np.ndarray, border: np.ndarray) -> np.ndarray:
    apart = border - middle
    apart = np.array([apart[0], apart[1] * 0.6])
    return apart / np.linalg.norm(apart)


def _loop(top: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a self-loop above a node."""
    a, b = top + [-8.5, 2.4], top + [8.5, 2.4]
    rise = 1.25 * LOOP
    return _headed(np.array([a, a + [-9, -rise], b + [9, -rise], b]))


def _headed(curve: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a curve shortened by the length of an arrow's head, and the head."""
    length, half = HEAD
    tip = curve[-1]
    back = curve[-2] - tip
    back /= np.linalg.norm(back)
    foot, across = tip + length * back, np.array([-back[1], back[0]])
    shortened = curve.copy()
    shortened[-1] = tip + 0.8 * length * back
    return shortened, np.array([tip, foot + half * across, foot - half * across])


def _arrow_svg(curve: np.ndarray, head: np.ndarray) -> str:
    start, *rest = (f"{x:.1f} {y:.1f}" for x, y in curve)
    ends = " ".join(f"{x:.1f},{y:.1f}" for x, y in head)
    return f'<path d="M{start}C{" ".join(rest)}"/><polygon points="{ends}" fill="currentColor" stroke="none"/>'


def _box_svg(x: float, y: float, width: float, height: float, extra: str) -> str:
    radius = min(RADIUS, height / 2)
    corner = f'x="{x - width / 2:.1f}" y="{y - height / 2:.1f}"'
    return f'<rect {corner} width="{width:.1f}" height="{height:.1f}" rx="{radius:.1f}" {extra}/>'


def _text_svg(lines: Sequence[str], base: np.ndarray, step: float) -> str:
    """Return lines of text, the last one standing on a point."""
    texts = [
        f'<text x="{base[0]:.1f}" y="{base[1] - step * (len(lines) - 1 - i):.1f}" fill="currentColor" '
        f'stroke="none">{escape(line)}</text>'
        for i, line in enumerate(lines)
    ]
    return "".join(texts)


def _about(text: str) -> str:
    return f"<title>{escape(text)}</title>" if text else ""
