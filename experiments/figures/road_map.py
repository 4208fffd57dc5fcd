"""Maps of graphs whose nodes have coordinates: edges, labelled places, and the path of a plan."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from experiments.figures.grid_map import (
    AREAS,
    GOOD,
    MOST_SAMPLES,
    PATH,
    SMALL_FONT_SIZE,
    START_COLOR,
    START_SIZE,
    Named,
    square,
    task_lines,
    write_names,
)
from prefplan.front import Plan
from prefplan.ledger import Ledger
from prefplan.models.graph_files.network import Network
from prefplan.problem import Problem

WIDTH = 40.0
"""Width of a map in its units; the page draws its robot about so much narrower."""

MARGIN = 0.6
"""Empty border of a map, units."""

MARK = 0.34
"""Radius of a satisfied task's dot, units."""

PLACE = 0.2
"""Radius of a labelled place, units."""

ROAD_COLOR, PIN_EDGE = "#a8a8a8", "#333333"

ROAD_WIDTH, MANY_ROADS_WIDTH = 0.8, 0.6
"""Line widths of edges that are lines and that are pixels, points."""

MOST_LINES = 3_000
"""Edges from which on they are pixels, which a browser shows faster than lines."""

PIXELS, DPI = 1400, 100
"""Longer side of a map of pixels, and its pixels in an inch."""

ARROW_DISTANCE = 3.5
"""Distance of two arrows on the path, units."""


