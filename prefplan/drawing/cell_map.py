"""A plan on the map of its grid."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import cycle, groupby, pairwise
from typing import NamedTuple

from prefplan.drawing import svg

Cell = tuple[int, int]
"""x y."""

Boxes = Mapping[str, Sequence[tuple[int, int, int, int]]]
"""Boxes x0 y0 x1 y1 by name, corners inclusive, in cells."""

SIDE_PX = 420.0
"""Length of the longer side of a map, at most."""

CELL_PX = 72.0
"""Greatest length of a cell's side."""

MARGIN_PX, TITLE_PX, NAMES_PX = 8.0, 28.0, 130.0
"""Width of the margins, height of the title, and width for the names of tasks beside the last column."""

MOST_LINED = 60
"""Most cells of a side whose borders are drawn."""

ARROW_CELLS, LANE_CELLS = 5, 0.1
"""Cells per arrow on a straight part of the path, and the distance of arrows from it, cells."""

OBSTACLE, GROUND, BORDER = "#555b66", "#efe6d3", "#dfe3e8"


@dataclass(frozen=True)
class CellMap:
    """What a map of a grid shows.

    Attributes:
        size: (width, height) in cells.
        regions: boxes in which a proposition holds.
        obstacles: boxes that cannot be entered.
        terrain: boxes with a cost of their own.
    """

    size: tuple[int, int]
    regions: Boxes
    obstacles: Boxes
    terrain: Boxes


def map_picture(cells: CellMap, states: Sequence[Cell], done: Mapping[str, int], *, title: str) -> str:
    """Return a plan on its map as SVG.

    Args:
        cells: the map.
        states: (K + 1,) the cells of the plan.
        done: by name of each task that the plan satisfies, after how many actions.
        title: above the picture.
    """
    width, height = cells.size
    frame = _Frame(min(CELL_PX, SIDE_PX / max(width, height)), height)
    tasks: dict[int, list[str]] = {}
    for task, step in done.items():
        tasks.setdefault(step, []).append(task)
    parts = [*_ground(cells, frame), *_path(states, frame)]
    for step, names in tasks.items():
        x, y = frame.point(*states[step])
        parts.append(svg.element("circle", cx=x, cy=y, r=5, fill=svg.PATH, stroke=svg.PAPER, stroke_width=1.5))
        parts.append(svg.text(x + 6, y + 16, ", ".join(names), font_weight="bold", fill=svg.PATH))
    wide = max(frame.side * width + NAMES_PX, svg.LETTER_PX * 1.1 * len(title))
    return svg.picture(wide + 2 * MARGIN_PX, TITLE_PX + frame.side * height + MARGIN_PX, title, parts)


class _Frame(NamedTuple):
    """The length of a cell's side, px, and the number of rows."""

    side: float
    rows: int

    def point(self, x: float, y: float) -> tuple[float, float]:
        """Return the point of a cell's centre, px; y runs upwards on the map."""
        return MARGIN_PX + self.side * (x + 0.5), TITLE_PX + self.side * (self.rows - y - 0.5)

    def box(self, box: Sequence[int], name: str, **style: object) -> str:
        """Return a box of cells whose name is shown when it is pointed at."""
        x0, y0, x1, y1 = box
        x, y = self.point(x0 - 0.5, y1 + 0.5)
        size = {"width": self.side * (x1 - x0 + 1), "height": self.side * (y1 - y0 + 1)}
        return svg.element("rect", svg.element("title", escape(name)), x=x, y=y, **size, **style)


def _ground(cells: CellMap, frame: _Frame) -> Iterator[str]:
    """Yield terrain, regions with their names, obstacles and the borders of the cells."""
    width, height = cells.size
    yield from (frame.box(box, name, fill=GROUND) for name, boxes in cells.terrain.items() for box in boxes)
    for colour, (name, boxes) in zip(cycle(svg.AREAS), cells.regions.items(), strict=False):
        yield from (frame.box(box, name, fill=colour, fill_opacity=0.8) for box in boxes)
    yield from (frame.box(box, name, fill=OBSTACLE) for name, boxes in cells.obstacles.items() for box in boxes)
    lined = max(width, height) <= MOST_LINED
    lines = [f"M{x} 0V{height}" for x in range(0, width + 1, 1 if lined else width)]
    lines += [f"M0 {y}H{width}" for y in range(0, height + 1, 1 if lined else height)]
    place = f"translate({MARGIN_PX} {TITLE_PX}) scale({frame.side:.4f})"
    yield svg.element("path", d="".join(lines), transform=place, stroke=BORDER, stroke_width=0.6 / frame.side)
    for name, boxes in cells.regions.items():
        left, bottom, _, top = max(boxes, key=lambda box: (box[2] - box[0] + 1) * (box[3] - box[1] + 1))
        x, y = frame.point(left - 0.5, top + 0.5)
        # In the corner or above, as paths lead through the centres of cells.
        inside = frame.side * (top - bottom + 1) > 3 * svg.FONT_PX
        yield svg.text(x + 3, y + svg.FONT_PX if inside else y - 3, name)


def _path(states: Sequence[Cell], frame: _Frame) -> Iterator[str]:
    """Yield the path with arrows on its right, where those of a way back do not meet them, and the start as a ring."""
    corners, arrows = [states[0]], []
    for (dx, dy), run in groupby((b[0] - a[0], b[1] - a[1]) for a, b in pairwise(states)):
        (x, y), length = corners[-1], len(list(run))
        corners.append((x + length * dx, y + length * dy))
        count = max(1, round(length / ARROW_CELLS))
        middles = [length * (k + 0.5) / count for k in range(count)]
        arrows += [(x + m * dx + LANE_CELLS * dy, y + m * dy - LANE_CELLS * dx, dx, dy) for m in middles]
    line = svg.points(frame.point(x, y) for x, y in corners)
    yield svg.element("polyline", points=line, fill="none", stroke=svg.PATH, stroke_width=2)
    reach = min(5.0, max(2.5, 0.2 * frame.side))
    for right, up, dx, dy in arrows:
        px, py = frame.point(right, up)
        place = f"translate({px:.2f} {py:.2f}) rotate({math.degrees(math.atan2(-dy, dx)):.0f}) scale({reach:.2f})"
        yield svg.element("path", d="M1 0L-1 0.7V-0.7z", transform=place, fill=svg.PATH)
    px, py = frame.point(*states[0])
    yield svg.element("circle", cx=px, cy=py, r=5, fill=svg.PAPER, stroke=svg.PATH, stroke_width=2)
