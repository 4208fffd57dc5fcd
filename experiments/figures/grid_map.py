"""Maps of grids: regions, obstacles, start, and the path of a plan with the cells where it satisfies its tasks."""

from collections.abc import Sequence
from itertools import cycle
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from experiments.figures.plan_map import AREAS, Named, PlanMap
from experiments.figures.trail import Trail, trail
from prefplan import GridModel, Plan, Problem
from prefplan.models.grid import Cell, GridBox

GROUNDS = ("#efe6d3", "#dcdfe6", "#f3f0ea", "#e3ead8")
"""Colours of terrains, used in turn: pale, so that regions on them stand out."""

MOST_CELLS = 2_500
"""Greatest number of cells of a grid whose cell borders are drawn: in larger grids they are too small to see."""


class GridMap(PlanMap):
    """The map of a grid; its unit is a cell."""

    path_width = 1.1

    def __init__(self, problem: Problem, model: GridModel) -> None:
        """Make the map of the grid model of a problem."""
        self.problem, self.model = problem, model
        self.size = model.size
        self.mark, self.named = min(0.3, 0.012 * max(model.size)), []
        areas = [(name, "name", boxes) for name, boxes in model.regions.items()]
        areas += [(name, "terrain", ground.boxes) for name, ground in model.terrain.items()]
        for name, kind, boxes in areas:
            largest = max(map(_rectangle, boxes), key=lambda box: np.prod(box[2:] - box[:2]))
            self.named.append(Named(name, kind, largest, True))
        self.unnamed = [_rectangle(box) for boxes in model.obstacles.values() for box in boxes]

    def trail(self, plan: Plan) -> Trail:
        """Return the path of a plan; where it returns to a cell, its points lie beside the centre."""
        return trail(cast(Sequence[Cell], plan.states))

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


def _rectangle(box: GridBox) -> np.ndarray:
    return np.array(box) + [-0.5, -0.5, 0.5, 0.5]


def _draw_area(axes: Axes, boxes: Sequence[GridBox], **style: Any) -> None:
    for left, low, right, high in map(_rectangle, boxes):
        axes.add_patch(Rectangle((left, low), right - left, high - low, linewidth=0, zorder=1.5, **style))
