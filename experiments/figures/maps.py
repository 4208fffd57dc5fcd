"""Maps of grids and of graphs whose nodes have coordinates."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from matplotlib.figure import Figure

from experiments.figures.figures import drawing, inline_svg, write_figure
from experiments.figures.grid_map import GridMap
from experiments.figures.plan_map import PlanMap
from experiments.figures.road_map import RoadMap
from prefplan.models.graph_file import GraphFileModel
from prefplan.models.grid import GridModel
from prefplan.plan import Plan
from prefplan.scenario.decode import Scenario

SIDE_IN = 4.5
"""Longer side of a map on its own, inches."""

FONT_SIZE_PT = 9.0
"""Size of text on a map on its own, points."""


def map_of(scenario: Scenario) -> PlanMap | None:
    """Return the map of a scenario's model; None if it is neither a grid nor a graph with coordinates."""
    model = scenario.model
    if isinstance(model, GridModel):
        return GridMap(scenario.problem(), model)
    if isinstance(model, GraphFileModel) and model.network.points is not None:
        return RoadMap(scenario.problem(), model.network)
    return None


def svg(plan_map: PlanMap, plan: Plan) -> str:
    """Return a map with the path of a plan as inline SVG, without margins.

    Its parts have the classes `ground`, `path`, `arrow`, `name`, `start`, `goal`, `task`, `leader`; on a grid
    also `grid`, `region` and `obstacle`, and on a graph `roads` and `place`.
    """
    with _drawn(plan_map, plan, SIDE_IN) as figure:
        return inline_svg(figure, kind="map", title=f"Map with the path of a plan of {len(plan.actions)} moves")


def draw(plan_map: PlanMap, plan: Plan, path: Path, *, side: float = SIDE_IN) -> None:
    """Write a map with the path of a plan; its longer side has a length `side`, inches."""
    with _drawn(plan_map, plan, side) as figure:
        write_figure(figure, path)


@contextmanager
def _drawn(plan_map: PlanMap, plan: Plan, side: float) -> Iterator[Figure]:
    scale = side / max(plan_map.size)
    with drawing(size=(scale * plan_map.size[0], scale * plan_map.size[1])) as figure:
        axes = figure.add_axes((0, 0, 1, 1))
        plan_map.draw(axes, plan)
        figure.draw_without_rendering()
        plan_map.label(axes, plan, font_size=FONT_SIZE_PT)
        yield figure
