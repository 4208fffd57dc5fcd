"""Layered layout of directed graphs, left to right, with room for the edges' labels.

After K. Sugiyama, S. Tagawa and M. Toda, "Methods for Visual Understanding of Hierarchical System Structures", IEEE
Trans. SMC, 1981. Nodes stand in even columns. An edge passes every column between its ends in a box of its own, in
one of the odd ones with its label, so that nothing ever lies on anything else. The order in each column is that of
the fewest crossings met in some sweeps; heights are then drawn towards the neighbours' by isotonic regression.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np
from scipy.optimize import isotonic_regression

SWEEPS = 24
"""How often the columns are put in a new order, and then their heights drawn together."""

STIFFNESS = 8.0
"""How much more an edge resists a bend between two columns than where it meets its nodes."""


@dataclass(frozen=True)
class Box:
    """Room that something takes about the line through it.

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
    """Where everything lies; x to the right, y downwards, all of it at positive coordinates.

    Attributes:
        nodes: (N, 2) middle of every node.
        routes: for every edge, (P, 2) points on its way from source to target, both left out; it is level in them.
        labels: (E, 2) middle of the line below every edge's label.
        size: width and height of the whole.
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
        nodes: the room each node takes.
        edges: (source, target), without self-loops.
        labels: the room each edge's label takes.
        gap: least distance between columns and within them.
    """
    rank = _ranks(len(nodes), edges)
    boxes, column = list(nodes), [2 * r for r in rank]
    links: list[tuple[int, int]] = []
    ways, label_of = [], []
    for (source, target), label in zip(edges, labels, strict=True):
        left, right = sorted((source, target), key=rank.__getitem__)
        between = range(2 * rank[left] + 1, 2 * rank[right])
        middle = between[len(between) // 2 - (len(between) // 2) % 2]
        way = []
        for c in between:
            way.append(len(boxes))
            boxes.append(label if c == middle else Box(0, 0, 0))
            column.append(c)
            if c == middle:
                label_of.append(way[-1])
        links += zip([left, *way], [*way, right], strict=True)
        ways.append(way if left == source else way[::-1])
    columns = _ordered(column, links)
    y = _heights(columns, boxes, links, gap[1], nodes=len(nodes))
    widths = [max(boxes[i].width for i in some) for some in columns]
    starts = np.cumsum([0, *(width + gap[0] for width in widths)])
    x = np.array([starts[c] + widths[c] / 2 for c in column])
    y -= min(y[i] - box.above for i, box in enumerate(boxes))
    height = max(y[i] + box.below for i, box in enumerate(boxes))
    routes = []
    for (source, target), way in zip(edges, ways, strict=True):
        sense = 1 if rank[source] < rank[target] else -1
        points = [(x[i] + sense * side * widths[column[i]] / 2, y[i]) for i in way for side in (-1, 1)]
        routes.append(np.array(points))
    return LayeredDrawing(
        np.column_stack([x, y])[: len(nodes)],
        tuple(routes),
        np.array([(x[i], y[i]) for i in label_of]).reshape(-1, 2),
        (float(starts[-1] - gap[0]), float(height)),
    )


def _ranks(count: int, edges: Sequence[tuple[int, int]]) -> list[int]:
    """Return each node's layer: the most edges on a way to it, where edges that close a circle count backwards."""
    graph = nx.DiGraph(edges)
    graph.add_nodes_from(range(count))
    distance = nx.single_source_shortest_path_length(graph, 0)
    part = {node: i for i, some in enumerate(nx.strongly_connected_components(graph)) for node in some}
    ahead = nx.DiGraph()
    ahead.add_nodes_from(range(count))
    for source, target in edges:
        back = part[source] == part[target] and (distance[target], target) < (distance[source], source)
        ahead.add_edge(*((target, source) if back else (source, target)))
    rank = [0] * count
    for node in nx.lexicographical_topological_sort(ahead):
        for after in ahead.successors(node):
            rank[after] = max(rank[after], rank[node] + 1)
    return rank


def _ordered(column: Sequence[int], links: Sequence[tuple[int, int]]) -> list[list[int]]:
    """Return the members of each column from top to bottom, by the barycentres of their neighbours."""
    columns: list[list[int]] = [[] for _ in range(max(column) + 1)]
    for i, c in enumerate(column):
        columns[c].append(i)
    before, after = _neighbours(links)
    place = {i: float(k) for some in columns for k, i in enumerate(some)}
    best, fewest = [list(some) for some in columns], _crossings(columns, links, column)
    for sweep in range(SWEEPS):
        forward = sweep % 2 == 0
        for some in columns if forward else reversed(columns):
            beside = before if forward else after
            centres = {i: np.mean([place[j] for j in beside[i]]) if beside[i] else place[i] for i in some}
            some.sort(key=lambda i: (centres[i], place[i]))
            for k, i in enumerate(some):
                place[i] = k - (len(some) - 1) / 2
        crossings = _crossings(columns, links, column)
        if crossings < fewest:
            best, fewest = [list(some) for some in columns], crossings
    return best


def _neighbours(links: Sequence[tuple[int, int]]) -> tuple[dict[int, list[int]], dict[int, list[int]]]:
    before, after = defaultdict(list), defaultdict(list)
    for left, right in links:
        before[right].append(left)
        after[left].append(right)
    return before, after


def _crossings(columns: Sequence[Sequence[int]], links: Sequence[tuple[int, int]], column: Sequence[int]) -> int:
    """Return how many pairs of links cross."""
    place = {i: k for some in columns for k, i in enumerate(some)}
    by_gap: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for left, right in links:
        by_gap[column[left]].append((place[left], place[right]))
    count = 0
    for some in by_gap.values():
        ends = np.array(some)
        apart = ends[:, None] - ends[None, :]
        count += int((apart[..., 0] * apart[..., 1] < 0).sum()) // 2
    return count


def _heights(
    columns: Sequence[Sequence[int]], boxes: Sequence[Box], links: Sequence[tuple[int, int]], gap: float, *, nodes: int
) -> np.ndarray:
    """Return the height of every box's line, as near to its neighbours' as the order allows; the first are nodes."""
    before, after = _neighbours(links)
    y = np.zeros(len(boxes))
    offsets = []
    for some in columns:
        steps = [boxes[a].below + boxes[b].above + gap for a, b in zip(some, some[1:], strict=False)]
        offsets.append(np.cumsum([0.0, *steps]))
        y[list(some)] = offsets[-1] - offsets[-1].mean()
    for sweep in range(SWEEPS):
        order = range(len(columns)) if sweep % 2 == 0 else reversed(range(len(columns)))
        for c in order:
            some = list(columns[c])
            wanted, weights = [], []
            for i in some:
                near = before[i] + after[i]
                pull = [STIFFNESS if min(i, j) >= nodes else 1.0 for j in near]
                wanted.append(np.average(y[near], weights=pull) if near else y[i])
                weights.append(1.0 + sum(pull))
            y[some] = isotonic_regression(np.array(wanted) - offsets[c], weights=weights).x + offsets[c]
    return y
