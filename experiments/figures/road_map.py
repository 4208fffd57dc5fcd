"""Maps of graphs whose nodes have coordinates: edges, labelled places, and the path of a plan."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from experiments.figures.plan_map import AREAS, Named, PlanMap, square
from experiments.figures.trail import Trail
from prefplan import Plan, Problem
from prefplan.models.graph_file import Network

WIDTH = 40.0
"""Longer side of a map in its own units; the report page draws the robot about one unit wide."""

MARGIN = 0.6
"""Empty border of a map, units."""

MARK = 0.34
"""Radius of a satisfied task's dot, units."""

PLACE = 0.2
"""Radius of a labelled place, units."""

ROAD_COLOR, PIN_EDGE = "#a8a8a8", "#333333"

ROAD_WIDTH = 0.8
"""Line width of edges, points."""

MANY_ROADS_WIDTH = 0.2
"""Line width of edges in graphs with more than `MOST_LINES`, points."""

MOST_LINES = 3_000
"""Greatest number of edges that are lines in an SVG; more are pixels, which a browser shows faster."""

ARROW_DISTANCE = 3.5
"""Distance of two arrows on the path, units."""


class RoadMap(PlanMap):
    """The map of a graph whose nodes have coordinates.

    Attributes:
        points: (S, 2) nodes, in units of the map.
        lines: (L, 2, 2) ends of a line for each pair of nodes with an edge between them.
    """

    mark, path_width = MARK, 1.3

    def __init__(self, problem: Problem, network: Network) -> None:
        """Make the map of the graph of a problem, whose nodes have coordinates."""
        system, points = network.system, network.points
        assert points is not None
        low, extent = points.min(axis=0), np.ptp(points, axis=0)
        wide, high = extent / (extent.max() or 1) * (WIDTH - 2 * MARGIN) + 2 * MARGIN
        sources = np.repeat(np.arange(system.size), np.diff(system.offsets))
        ends = np.unique(np.sort(np.stack([sources, system.targets], axis=1), axis=1), axis=0)
        self.problem, self.size = problem, (float(wide), float(high))
        self.points = (points - low) / (extent.max() or 1) * (WIDTH - 2 * MARGIN) + MARGIN - 0.5
        self.lines = self.points[ends]
        self._index: dict[Any, int] = {name: i for i, name in enumerate(system.states)}
        used = problem.task_propositions
        shown = np.array([not used.isdisjoint(names) for names in system.label_sets])
        labelled = np.flatnonzero(shown[system.labels]).tolist()
        self._places = [(self.points[i], sorted(system.label(i) & used), system.states[i]) for i in labelled]
        self.named = [
            Named(", ".join(names), "name", square(point, PLACE), False, state) for point, names, state in self._places
        ]

    def trail(self, plan: Plan) -> Trail:
        """Return the path of a plan."""
        path = np.asarray(self.points[[self._index[state] for state in plan.states]])
        return Trail(path, path, _arrows(path))

    def _draw_ground(self, axes: Axes) -> None:
        """Draw the edges and the labelled places."""
        # One line with gaps is drawn faster than many lines.
        ends = np.pad(self.lines, ((0, 0), (0, 1), (0, 0)), constant_values=np.nan).reshape(-1, 2)
        many = len(self.lines) > MOST_LINES
        width = MANY_ROADS_WIDTH if many else ROAD_WIDTH
        axes.plot(*ends.T, color=ROAD_COLOR, linewidth=width, snap=False, zorder=1, gid="roads", rasterized=many)
        colour = dict(zip(sorted(self.problem.task_propositions), AREAS[:-1] * 10, strict=False))
        pin: dict[str, Any] = {"edgecolor": PIN_EDGE, "linewidth": 0.4}
        for point, names, _ in self._places:
            axes.add_patch(Circle(tuple(point), PLACE, facecolor=colour[names[0]], zorder=2, gid="place", **pin))


def _arrows(path: np.ndarray) -> np.ndarray:
    """Return the (A, 4) points and unit directions of arrows at equal distances along a path."""
    gone = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    found = []
    for at in np.arange(ARROW_DISTANCE / 2, gone[-1], ARROW_DISTANCE):
        tail, tip = (np.array([np.interp(at + aside, gone, column) for column in path.T]) for aside in (-MARK, MARK))
        length = float(np.hypot(*(tip - tail)))
        if length > MARK:  # no arrow where the path turns back
            found.append([*(tip + tail) / 2, *(tip - tail) / length])
    return np.array(found).reshape(-1, 4)
