"""Node-link diagrams: nodes, and arrows with labels, laid out and drawn by Graphviz."""

import os
import re
import shutil
import subprocess
import sys
import textwrap
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isqrt
from pathlib import Path

from experiments.cli.files import write_bytes
from experiments.figures.figures import POINTS_PER_INCH, SVG, inline_svg
from prefplan.errors import PrefplanError
from prefplan.text.layout import printable

FONT = 'fontname="Courier", fontsize=13'
"""A monospaced font (size in points), so that labels are in every browser as wide as Graphviz expects."""

STYLES = {
    "plain": 'style=filled, fillcolor="white"',
    "accepting": 'style=filled, fillcolor="#d9efdc"',
    "dead": 'style="filled,dashed", fillcolor="#f2f2f2"',
    "taken": 'color="#0072b2", fontcolor="#0072b2", penwidth=2.4',
}
"""Attributes of a node or an edge by its kind."""

LETTER_PT = 7.8
"""Width of a letter, points."""

NODE_PT = 34.0
"""Width of the smallest node, points."""

GAPS_PT = {"LR": 12.0, "TB": 18.0}
"""Least distance of a column (`LR`) or a row (`TB`) of nodes from the labels beside it, points."""

WIDEST = 36
"""Greatest number of letters in a line of a label, unless it would have too many lines."""

MOST_LINES = 8
"""Approximate number of lines of a label that is too long for lines of `WIDEST` letters."""

WIDEST_LOOP = 9
"""`WIDEST` for the label of a self-loop, beside which other edges leave."""

LOOP_SHAPE = 12
"""Letters in a line per line of a longer label of a self-loop: a block about six times as wide as high."""

PNG_DPI = 200
"""Pixels per inch of a PNG, as in the other figures."""

_TIME_OF_PDF = re.compile(rb"(/CreationDate \(D:)\d{14}")
"""Time of drawing that Cairo writes into a PDF; it is replaced, so that equal pictures are equal files."""


class GraphvizError(PrefplanError):
    """Graphviz is not installed, or cannot draw."""


@dataclass(frozen=True)
class Node:
    """A node: its class in SVG, the lines of text in it, and its kind, `plain`, `accepting` or `dead`."""

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
class Diagram:
    """Nodes, of which the first is the start, and edges."""

    nodes: Sequence[Node]
    edges: Sequence[Edge]


def program() -> str | None:
    """Return the path of `dot` or, where it is not installed, of the port `graphviz-pure`; None if there is neither."""
    places = os.pathsep.join([os.environ.get("PATH", os.defpath), str(Path(sys.executable).parent)])
    return shutil.which("dot", path=places) or shutil.which("graphviz-pure", path=places)


def svg(diagram: Diagram, *, title: str, direction: str = "LR") -> str:
    """Return a diagram as inline SVG in the colour of the surrounding text.

    A node has the classes `node`, its kind and its name; an edge has `edge` and its nodes' names with a hyphen between.
    The title describes the diagram for screen readers; its direction is as in `source`.

    Raises:
        GraphvizError: Graphviz is not installed.
    """
    root = ET.fromstring(_rendered(source({"": diagram}, direction), "svg", "-Gbgcolor=transparent"))
    del root[0].attrib["class"]
    for part in list(root.iter()):
        part.attrib.pop("id", None)
        if part.tag == f"{SVG}text":
            part.attrib.setdefault("fill", "black")
        part.attrib.update({key: "currentColor" for key in ("fill", "stroke") if part.get(key) == "black"})
        # Titles are Graphviz' own names of nodes and edges.
        for name in part.findall(f"{SVG}title"):
            part.remove(name)
    return inline_svg(root, kind="diagram", title=printable(title))


def draw(diagrams: Mapping[str, Diagram], path: Path) -> None:
    """Write diagrams one below the other, each below its title, as SVG, PNG or PDF by the ending of the file.

    Raises:
        GraphvizError: Graphviz is not installed, or cannot write such files.
        PrefplanError: the file cannot be written.
    """
    form = path.suffix.lower()[1:]
    options = [f"-Gdpi={PNG_DPI}"] if form == "png" else []
    write_bytes(path, _rendered(source(diagrams), form, *options))


