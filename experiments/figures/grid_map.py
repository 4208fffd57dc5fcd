"""Maps of grids: regions, obstacles, start, and the path of a plan with the cells where it satisfies its tasks."""

from __future__ import annotations

import textwrap
from collections import defaultdict
from collections.abc import Sequence
from itertools import cycle
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Rectangle
from matplotlib.text import Text

from experiments.figures.figures import drawing, inline_svg
from experiments.figures.label_placement import Label, Obstacles, gap, leader, place
from experiments.figures.trail import Cell, Trail, trail
from prefplan.front import Plan
from prefplan.models.grid import Box, GridModel

AREAS = ("#77aadd", "#ee8866", "#eedd88", "#ffaabb", "#99ddff", "#44bb99", "#bbcc33", "#aaaa00", "#dddddd")
"""Colours of regions, in turn: `light` of P. Tol, "Colour Schemes", SRON technical note, 2021."""

PATH, GOOD, START_COLOR = "#222255", "#117733", "#bb5566"
"""Colours of the path, of satisfied tasks and of the start; people who see few colours can tell them apart."""

PANEL = 3.1
"""Width of a panel with a map, inches."""

SIDE = 4.5
"""Longer side of a map that stands alone, inches."""

FONT_SIZE, SMALL_FONT_SIZE = 9.0, 7.5
"""Size of text on a map that stands alone and in a panel, points."""

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


def svg(model: GridModel, plan: Plan) -> str:
    """Return a map with the path of a plan as inline SVG; the grid fills it.

    Its parts have the classes `ground`, `grid`, `region`, `obstacle`, `path`, `arrow`, `name`, `start`, `goal`, `task`,
    `leader`.
    """
    cell = SIDE / max(model.size)
    with drawing(size=(cell * model.size[0], cell * model.size[1])) as figure:
        axes = figure.add_axes((0, 0, 1, 1))
        draw_map(axes, model, plan)
        figure.draw_without_rendering()
        label_map(axes, model, plan, font_size=FONT_SIZE)
        return inline_svg(figure, kind="map", title=f"Map with the path of a plan of {len(plan.actions)} moves")


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
    named = [(name, "name", _rectangle(max(boxes, key=_area))) for name, boxes in model.regions.items()]
    for step, tasks in goals(model, plan).items():
        lines = textwrap.fill(", ".join(tasks), MOST_LETTERS, break_long_words=False)
        named.append((lines, "task", _square(path.states[step], mark)))
    to_pixels = axes.transData.transform
    texts = [_write(axes, text, kind, font_size) for text, kind, _ in named]
    extents = [text.get_window_extent() for text in texts]
    targets = [to_pixels(target.reshape(2, 2)).ravel() for _, _, target in named]
    labels = [
        Label((extent.width + 2 * PAD, extent.height + 2 * PAD), target, kind == "name")
        for extent, target, (_, kind, _) in zip(extents, targets, named, strict=True)
    ]
    dots = [_square(model.start, START_SIZE * mark), *(target for _, kind, target in named if kind == "task")]
    obstacles = Obstacles(
        to_pixels(_sampled(path)),
        np.array([to_pixels(dot.reshape(2, 2)).ravel() for dot in dots]),
        np.array([target for target, (_, kind, _) in zip(targets, named, strict=True) if kind == "name"]).reshape(
            -1, 4
        ),
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
    style = {"color": GOOD, "weight": "bold", "zorder": 6} if kind == "task" else {"zorder": 4}
    found = axes.text(0, 0, text, fontsize=font_size, va="bottom", bbox=SHEET, gid=kind, parse_math=False, **style)
    found.set_in_layout(False)
    return found


def _rectangle(box: Box) -> np.ndarray:
    return np.array(box) + [-0.5, -0.5, 0.5, 0.5]


def _square(middle: Sequence[float], radius: float) -> np.ndarray:
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
