"""Layered layout of directed graphs, left to right, with space for the labels of the edges.

The label of an edge is a vertex between the ends of the edge, so that the layout keeps labels apart like nodes. Layers
and order are those of the library `fast_sugiyama` (K. Sugiyama, S. Tagawa and M. Toda, "Methods for Visual
Understanding of Hierarchical System Structures", IEEE Trans. SMC, 1981). It takes every vertex for a point: here the
vertices get their sizes.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np
from fast_sugiyama import from_edges


@dataclass(frozen=True)
class Box:
    """Extent of a node or a label about its line of the layout.

    Attributes:
        width: half to the left, half to the right.
        above: upwards from the line.
        below: downwards from the line.
    """

    width: float
    above: float
    below: float


@dataclass(frozen=True)
class LayeredDrawing:
    """Positions in a layout; x to the right, y downwards, all coordinates positive.

    Attributes:
        nodes: (N, 2) centre of every node.
        routes: for every edge, (P, 2) points from source to target without the ends, at which the edge is horizontal.
        labels: (E, 2) centre of the line below the label of every edge.
        size: width and height of the drawing.
    """

    nodes: np.ndarray
    routes: tuple[np.ndarray, ...]
    labels: np.ndarray
    size: tuple[float, float]


def place(
    nodes: Sequence[Box], edges: Sequence[tuple[int, int]], labels: Sequence[Box], *, gap: tuple[float, float]
) -> LayeredDrawing:
    """Lay out a graph whose nodes can all be reached from node 0.

    Args:
        nodes: the extent of each node.
        edges: (source, target), without self-loops.
        labels: the extent of the label of each edge.
        gap: least distance between columns and within them.
    """
    if not edges:
        return LayeredDrawing(
            np.array([[nodes[0].width / 2, nodes[0].above]]),
            (),
            np.empty((0, 2)),
            (nodes[0].width, nodes[0].above + nodes[0].below),
        )
    forward = list(_forward(len(nodes), edges))
    halves = [half for i, (a, b) in enumerate(forward, start=len(nodes)) for half in ((a, i), (i, b))]
    ((positions, _, last, links),) = from_edges(halves, vertex_spacing=1, dummy_vertices=True, dummy_size=1.0)
    boxes = dict(enumerate([*nodes, *labels]))
    column = {int(vertex): round(last - layer) for vertex, (_, layer) in positions}
    lines = {int(vertex): -line for vertex, (line, _) in positions}
    widths = np.zeros(round(last) + 1)
    for vertex, box in boxes.items():
        widths[column[vertex]] = max(widths[column[vertex]], box.width)
    right = np.cumsum(widths + gap[0]) - gap[0]
    y = _heights(column, lines, boxes, gap[1])
    before = {int(b): int(a) for a, b in links or ()}
    after = {int(a): int(b) for a, b in links or ()}
    routes = []
    for i, (edge, (source, _)) in enumerate(zip(forward, edges, strict=True), start=len(nodes)):
        first = i
        while before[first] != edge[0]:
            first = before[first]
        chain = [first]
        while after[chain[-1]] != edge[1]:
            chain.append(after[chain[-1]])
        points = [(x, y[v]) for v in chain for x in (right[column[v]] - widths[column[v]], right[column[v]])]
        routes.append(np.array(points if edge[0] == source else points[::-1]))
    centres = np.array([(right[column[v]] - widths[column[v]] / 2, y[v]) for v in boxes])
    height = max(y[v] + box.below for v, box in boxes.items())
    return LayeredDrawing(centres[: len(nodes)], tuple(routes), centres[len(nodes) :], (float(right[-1]), height))


def _forward(count: int, edges: Sequence[tuple[int, int]]) -> Iterator[tuple[int, int]]:
    """Yield every edge from left to right: edges that lead back towards node 0 and so close a cycle are reversed."""
    graph = nx.DiGraph(edges)
    distance = nx.single_source_shortest_path_length(graph, 0)
    component = {node: i for i, part in enumerate(nx.strongly_connected_components(graph)) for node in part}
    for source, target in edges:
        back = component[source] == component[target] and (distance[target], target) < (distance[source], source)
        yield (target, source) if back else (source, target)


def _heights(
    column: Mapping[int, int], lines: Mapping[int, float], boxes: Mapping[int, Box], gap: float
) -> dict[int, float]:
    """Return the y coordinate of every vertex: equal on equal lines, and far enough apart in every column."""
    point = Box(0, 0, 0)
    on_line = defaultdict(list)
    for vertex, line in lines.items():
        on_line[line].append(vertex)
    heights: dict[int, float] = {}
    bottom: dict[int, float] = {}
    height = 0.0
    for line in sorted(on_line):
        vertices = on_line[line]
        needed = [bottom.get(column[v], 0.0) + boxes.get(v, point).above for v in vertices]
        height = max(height, *needed)
        for v in vertices:
            heights[v] = height
            bottom[column[v]] = height + boxes.get(v, point).below + gap
    return heights
