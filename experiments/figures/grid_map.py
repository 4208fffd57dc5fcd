"""Maps of grids: regions, obstacles, start, and the path of a plan with the cells where it satisfies its tasks."""

from __future__ import annotations

import textwrap
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate, cycle
from typing import Any, NamedTuple, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Rectangle
from matplotlib.text import Text

from experiments.figures.label_placement import Label, Obstacles, gap, leader, place
from experiments.figures.trail import Cell, Trail, trail
from prefplan.exact_costs import exact
from prefplan.front import Plan
from prefplan.models.grid import Box, GridModel

AREAS = ("#77aadd", "#ee8866", "#eedd88", "#ffaabb", "#99ddff", "#44bb99", "#bbcc33", "#aaaa00", "#dddddd")
"""Colours of regions, in turn: `light` of P. Tol, "Colour Schemes", SRON technical note, 2021."""

GROUNDS = ("#efe6d3", "#dcdfe6", "#f3f0ea", "#e3ead8")
"""Colours of terrains, in turn: pale, so that regions on them stand out."""

PATH, GOOD, START_COLOR = "#222255", "#117733", "#bb5566"
"""Colours of the path, of satisfied tasks and of the start; people who see few colours can tell them apart."""

PANEL = 3.1
"""Width of a panel with a map, inches."""

SMALL_FONT_SIZE = 7.5
"""Size of text on a map in a panel, points."""

MOST_LETTERS = 20
"""Most letters in a line of tasks' names."""

LEADER = 0.7
"""Distance from which on a line leads from a label to what it names, heights of a line."""

MOST_CELLS = 2_500
"""Most cells of a grid that is drawn with its cells, which are too small to see in larger ones."""

POINTS = 72
"""Points in an inch."""

PAD = 2.0
"""Empty border of a label, px."""

START_SIZE = 1.2
"""Size of the start, marks of a satisfied task."""

MOST_SAMPLES = 300
"""Most points of a path that labels keep clear of, without those between them."""

THIN: dict[str, Any] = {"color": "#555555", "linewidth": 0.7}
"""A leader."""

SHEET = {"boxstyle": "round,pad=0.12", "facecolor": "white", "alpha": 0.8, "linewidth": 0}
"""Background of text on a map."""


@dataclass(frozen=True)
class GridMap:
    """The map of a grid, see `experiments.figures.maps.PlanMap`."""

    model: GridModel

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, cells."""
        return self.model.size

    def draw(self, axes: Axes, plan: Plan) -> None:
        """Draw the map with a plan, without text."""
        draw_map(axes, self.model, plan)

    def label(self, axes: Axes, plan: Plan, *, font_size: float = SMALL_FONT_SIZE) -> None:
        """Write names on the map."""
        label_map(axes, self.model, plan, font_size=font_size)

    def path(self, plan: Plan) -> np.ndarray:
        """Return the (S, 2) points of a plan's states."""
        return path_of(plan).states


def draw_map(axes: Axes, model: GridModel, plan: Plan) -> None:
    """Draw regions, obstacles, the path with its direction, the start and where tasks are satisfied, without text."""
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
    for colour, terrain in zip(cycle(GROUNDS), model.terrain.values(), strict=False):
        _draw_area(axes, terrain.boxes, color=colour, gid="terrain")
    for colour, boxes in zip(cycle(AREAS), model.regions.values(), strict=False):
        _draw_area(axes, boxes, color=colour, alpha=0.75, gid="region")
    for boxes in model.obstacles.values():
        _draw_area(axes, boxes, color="#555555", gid="obstacle")
    path, mark = path_of(plan), mark_size(model)
    _draw_path(axes, path, mark)
    dot = {"edgecolor": "white", "linewidth": 0.6, "zorder": 5}
    axes.add_patch(Circle(model.start, START_SIZE * mark, facecolor=START_COLOR, gid="start", **dot))
    for step in goals(model, plan):
        axes.add_patch(Circle(tuple(path.states[step]), mark, facecolor=GOOD, gid="goal", **dot))


def label_map(axes: Axes, model: GridModel, plan: Plan, *, font_size: float = SMALL_FONT_SIZE) -> None:
    """Write the names of regions and of satisfied tasks on a map whose axes have their final place.

    No label overlaps another one or leaves the map; one for which no space is left is not written.
    """
    path, mark = path_of(plan), mark_size(model)
    named = [Named(name, "name", _rectangle(max(boxes, key=_area)), True) for name, boxes in model.regions.items()]
    for name, ground in model.terrain.items():
        named.append(Named(name, "terrain", _rectangle(max(ground.boxes, key=_area)), True))
    for step, tasks in goals(model, plan).items():
        named.append(Named(task_lines(tasks), "task", square(path.states[step], mark), False))
    dots = [square(model.start, START_SIZE * mark), *(one.target for one in named if one.kind == "task")]
    write_names(axes, named, dots=dots, path=_sampled(path), font_size=font_size)