@dataclass(frozen=True, eq=False)
class RoadMap:
    """The map of a graph, see `experiments.figures.maps.PlanMap`.

    Attributes:
        problem: what is planned.
        points: (S, 2) nodes, in units of the map.
        lines: (L, 2, 2) an edge between each two nodes that have any.
        size: width and height.
        index: of a node by its name.
    """

    problem: Problem
    points: np.ndarray
    lines: np.ndarray
    size: tuple[float, float]
    index: dict[Any, int]

    @classmethod
    def of(cls, problem: Problem, network: Network) -> RoadMap:
        """Return the map of a graph that has coordinates."""
        assert network.coordinates is not None
        points = network.coordinates.copy()
        if network.degrees is not None:
            points[:, 0] *= np.cos(np.radians(points[:, 1].mean() * network.degrees))
        low, extent = points.min(axis=0), np.ptp(points, axis=0)
        wide, high = extent / (extent.max() or 1) * (WIDTH - 2 * MARGIN) + 2 * MARGIN
        points = (points - low) / (extent.max() or 1) * (WIDTH - 2 * MARGIN) + MARGIN - 0.5
        ends = np.unique(np.sort(np.stack([network.sources, network.targets], axis=1), axis=1), axis=0)
        index = {name: i for i, name in enumerate(network.states)}
        return cls(problem, points, points[ends], (float(wide), float(high)), index)

    def draw(self, axes: Axes, plan: Plan) -> None:
        """Draw the edges, the labelled places, and the plan's path, start and goals, without text."""
        axes.set_aspect("equal")
        axes.set_xlim(-0.5, self.size[0] - 0.5)
        axes.set_ylim(-0.5, self.size[1] - 0.5)
        axes.grid(False)
        axes.patch.set_gid("ground")
        axes.spines[:].set_visible(True)
        axes.set(xticks=[], yticks=[])
        self._draw_roads(axes)
        colour = dict(zip(sorted(self.problem.task_propositions), AREAS[:-1] * 10, strict=False))
        dot: dict[str, Any] = {"edgecolor": "white", "linewidth": 0.6}
        pin: dict[str, Any] = {"edgecolor": PIN_EDGE, "linewidth": 0.4}
        for state, names in self._places().items():
            point = tuple(self.points[state])
            axes.add_patch(Circle(point, PLACE, facecolor=colour[names[0]], zorder=2, gid="place", **pin))
        path = self.path(plan)
        axes.plot(*path.T, color=PATH, linewidth=1.3, solid_joinstyle="round", zorder=3, gid="path")
        for corners in _arrows(path):
            axes.add_patch(Polygon(corners, closed=True, facecolor=PATH, linewidth=0, zorder=3, gid="arrow"))
        axes.add_patch(Circle(tuple(path[0]), START_SIZE * MARK, facecolor=START_COLOR, zorder=5, gid="start", **dot))
        for step in self._goals(plan):
            axes.add_patch(Circle(tuple(path[step]), MARK, facecolor=GOOD, zorder=5, gid="goal", **dot))

    def label(self, axes: Axes, plan: Plan, *, font_size: float = SMALL_FONT_SIZE) -> None:
        """Write the names of satisfied tasks, and of labelled places where there is space."""
        path = self.path(plan)
        goals = self._goals(plan)
        named = [Named(task_lines(tasks), "task", square(path[step], MARK), False) for step, tasks in goals.items()]
        reached = {self.index[plan.states[step]] for step in goals}
        for state, names in self._places().items():
            if state not in reached:
                named.append(Named(", ".join(names), "name", square(self.points[state], PLACE), False))
        dots = [square(path[0], START_SIZE * MARK), *(one.target for one in named)]
        sampled = path[:: max(1, len(path) // MOST_SAMPLES)]
        write_names(axes, named, dots=dots, path=sampled, font_size=font_size)

    def path(self, plan: Plan) -> np.ndarray:
        """Return the (S, 2) points of a plan's states."""
        return np.asarray(self.points[[self.index[state] for state in plan.states]])

    def _draw_roads(self, axes: Axes) -> None:
        if len(self.lines) <= MOST_LINES:
            roads: Artist = self._roads(ROAD_WIDTH)
            axes.add_collection(cast(LineCollection, roads))
        else:
            right, top = self.size[0] - 0.5, self.size[1] - 0.5
            roads = axes.imshow(self._pixels, extent=(-0.5, right, -0.5, top), interpolation_stage="rgba", zorder=1)
        roads.set_gid("roads")

    def _roads(self, width: float) -> LineCollection:
        return LineCollection(list(self.lines), colors=ROAD_COLOR, linewidths=width, zorder=1)

    @cached_property
    def _pixels(self) -> np.ndarray:
        """The (H, W, 4) uint8 picture of all edges on a clear ground."""
        scale = PIXELS / DPI / max(self.size)
        figure = Figure(figsize=(scale * self.size[0], scale * self.size[1]), dpi=DPI, facecolor="none")
        canvas = FigureCanvasAgg(figure)
        axes = figure.add_axes((0, 0, 1, 1), xlim=(-0.5, self.size[0] - 0.5), ylim=(-0.5, self.size[1] - 0.5))
        axes.set_axis_off()
        axes.add_collection(self._roads(MANY_ROADS_WIDTH))
        canvas.draw()
        return np.asarray(canvas.buffer_rgba()).copy()

    def _places(self) -> dict[int, list[str]]:
        """Return the propositions of the tasks by node, of the nodes that carry some."""
        system, used = self.problem.system, self.problem.task_propositions
        shown = np.array([not used.isdisjoint(names) for names in system.label_sets])
        labelled = np.flatnonzero(shown[system.labels]).tolist()
        return {state: sorted(system.label(state) & used) for state in labelled}

    def _goals(self, plan: Plan) -> dict[int, list[str]]:
        """Return the tasks that a plan satisfies, by the number of actions taken until then."""
        found: dict[int, list[str]] = defaultdict(list)
        for task, step in Ledger.of_plan(self.problem, plan).satisfied.items():
            if step is not None:
                found[step].append(task)
        return dict(found)


def _arrows(path: np.ndarray) -> list[np.ndarray]:
    """Return the corners of arrows at equal distances along a path."""
    gone = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    found = []
    for at in np.arange(ARROW_DISTANCE / 2, gone[-1], ARROW_DISTANCE):
        tail, tip = (np.array([np.interp(at + aside, gone, column) for column in path.T]) for aside in (-MARK, MARK))
        length = float(np.hypot(*(tip - tail)))
        if length > MARK:  # no arrow where the path turns back
            ahead = (tip - tail) / length
            aside = np.array([-ahead[1], ahead[0]])
            middle = (tip + tail) / 2
            found.append(middle + MARK * np.array([ahead, 0.7 * aside - 0.8 * ahead, -0.7 * aside - 0.8 * ahead]))
    return found
