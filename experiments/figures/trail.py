"""A path through the cells of a grid as a line with arrows, whose parts lie beside each other where they overlap."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from prefplan.drawing.cell_map import Cell

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
    moves = [_move(a, b) for a, b in zip(cells, cells[1:], strict=False)]
    taken: dict[tuple[Cell, Cell], set[int]] = defaultdict(set)
    line: list[np.ndarray] = []
    arrows = []
    states = points.copy()
    first = 0
    for move, run in groupby(moves):
        last = first + len(list(run))
        steps = [tuple(sorted(pair)) for pair in zip(cells[first:last], cells[first + 1 : last + 1], strict=True)]
        lane = next((lane for lane in LANES if all(lane not in taken[step] for step in steps)), 0)  # type: ignore[index]
        for step in steps:
            taken[step].add(lane)  # type: ignore[index]
        aside = np.array([move[1], move[0]], dtype=float) ** 2 * lane * LANE
        begin, end = points[first] + aside, points[last] + aside
        if line and moves[first - 1][0] * move[0] + moves[first - 1][1] * move[1] == 0:
            # At a right angle both parts are shifted to their lanes, so that they meet.
            line[-1] = begin = line[-1] + aside
            states[first] = begin
        else:
            line.append(begin)
        line.append(end)
        states[first + 1 : last + 1] = points[first + 1 : last + 1] + aside
        count = max(1, round((last - first) / ARROWS))
        for i in range(count):
            middle = begin + (end - begin) * (i + 0.5) / count
            arrows.append([*middle, *move])
        first = last
    return Trail(states, np.array(line or points), np.array(arrows, dtype=float).reshape(-1, 4))


def _move(a: Cell, b: Cell) -> Cell:
    return b[0] - a[0], b[1] - a[1]