class Named(NamedTuple):
    """Text on a map: of the kind `name`, `terrain` or `task`, for a (4,) rectangle, in which it may lie or not."""

    text: str
    kind: str
    target: np.ndarray
    inside: bool


def task_lines(tasks: Sequence[str]) -> str:
    """Return the names of tasks, some on each line."""
    return textwrap.fill(", ".join(tasks), MOST_LETTERS, break_long_words=False)


def write_names(
    axes: Axes, named: Sequence[Named], *, dots: Sequence[np.ndarray], path: np.ndarray, font_size: float
) -> None:
    """Write names on a map whose axes have their final place, where there is space.

    Args:
        axes: of the map.
        named: the names.
        dots: (4,) rectangles that names should not cover.
        path: (P, 2) points that they should not cover.
        font_size: of the text, points.
    """
    to_pixels = axes.transData.transform
    texts = [_write(axes, one.text, one.kind, font_size) for one in named]
    extents = [text.get_window_extent() for text in texts]
    targets = [to_pixels(one.target.reshape(2, 2)).ravel() for one in named]
    labels = [
        Label((extent.width + 2 * PAD, extent.height + 2 * PAD), target, one.inside)
        for extent, target, one in zip(extents, targets, named, strict=True)
    ]
    areas = [target for target, one in zip(targets, named, strict=True) if one.inside and one.kind == "name"]
    obstacles = Obstacles(
        to_pixels(path),
        np.array([to_pixels(dot.reshape(2, 2)).ravel() for dot in dots]),
        np.array(areas).reshape(-1, 4),
    )
    frame = np.array(axes.get_window_extent().extents) + [1, 1, -1, -1]
    line = font_size * axes.figure.dpi / POINTS
    for text, rectangle, target in zip(texts, place(labels, frame, obstacles, line=line), targets, strict=True):
        if rectangle is None:
            text.remove()
            continue
        text.set_position(tuple(axes.transData.inverted().transform(rectangle[:2] + PAD)))
        if gap(rectangle[None], target)[0] > LEADER * line:
            axes.plot(
                *axes.transData.inverted().transform(leader(rectangle, target)).T, zorder=3.5, gid="leader", **THIN
            )


def _write(axes: Axes, text: str, kind: str, font_size: float) -> Text:
    style: dict[str, Any] = {"color": GOOD, "weight": "bold", "zorder": 6} if kind == "task" else {"zorder": 4}
    if kind == "terrain":
        kind, style["style"] = "name", "italic"
    found = axes.text(0, 0, text, fontsize=font_size, va="bottom", bbox=SHEET, gid=kind, parse_math=False, **style)
    found.set_in_layout(False)
    return found


def _rectangle(box: Box) -> np.ndarray:
    return np.array(box) + [-0.5, -0.5, 0.5, 0.5]


def square(middle: Sequence[float] | np.ndarray, radius: float) -> np.ndarray:
    """Return the (4,) rectangle around a mark."""
    return np.array([*middle, *middle]) + radius * np.array([-1, -1, 1, 1])


def _area(box: Box) -> int:
    return (box[2] - box[0] + 1) * (box[3] - box[1] + 1)


def _sampled(path: Trail) -> np.ndarray:
    """Return up to some hundred points along a path, between its states too."""
    line = path.states[:: max(1, len(path.states) // MOST_SAMPLES)]
    return np.concatenate([line, (line[1:] + line[:-1]) / 2])


def mark_size(model: GridModel) -> float:
    """Return the radius of a mark, cells."""
    return min(0.3, 0.012 * max(model.size))


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

    The number follows from the cost of the task; free moves give no tasks.
    """
    path = cast(Sequence[Cell], plan.states[1:])
    spent = list(accumulate((exact(model.cost_of_entering(cell)) for cell in path), initial=Fraction(0)))
    dropped = {bought.task for bought in plan.relaxations if bought.assume is None}
    found: dict[int, list[str]] = defaultdict(list)
    for task, cost in plan.task_costs.items():
        if task not in dropped and spent[-1]:
            found[bisect_left(spent, exact(cost))].append(task)
    return dict(found)


def path_of(plan: Plan) -> Trail:
    """Return the path of a plan on a grid."""
    return trail(cast(Sequence[Cell], plan.states))
