"""Maps of grids: regions, obstacles, start, and the path of a plan with the cells where it satisfies its tasks."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import cycle
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Rectangle

from experiments.figures.figures import drawing, inline_svg
from experiments.figures.trail import Cell, Trail, trail
from prefplan.front import Plan
from prefplan.models.grid import Box, GridModel

AREAS = ("#77aadd", "#ee8866", "#eedd88", "#ffaabb", "#99ddff", "#44bb99", "#bbcc33", "#aaaa00", "#dddddd")
"""Colours of regions, in turn: `light` of P. Tol, "Colour Schemes", SRON technical note, 2021."""

PATH, GOOD, START = "#222255", "#228833", "#bb5566"
"""Colours of the path, of satisfied tasks and of the start; people who see few colours can tell them apart."""

PANEL = 3.1
"""Width of a panel with a map, inches."""

SIDE = 4.5
"""Longer side of a map that stands alone, inches."""

LETTER = 0.063
"""Width of a letter in a region's name, inches."""

CLEAR = 1.2
"""Sufficient distance of a region's name from a path, cells."""

MOST_CELLS = 2_500
"""Most cells of a grid that is drawn with its cells, which are too small to see in larger ones."""

SHEET = {"boxstyle": "round,pad=0.12", "facecolor": "white", "alpha": 0.65, "linewidth": 0}
"""Background of text on a map."""


def svg(model: GridModel, plan: Plan) -> str:
    """Return a map with the path of a plan as inline SVG; the grid fills it.

    Its parts have the classes `ground`, `grid`, `region`, `obstacle`, `path`, `arrow`, `name`, `start`, `goal`, `task`.
    """
    cell = SIDE / max(model.size)
    with drawing(size=(cell * model.size[0], cell * model.size[1])) as figure:
        draw_map(figure.add_axes((0, 0, 1, 1)), model, plan)
        return inline_svg(figure, kind="map", title=f"Map with the path of a plan of {len(plan.actions)} moves")


def draw_map(axes: Axes, model: GridModel, plan: Plan) -> None:
    """Draw regions, obstacles, the path with its direction, the start and where tasks are satisfied."""
    width, height = model.size
    axes.set_aspect("equal")
    axes.set_xlim(-0.5, width - 0.5)
    axes.set_ylim(-0.5, height - 0.5)
    axes.grid(False)
    axes.patch.set_gid("ground")
    axes.spines[:].set_visible(True)
    axes.set(xticks=[], yticks=[])
    if width * height <= MOST_CELLS:
        axes.vlines(np.arange(0.5, width - 1), -0.5, height - 0.5, "#dddddd", linewidth=0.4, zorder=1, gid="grid")
        axes.hlines(np.arange(0.5, height - 1), -0.5, width - 0.5, "#dddddd", linewidth=0.4, zorder=1, gid="grid")
    for colour, boxes in zip(cycle(AREAS), model.regions.values(), strict=False):
        _draw_area(axes, boxes, color=colour, alpha=0.75, gid="region")
    for boxes in model.obstacles.values():
        _draw_area(axes, boxes, color="#555555", gid="obstacle")
    path, mark = path_of(plan), min(0.3, 0.012 * max(width, height))
    _draw_path(axes, path, mark)
    for name, boxes in model.regions.items():
        x, y = name_place(name, boxes, plan, letter=LETTER / PANEL * width)
        # In the corner of its cell, as the path goes through the middle.
        text = axes.annotate(name, (x - 0.5, y + 0.5), (3, -2.5), textcoords="offset points", fontsize=7.5, va="top")
        text.set(bbox=SHEET, zorder=4, gid="name")
    dot = {"edgecolor": "white", "linewidth": 0.6, "zorder": 5}
    axes.add_patch(Circle(model.start, 1.2 * mark, facecolor=START, gid="start", **dot))
    for step, tasks in goals(model, plan).items():
        axes.add_patch(Circle(tuple(path.states[step]), mark, facecolor=GOOD, gid="goal", **dot))
        text = axes.annotate(
            ", ".join(tasks), path.states[step], (0, 6.5), textcoords="offset points", ha="center", fontsize=7.5
        )
        text.set(color=GOOD, weight="bold", bbox=SHEET, zorder=6, gid="task")


def _draw_area(axes: Axes, boxes: Sequence[Box], **style: Any) -> None:
    for x0, y0, x1, y1 in boxes:
        axes.add_patch(Rectangle((x0 - 0.5, y0 - 0.5), x1 - x0 + 1, y1 - y0 + 1, linewidth=0, zorder=1.5, **style))


def _draw_path(axes: Axes, path: Trail, size: float) -> None:
    axes.plot(*path.line.T, color=PATH, linewidth=1.1, solid_joinstyle="round", zorder=3, gid="path")
    for x, y, dx, dy in path.arrows:
        ahead, aside = size * np.array([dx, dy]), 0.7 * size * np.array([-dy, dx])
        middle = np.array([x, y])
        corners = [middle + ahead, middle - 0.8 * ahead + aside, middle - 0.8 * ahead - aside]
        axes.add_patch(Polygon(corners, closed=True, facecolor=PATH, linewidth=0, zorder=3, gid="arrow"))


def goals(model: GridModel, plan: Plan) -> dict[int, list[str]]:
    """Return the tasks that a plan satisfies, by the number of actions taken until then.

    Every move costs the same, so that the number follows from the cost of the task; free moves give no tasks.
    """
    dropped = {bought.task for bought in plan.relaxations if bought.assume is None}
    found: dict[int, list[str]] = defaultdict(list)
    for task, cost in plan.task_costs.items():
        if task not in dropped and model.cost:
            found[round(float(cost) / float(model.cost))].append(task)
    return dict(found)


def path_of(plan: Plan) -> Trail:
    """Return the path of a plan on a grid."""
    return trail(cast(Sequence[Cell], plan.states))


def name_place(name: str, boxes: Sequence[Box], plan: Plan, *, letter: float) -> np.ndarray:
    """Return the cell where a region's name begins: high up in its largest box and away from the path.

    Args:
        name: the region's.
        boxes: it consists of.
        plan: whose path is drawn too.
        letter: width of a letter, in cells.
    """
    x0, y0, x1, y1 = max(boxes, key=lambda box: (box[2] - box[0] + 1) * (box[3] - box[1] + 1))
    columns = [x for x in range(x0, x1 + 1) if x == x0 or x + len(name) * letter <= x1 + 1]
    cells = np.array([(x, y) for y in range(y1, y0 - 1, -1) for x in columns], dtype=float)
    path = path_of(plan).states
    apart = [
        np.linalg.norm(cells[:, None] + [share * len(name) * letter - 0.5, 0] - path[None], axis=2).min(axis=1)
        for share in (0.1, 0.5, 0.9)
    ]
    return cells[int(np.argmax(np.min(apart, axis=0).clip(max=CLEAR)))]
