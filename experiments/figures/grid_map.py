"""Maps of grids: regions, obstacles, start, and the path of a plan with the cells where it satisfies its tasks."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import cycle, groupby
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from experiments.figures.plan_map import AREAS, MOST_SAMPLES, Named, PlanMap
from prefplan.models.grid import Cell, GridBox, GridModel
from prefplan.plan import Plan
from prefplan.problem import Problem

GROUNDS = ("#efe6d3", "#dcdfe6", "#f3f0ea", "#e3ead8")
"""Colours of terrains, used in turn: pale, so that regions on them stand out."""

MOST_CELLS = 2_500
"""Greatest number of cells of a grid whose cell borders are drawn: in larger grids they are too small to see."""

LANE = 0.15
"""Distance between adjacent lanes, in which overlapping parts of a path are drawn, cells."""

LANES = (0, 1, -1, 2, -2)
"""Lanes in the order in which they are tried; if none is free, lines overlap."""

ARROWS = 5
"""Cells per arrow on a straight part of the path."""


class GridMap(PlanMap):
    """The map of a grid; its unit is a cell."""

    path_width = 1.1

    def __init__(self, problem: Problem, model: GridModel) -> None:
        """Make the map of the grid model of a problem."""
        self.problem, self.model = problem, model
        self.size = model.size
        self.mark = min(0.3, 0.012 * max(model.size))

    def path(self, plan: Plan) -> np.ndarray:
        """Return the (S, 2) points of a plan's states; where a plan returns to a cell, they lie beside its centre."""
        return _trail(plan).states

    def _start(self, plan: Plan) -> np.ndarray:
        return np.array(self.model.start)

    def _line(self, plan: Plan) -> tuple[np.ndarray, Iterable[np.ndarray]]:
        path = _trail(plan)
        arrows = []
        for x, y, dx, dy in path.arrows:
            ahead, aside = self.mark * np.array([dx, dy]), 0.7 * self.mark * np.array([-dy, dx])
            arrows.append(np.array([x, y]) + [ahead, -0.8 * ahead + aside, -0.8 * ahead - aside])
        return path.line, arrows

    def _draw_ground(self, axes: Axes) -> None:
        """Draw cells, terrains, regions and obstacles."""
        (width, height), model = self.size, self.model
        if width * height <= MOST_CELLS:
            axes.vlines(np.arange(0.5, width - 1), -0.5, height - 0.5, "#dddddd", linewidth=0.4, zorder=1, gid="grid")
            axes.hlines(np.arange(0.5, height - 1), -0.5, width - 0.5, "#dddddd", linewidth=0.4, zorder=1, gid="grid")
        for colour, terrain in zip(cycle(GROUNDS), model.terrain.values(), strict=False):
            _draw_area(axes, terrain.boxes, color=colour, gid="terrain")
        for colour, boxes in zip(cycle(AREAS), model.regions.values(), strict=False):
            _draw_area(axes, boxes, color=colour, alpha=0.75, gid="region")
        for boxes in model.obstacles.values():
            _draw_area(axes, boxes, color="#555555", gid="obstacle")

    def _names(self, reached: set[Any], goals: list[Named]) -> list[Named]:
        areas = [(name, "name", boxes) for name, boxes in self.model.regions.items()]
        areas += [(name, "terrain", ground.boxes) for name, ground in self.model.terrain.items()]
        return [*(Named(name, kind, _rectangle(max(boxes, key=_area)), True) for name, kind, boxes in areas), *goals]

    def _unnamed(self) -> list[np.ndarray]:
        return [_rectangle(box) for boxes in self.model.obstacles.values() for box in boxes]

    def _kept_clear(self, plan: Plan) -> np.ndarray:
        """Return about `MOST_SAMPLES` of the points of a path's states, and the midpoints between them."""
        states = self.path(plan)
        line = states[:: max(1, len(states) // MOST_SAMPLES)]
        return np.concatenate([line, (line[1:] + line[:-1]) / 2])


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


def _trail(plan: Plan) -> Trail:
    return trail(cast(Sequence[Cell], plan.states))


def _rectangle(box: GridBox) -> np.ndarray:
    return np.array(box) + [-0.5, -0.5, 0.5, 0.5]


def _area(box: GridBox) -> int:
    return (box[2] - box[0] + 1) * (box[3] - box[1] + 1)


def _draw_area(axes: Axes, boxes: Sequence[GridBox], **style: Any) -> None:
    for x0, y0, x1, y1 in boxes:
        axes.add_patch(Rectangle((x0 - 0.5, y0 - 0.5), x1 - x0 + 1, y1 - y0 + 1, linewidth=0, zorder=1.5, **style))


def _move(a: Cell, b: Cell) -> Cell:
    return b[0] - a[0], b[1] - a[1]
