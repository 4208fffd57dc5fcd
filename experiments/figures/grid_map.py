"""Maps of grids: regions, obstacles, start, and the path of a plan with the cells where it satisfies its tasks."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import cast
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from experiments.figures.palette import GOOD, PATH, START, areas
from experiments.figures.trail import Trail, trail
from prefplan.front import Plan
from prefplan.models.grid import Box, GridModel

SIDE = 480.0
"""Longer side of a map in SVG, px; less for a small grid."""

LARGEST_CELL = 64.0
"""Greatest side of a cell, px."""

MARK = (3.5, 6.5)
"""Least and greatest radius of marks, px."""

LETTER = 7.0
"""Width of a letter, px."""

CLEAR = 1.2
"""Sufficient distance of a region's name from a path, cells."""

MOST_CELLS = 2_500
"""Most cells of a grid that is drawn with its cells, which are too small to see in larger ones."""

FONT = "system-ui, 'DejaVu Sans', sans-serif"


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


def svg(model: GridModel, plan: Plan | None = None, *, prefix: str = "") -> str:
    """Return a map as inline SVG.

    Args:
        model: the grid.
        plan: a plan whose path to draw.
        prefix: put before every id.

    Returns:
        The SVG. Cell (x, y) is the element `c<x>-<y>` of the class `cell` unless there are too many of them; a
        region is a group `region-<name>` of the class `region`, and the classes `obstacle`, `start`, `path`, `arrow`
        and `goal` are what they say. The path's group `path` has the attribute `data-states`: a point `x,y` for
        every state of the plan.
    """
    width, height = model.size
    cell = _cell(model)
    mark = _mark(model)
    colours = areas(model.regions)
    shown = "Map" if plan is None else f"Map with the path of a plan of {len(plan.actions)} moves"
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="-1 -1 {cell * width + 2:g} {cell * height + 2:g}" '
        f'width="{cell * width + 2:g}" height="{cell * height + 2:g}" role="img" aria-label="{shown}" class="map" '
        f'font-family="{FONT}" font-size="12" text-anchor="middle">',
        f'<rect class="ground" width="{cell * width:g}" height="{cell * height:g}" fill="#fff" stroke="#888"/>',
    ]
    for name, boxes in model.regions.items():
        rects = "".join(_rect(model, box, f'fill="{colours[name]}" fill-opacity="0.75"') for box in boxes)
        region = f'id={quoteattr(f"{prefix}region-{name}")} class="region"'
        lines.append(f"<g {region}><title>{escape(name)}</title>{rects}</g>")
    for name, boxes in model.obstacles.items():
        rects = "".join(_rect(model, box, 'fill="#555"') for box in boxes)
        lines.append(f'<g class="obstacle"><title>{escape(name)}</title>{rects}</g>')
    if width * height <= MOST_CELLS:
        lines.append('<g class="cells" fill="none" stroke="#000" stroke-opacity="0.12" pointer-events="all">')
        for row in range(height):
            for column in range(width):
                extra = f'id={quoteattr(f"{prefix}c{column}-{row}")} class="cell"'
                lines.append(_rect(model, (column, row, column, row), extra))
        lines.append("</g>")
    if plan is not None:
        lines += _path_svg(model, plan, prefix)
    lines.append(
        '<g class="names" fill="#111" stroke="#fff" stroke-width="2.5" stroke-opacity="0.6" '
        'paint-order="stroke" text-anchor="start" pointer-events="none">'
    )
    for name, boxes in model.regions.items():
        x, y = _svg_point(model, name_place(name, boxes, plan, letter=LETTER / cell) + [-0.5, 0.5])
        lines.append(f'<text x="{x + 4:.1f}" y="{y + 14:.1f}">{escape(name)}</text>')
    lines.append("</g>")
    if plan is not None:
        lines += _goals_svg(model, plan, mark)
    x, y = _svg_point(model, np.array(model.start, dtype=float))
    lines.append(
        f'<circle class="start" cx="{x:.1f}" cy="{y:.1f}" r="{1.2 * mark:.1f}" fill="{START}" stroke="#fff">'
        "<title>start</title></circle>"
    )
    return "\n".join([*lines, "</svg>"])


def _path_svg(model: GridModel, plan: Plan, prefix: str) -> list[str]:
    path = path_of(plan)
    points, states = _points(model, path.line), _points(model, path.states)
    lines = [
        f'<g id={quoteattr(prefix + "path")} class="path" data-states="{states}" pointer-events="none">',
        f'<polyline points="{points}" fill="none" stroke="{PATH}" stroke-width="2" stroke-linejoin="round"/>',
    ]
    for x, y, dx, dy in path.arrows:
        ahead, aside = np.array([dx, dy]), np.array([-dy, dx])
        size = _mark(model) / _cell(model)
        tip, foot = np.array([x, y]) + size * ahead, np.array([x, y]) - 0.8 * size * ahead
        corners = [tip, foot + 0.7 * size * aside, foot - 0.7 * size * aside]
        lines.append(f'<polygon class="arrow" points="{_points(model, np.array(corners))}" fill="{PATH}"/>')
    return [*lines, "</g>"]


def _goals_svg(model: GridModel, plan: Plan, mark: float) -> list[str]:
    lines, states = [], path_of(plan).states
    for step, tasks in goals(model, plan).items():
        x, y = _svg_point(model, states[step])
        names = escape(", ".join(tasks))
        lines.append(
            f'<g class="goal" pointer-events="none"><title>{names} satisfied</title>'
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{mark:.1f}" fill="{GOOD}" stroke="#fff"/>'
            f'<text x="{x:.1f}" y="{y - 1.5 * mark:.1f}" font-weight="bold" fill="{GOOD}" stroke="#fff" '
            f'stroke-width="3" paint-order="stroke">{names}</text></g>'
        )
    return lines


def path_of(plan: Plan) -> Trail:
    """Return the path of a plan on a grid."""
    return trail(cast(Sequence[tuple[int, int]], plan.states))


def name_place(name: str, boxes: Sequence[Box], plan: Plan | None, *, letter: float) -> np.ndarray:
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
    if plan is None:
        return cells[0]
    path = path_of(plan).states
    apart = [
        np.linalg.norm(cells[:, None] + [share * len(name) * letter - 0.5, 0] - path[None], axis=2).min(axis=1)
        for share in (0.1, 0.5, 0.9)
    ]
    return cells[int(np.argmax(np.min(apart, axis=0).clip(max=CLEAR)))]


def _cell(model: GridModel) -> float:
    return min(LARGEST_CELL, SIDE / max(model.size))


def _mark(model: GridModel) -> float:
    return float(np.clip(0.22 * _cell(model), *MARK))


def _rect(model: GridModel, box: Box, extra: str) -> str:
    x0, y0, x1, y1 = box
    cell = _cell(model)
    corner = f'x="{cell * x0:g}" y="{cell * (model.size[1] - 1 - y1):g}"'
    return f'<rect {corner} width="{cell * (x1 - x0 + 1):g}" height="{cell * (y1 - y0 + 1):g}" {extra}/>'


def _svg_point(model: GridModel, point: np.ndarray) -> tuple[float, float]:
    cell = _cell(model)
    return cell * (point[0] + 0.5), cell * (model.size[1] - 0.5 - point[1])


def _points(model: GridModel, points: np.ndarray) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in (_svg_point(model, point) for point in points))
