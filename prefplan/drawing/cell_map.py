"""A plan on the map of its grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle

from prefplan.drawing import svg
from prefplan.drawing.trail import Cell, Trail, trail

Boxes = Mapping[str, Sequence[tuple[int, int, int, int]]]
"""Boxes x0 y0 x1 y1 by name, corners inclusive, in cells."""

SIDE_PX = 420.0
"""Length of the longer side of a map, at most."""

CELL_PX = 72.0
"""Greatest length of a cell's side."""

MARGIN_PX = 8.0
TITLE_PX = 28.0
NAMES_PX = 130.0
"""Width at the right for the names of tasks beside the last column."""

MOST_LINED = 60
"""Most cells of a side whose borders are drawn."""

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
    return _Drawing(cells, title).picture(trail(states), done)


class _Drawing:
    """The places of cells in a picture."""

    def __init__(self, cells: CellMap, title: str) -> None:
        self.cells, self.title = cells, title
        self.side = min(CELL_PX, SIDE_PX / max(cells.size))

    def picture(self, way: Trail, done: Mapping[str, int]) -> str:
        """Return the whole picture."""
        width, height = (self.side * length for length in self.cells.size)
        parts = [svg.text(MARGIN_PX, 18, self.title, font_weight="bold"), *self._ground(), *self._way(way)]
        tasks: dict[int, list[str]] = {}
        for task, step in done.items():
            tasks.setdefault(step, []).append(task)
        for step, names in tasks.items():
            x, y = self._point(*way.states[step])
            parts.append(svg.dot(x, y, 5, fill=svg.PATH, stroke=svg.PAPER, stroke_width=1.5))
            parts.append(svg.text(x + 6, y + 16, ", ".join(names), halo=True, font_weight="bold", fill=svg.PATH))
        wide = max(width + NAMES_PX, svg.LETTER_PX * 1.1 * len(self.title))
        return svg.picture(wide + 2 * MARGIN_PX, TITLE_PX + height + MARGIN_PX, parts)

    def _point(self, x: float, y: float) -> tuple[float, float]:
        """Return the point of a cell's centre; y runs upwards on the map."""
        return MARGIN_PX + self.side * (x + 0.5), TITLE_PX + self.side * (self.cells.size[1] - y - 0.5)

    def _box(self, box: Sequence[int], title: str, **style: object) -> str:
        x0, y0, x1, y1 = box
        x, y = self._point(x0 - 0.5, y1 + 0.5)
        return svg.rectangle(x, y, self.side * (x1 - x0 + 1), self.side * (y1 - y0 + 1), title=title, **style)

    def _ground(self) -> list[str]:
        """Return terrain, regions with their names, obstacles, and the borders of the cells."""
        (width, height), cells = self.cells.size, self.cells
        parts = [self._box(box, name, fill=GROUND) for name, boxes in cells.terrain.items() for box in boxes]
        named = []
        for colour, (name, boxes) in zip(cycle(svg.AREAS), cells.regions.items(), strict=False):
            parts += [self._box(box, name, fill=colour, fill_opacity=0.8) for box in boxes]
            left, bottom, _, top = max(boxes, key=lambda box: (box[2] - box[0] + 1) * (box[3] - box[1] + 1))
            x, y = self._point(left - 0.5, top + 0.5)
            # In the corner or above, as paths lead through the centres of cells.
            down = svg.FONT_PX if self.side * (top - bottom + 1) > 3 * svg.FONT_PX else -3
            named.append(svg.text(x + 3, y + down, name, halo=True))
        parts += [self._box(box, name, fill=OBSTACLE) for name, boxes in cells.obstacles.items() for box in boxes]
        if max(width, height) <= MOST_LINED:
            columns = [[self._point(x - 0.5, y) for y in (-0.5, height - 0.5)] for x in range(1, width)]
            rows = [[self._point(x, y - 0.5) for x in (-0.5, width - 0.5)] for y in range(1, height)]
            parts += [svg.line(ends, stroke=BORDER, stroke_width=0.6) for ends in (*columns, *rows)]
        return [*parts, self._box((0, 0, width - 1, height - 1), "", fill="none", stroke=svg.SOFT), *named]

    def _way(self, way: Trail) -> list[str]:
        """Return the path with its arrows, and the start as a ring."""
        parts = [svg.line([self._point(x, y) for x, y in way.line], stroke=svg.PATH, stroke_width=2)]
        reach = min(5.0, max(2.5, 0.2 * self.side))
        for x, y, dx, dy in way.arrows:
            tip_x, tip_y = self._point(x, y)
            ahead, aside = (reach * dx, -reach * dy), (0.7 * reach * dy, 0.7 * reach * dx)
            corners = [(tip_x + ahead[0], tip_y + ahead[1])]
            corners += [(tip_x - ahead[0] + sign * aside[0], tip_y - ahead[1] + sign * aside[1]) for sign in (1, -1)]
            parts.append(svg.area(corners, fill=svg.PATH))
        x, y = self._point(*way.states[0])
        return [*parts, svg.dot(x, y, 5, fill=svg.PAPER, stroke=svg.PATH, stroke_width=2)]