def _rendered(source: str, form: str, *options: str) -> bytes:
    graphviz = program()
    if graphviz is None:
        raise GraphvizError(
            "Graphviz draws this, and it is not installed: get Debian's package graphviz, or prefplan's extra graphviz"
        )
    command = [graphviz, f"-T{form}", *options]
    done = subprocess.run(command, input=source.encode(), capture_output=True, check=False)
    if done.returncode:
        raise GraphvizError(
            f"{Path(graphviz).name} cannot write {form}: {done.stderr.decode().strip().splitlines()[0]}"
        )
    return _TIME_OF_PDF.sub(rb"\g<1>20000101000000", done.stdout)


def source(diagrams: Mapping[str, Diagram], direction: str = "LR") -> str:
    """Return diagrams by their titles in Graphviz' language, laid out to the right (`LR`) or downwards (`TB`)."""
    gap = GAPS_PT[direction]
    loops = [edge for diagram in diagrams.values() for edge in diagram.edges if edge.source == edge.target]
    if direction == "LR" and loops:
        # Graphviz reserves no width for labels of self-loops here; other labels lie half-way between ranks.
        widest = max(len(line) for edge in loops for line in _lines(edge))
        gap = max(gap, (gap + LETTER_PT * widest - NODE_PT) / 2)
    # If ranks go to the right, Graphviz stacks the diagrams from the bottom to the top.
    parts = []
    for k, (title, diagram) in reversed([*enumerate(diagrams.items())]):
        parts += [f"subgraph cluster_{k} {{", *_statements(k, title, diagram, direction), "}"]
    header = f"""digraph {{
rankdir={direction}; pad=0.1; ranksep={2 * gap / POINTS_PER_INCH:.2f}; nodesep=0.3
node [{FONT}, height=0.47, width=0.47, margin="0.12,0.06"]
edge [{FONT}, arrowsize=0.7]"""
    return "\n".join([header, *parts, "}\n"])


def _statements(k: int, title: str, diagram: Diagram, direction: str) -> Iterator[str]:
    yield f'label={_quoted([title])}; labeljust=l; peripheries=0; fontname="Courier"; fontsize=15'
    yield f"start_{k} [shape=point, style=invis, width=0, height=0]"
    yield f"start_{k} -> n_{k}_0 [class=start]"
    for i, node in enumerate(diagram.nodes):
        short = len(node.text) == 1 and len(node.text[0]) <= 2
        shape = "doublecircle" if node.kind == "accepting" else "circle" if short else "box"
        style = STYLES[node.kind] if short else 'style="filled,rounded", fillcolor="white"'
        yield f'n_{k}_{i} [label={_quoted(node.text)}, class="{node.kind} {node.name}", shape={shape}, {style}]'
    for edge in diagram.edges:
        ends = "-".join(diagram.nodes[end].name for end in (edge.source, edge.target))
        style = f'class="{ends} taken", {STYLES["taken"]}' if edge.kind == "taken" else f'class="{ends}"'
        # Beside an edge that goes down, a label needs a gap of its own.
        lines = [f" {line} " for line in _lines(edge)] if direction == "TB" else _lines(edge)
        yield f"n_{k}_{edge.source} -> n_{k}_{edge.target} [label={_quoted(lines)}, {style}]"


def _lines(edge: Edge) -> list[str]:
    """Return the lines of a label, broken before `|` and `&`."""
    label, letters = edge.label, max(WIDEST, len(edge.label) // MOST_LINES)
    if edge.source == edge.target:
        letters = max(WIDEST_LOOP, isqrt(LOOP_SHAPE * len(label)))
    if len(label) <= letters:
        return [label]
    lines = []
    for part in label.replace(" | ", "\n| ").split("\n"):
        bound = re.sub(r"([|&]) ", "\\1\N{NO-BREAK SPACE}", part)
        lines += textwrap.wrap(bound, letters, break_long_words=False, break_on_hyphens=False)
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in lines]


def _quoted(lines: Sequence[str]) -> str:
    """Return lines of text as a quoted string for Graphviz, with backslashes, quotes and `&` escaped."""
    escaped = (printable(line).replace("\\", "\\\\").replace('"', '\\"').replace("&", "&amp;") for line in lines)
    return '"' + "\\n".join(escaped) + '"'
