"""Every plan of a front on a grid as a panel of one figure: its path on the map."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Rectangle

from experiments.cli.output import number, relaxed
from experiments.figures.figures import drawing
from experiments.figures.front import draw_front
from experiments.figures.grid_map import MOST_CELLS, goals, name_place, path_of
from experiments.figures.palette import GOOD, PATH, START, areas
from prefplan.errors import PrefplanError
from prefplan.front import Front, Plan
from prefplan.models.grid import GridModel
from prefplan.scenario.decode import Scenario

MOST_PLANS = 23
"""Most plans in a figure; with the front it has two dozen panels."""

COLUMNS = 4

PANEL = 3.1
"""Width of a panel, inches."""

LETTER = 0.063
"""Width of a letter in a region's name, inches."""

SHEET = {"boxstyle": "round,pad=0.12", "facecolor": "white", "alpha": 0.65, "linewidth": 0}
"""Background of text on a map."""


def draw(scenario: Scenario, front: Front, path: Path) -> None:
    """Write a map for each plan of a front on a grid, and the front, like the paper's Figures 3 and 4.

    Raises:
        PrefplanError: the model is no grid, there are too many plans, or the file cannot be written.
    """
    model = scenario.model
    if not isinstance(model, GridModel):
        raise PrefplanError(f"{scenario.path}: model.kind: only the plans of a grid model can be drawn on a map")
    if len(front) > MOST_PLANS:
        raise PrefplanError(
            f"{scenario.path}: the front has {len(front)} plans, and up to {MOST_PLANS} can be drawn in one picture; "
            "--max-cost draws the cheaper ones"
        )
    columns = min(COLUMNS, math.ceil((len(front) + 1) / 2))
    rows = math.ceil((len(front) + 1) / columns)
    shape = min(1.6, max(0.6, model.size[1] / model.size[0]))
    most = max(len(plan.relaxations) for plan in front)
    with drawing(path, size=(columns * PANEL, rows * (PANEL * shape + 0.35 + 0.14 * most))) as figure:
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for i, (axes, plan) in enumerate(zip(panels, front, strict=False)):
            draw_map(axes, model, plan)
            axes.set_xlabel("\n".join(line.strip() for line in relaxed(plan)), fontsize=7.5)
            axes.set_title(f"{i}: cost {number(plan.cost)}, μ = {number(plan.preference)}")
        draw_front(panels[len(front)], scenario, front, brief=True)
        panels[len(front)].set_title("Pareto front")
        for axes in panels[len(front) + 1 :]:
            axes.set_axis_off()


def draw_map(axes: Axes, model: GridModel, plan: Plan) -> None:
    """Draw regions, obstacles, the path with its direction, the start and where tasks are satisfied."""
    width, height = model.size
    axes.set_aspect("equal")
    axes.set_xlim(-0.5, width - 0.5)
    axes.set_ylim(-0.5, height - 0.5)
    axes.grid(False)
    axes.spines[:].set_visible(True)
    axes.tick_params(length=0, labelbottom=False, labelleft=False)
    if width * height <= MOST_CELLS:
        for x in np.arange(0.5, width - 1):
            axes.axvline(x, color="#dddddd", linewidth=0.4, zorder=1)
        for y in np.arange(0.5, height - 1):
            axes.axhline(y, color="#dddddd", linewidth=0.4, zorder=1)
    colours = areas(model.regions)
    for kind, alpha in ((model.regions, 0.75), (model.obstacles, 1.0)):
        for name, boxes in kind.items():
            for x0, y0, x1, y1 in boxes:
                area = Rectangle((x0 - 0.5, y0 - 0.5), x1 - x0 + 1, y1 - y0 + 1, linewidth=0, zorder=1.5)
                area.set_facecolor(colours[name] if kind is model.regions else "#555555")
                area.set_alpha(alpha)
                axes.add_patch(area)
    cell = 1 / max(width, height)
    path = path_of(plan)
    axes.plot(*path.line.T, color=PATH, linewidth=1.1, solid_joinstyle="round", zorder=3)
    size = min(0.3, 0.012 / cell)
    for x, y, dx, dy in path.arrows:
        ahead, aside = size * np.array([dx, dy]), 0.7 * size * np.array([-dy, dx])
        middle = np.array([x, y])
        corners = [middle + ahead, middle - 0.8 * ahead + aside, middle - 0.8 * ahead - aside]
        axes.add_patch(Polygon(corners, closed=True, facecolor=PATH, linewidth=0, zorder=3))
    for name, boxes in model.regions.items():
        x, y = name_place(name, boxes, plan, letter=LETTER / PANEL * width)
        # In the corner of its cell, as the path goes through the middle.
        corner = (x - 0.5, y + 0.5)
        axes.annotate(name, corner, (3, -2.5), textcoords="offset points", fontsize=7.5, va="top", bbox=SHEET, zorder=4)
    axes.add_patch(Circle(model.start, 1.2 * size, facecolor=START, edgecolor="white", linewidth=0.6, zorder=5))
    for step, tasks in goals(model, plan).items():
        x, y = path.states[step]
        axes.add_patch(Circle((x, y), size, facecolor=GOOD, edgecolor="white", linewidth=0.6, zorder=5))
        label = axes.annotate(", ".join(tasks), (x, y), (0, 6.5), textcoords="offset points", ha="center", fontsize=7.5)
        label.set(color=GOOD, weight="bold", bbox=SHEET, zorder=6)
