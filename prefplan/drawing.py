"""Pictures of plans for notebooks: on the map of a grid, or as a timeline along the cost spent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import accumulate, cycle, groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from prefplan.exact_costs import Number
from prefplan.text.layout import number

if TYPE_CHECKING:
    # Loaded only when something is drawn.
    from matplotlib.axes import Axes

    from prefplan.models.grid import GridModel

Cell = tuple[int, int]
"""x y."""

PATH, OBSTACLE, GROUND, BORDER = "#0072b2", "#555b66", "#efe6d3", "#dfe3e8"
"""Colours of a plan's own path or progress, and of a map."""

AREAS = ("#9ecae1", "#fdd0a2", "#a8dba8", "#d4c5e8", "#f7b6c2", "#e6df9c", "#a9dfdb", "#d9c4a9")
"""Pale colours of regions and kinds of actions, used in turn."""

MOST_LINED = 60
"""Most cells of a side whose borders are drawn."""

ARROW_CELLS = 3
"""Cells per arrow on the path."""

BLOCK_ROWS = 6.5
"""Height of the actions in a timeline, in rows of tasks."""

NARROWEST = 0.025
"""Least share of a plan's cost of an action whose text fits into its block."""


def draw_map(axes: Axes, grid: GridModel, states: Sequence[Cell], done: Mapping[str, int]) -> None:
    """Draw a plan on the map of its grid.

    Args:
        axes: where to draw, in cells.
        grid: the grid.
        states: (K + 1,) the cells of the plan.
        done: by name of each task that the plan satisfies, after how many actions.
    """
    _draw_ground(axes, grid)
    axes.plot(*zip(*states, strict=True), color=PATH, linewidth=2)
    x, y = np.array(states)[:-1:ARROW_CELLS].T
    dx, dy = np.diff(states, axis=0)[::ARROW_CELLS].T
    # On the right of the path, where arrows of a way back do not meet them.
    heads: dict[str, Any] = {"headwidth": 5, "headlength": 5, "headaxislength": 5, "minshaft": 1, "width": 0.006}
    middle = x + 0.5 * dx + 0.1 * dy, y + 0.5 * dy - 0.1 * dx
    axes.quiver(*middle, dx, dy, color=PATH, pivot="mid", angles="xy", scale=2.5, scale_units="xy", **heads)
    axes.plot(*states[0], "o", color=PATH, markerfacecolor="white")
    bold: dict[str, Any] = {"weight": "bold", "color": PATH, "parse_math": False}
    for step in dict.fromkeys(done.values()):
        names = ", ".join(task for task, end in done.items() if end == step)
        axes.plot(*states[step], "o", color=PATH, markeredgecolor="white")
        axes.annotate(names, states[step], xytext=(6, -12), textcoords="offset points", **bold)


def _draw_ground(axes: Axes, grid: GridModel) -> None:
    """Draw terrain, regions with their names, obstacles and the borders of the cells."""
    from matplotlib.patches import Rectangle

    width, height = grid.size
    axes.set(aspect="equal", xlim=(-0.5, width - 0.5), ylim=(-0.5, height - 0.5), xticks=[], yticks=[])
    areas = [(GROUND, name, terrain.boxes) for name, terrain in grid.terrain.items()]
    areas += [(colour, *each) for colour, each in zip(cycle(AREAS), grid.regions.items(), strict=False)]
    areas += [(OBSTACLE, *each) for each in grid.obstacles.items()]
    for colour, name, boxes in areas:
        for x0, y0, x1, y1 in boxes:
            axes.add_patch(Rectangle((x0 - 0.5, y0 - 0.5), x1 - x0 + 1, y1 - y0 + 1, facecolor=colour, gid=name))
    if max(grid.size) <= MOST_LINED:
        axes.vlines([x + 0.5 for x in range(width)], -0.5, height - 0.5, BORDER, linewidth=0.6)
        axes.hlines([y + 0.5 for y in range(height)], -0.5, width - 0.5, BORDER, linewidth=0.6)
    for name, boxes in grid.regions.items():
        # In the corner, as paths lead through the centres of cells.
        left, _, _, top = max(boxes, key=lambda box: (box[2] - box[0] + 1) * (box[3] - box[1] + 1))
        axes.text(left - 0.45, top + 0.45, name, verticalalignment="top", parse_math=False)


def draw_timeline(
    axes: Axes, actions: Sequence[str], costs: Sequence[Number], tasks: Mapping[str, Number | None], *, cost: str
) -> None:
    """Draw a plan along its cost: a block for each run of equal actions, and when each task is satisfied.

    Args:
        axes: where to draw; its x axis is the cost.
        actions: (K,) in order.
        costs: (K,) cost of each.
        tasks: cost at which each task is satisfied, by name; None if it never is.
        cost: name of the cost.
    """
    totals = [*accumulate(map(float, costs), initial=0.0)]
    kinds = [action.partition(" ")[0] for action in actions]
    colours = dict(zip(dict.fromkeys(kinds), cycle(AREAS), strict=False))
    last = 0
    for action, run in groupby(actions):
        first, last = last, last + len(list(run))
        words = action if last == first + 1 else f"{last - first} x {action}"
        left, width = totals[first], totals[last] - totals[first]
        axes.bar(left, BLOCK_ROWS, width, align="edge", color=colours[kinds[first]], edgecolor="white", gid=words)
        if width > NARROWEST * totals[-1]:
            middle: dict[str, Any] = {"horizontalalignment": "center", "rotation": "vertical", "parse_math": False}
            axes.text(left + width / 2, 0.2, words, clip_on=True, **middle)
    for row, end in enumerate(tasks.values()):
        right = totals[-1] if end is None else float(end)
        axes.hlines(-row - 1, 0, right, PATH, alpha=0.35, linewidth=4, linestyles="dotted" if end is None else "solid")
        if end is not None:
            axes.plot(right, -row - 1, "o", color=PATH)
        note = "not satisfied" if end is None else number(end)
        axes.annotate(note, (right, -row - 1), xytext=(8, -4), textcoords="offset points")
    axes.set(ylim=(-len(tasks) - 0.7, BLOCK_ROWS), xlabel=cost)
    axes.set_yticks([-row - 1 for row in range(len(tasks))], list(tasks), parse_math=False)
    axes.spines[["left", "top", "right"]].set_visible(False)
