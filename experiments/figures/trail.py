"""A path through the cells of a grid as a line with arrows; parts that overlap are drawn side by side."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from prefplan.models.grid import Cell

LANE = 0.15
"""Distance between adjacent lanes, in which overlapping parts of a path are drawn, cells."""

LANES = (0, 1, -1, 2, -2)
"""Lanes in the order in which they are tried; if none is free, lines overlap."""

ARROWS = 5
"""Cells per arrow on a straight part of the path."""


@dataclass(frozen=True)
class Trail:
    """A path in units of cells; the centre of cell (x, y) is the point (x, y).

    Attributes:
        states: (S, 2) a point for every state of the plan.
        line: (P, 2) corners of the path.
        arrows: (A, 4) points and unit directions of the arrows.
    """

    states: np.ndarray
    line: np.ndarray
    arrows: np.ndarray


def trail(cells: Sequence[Cell]) -> Trail:
    """Return the path through cells, each a neighbour of the one before."""
    points = np.array(cells, dtype=float)
    moves = np.diff(points, axis=0)
    corners = np.flatnonzero((moves[1:] != moves[:-1]).any(axis=1)) + 1
    taken: dict[frozenset[Cell], set[int]] = defaultdict(set)
    states, line, arrows = points.copy(), list[np.ndarray](), list[np.ndarray]()
    for first, last in pairwise([0, *corners, len(moves)] if len(moves) else []):
        move, steps = moves[first], [frozenset(pair) for pair in pairwise(cells[first : last + 1])]
        lane = next((lane for lane in LANES if all(lane not in taken[step] for step in steps)), 0)
        for step in steps:
            taken[step].add(lane)
        aside = abs(move[::-1]) * lane * LANE
        begin, end = points[first] + aside, points[last] + aside
        if line and moves[first - 1] @ move == 0:
            # At a right angle both parts are shifted to their lanes, so that they meet.
            line[-1] = states[first] = begin = line[-1] + aside
        else:
            line.append(begin)
        line.append(end)
        states[first + 1 : last + 1] = points[first + 1 : last + 1] + aside
        count = max(1, round((last - first) / ARROWS))
        arrows += [np.append(begin + (end - begin) * (i + 0.5) / count, move) for i in range(count)]
    return Trail(states, np.array(line or points), np.array(arrows).reshape(-1, 4))
