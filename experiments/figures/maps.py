"""Maps of grids and of graphs whose nodes have coordinates."""

import base64
import hashlib
from pathlib import Path

from experiments.cli.files import write_bytes
from experiments.figures.figures import LINK, SVG, drawing, inline_svg, parsed_svg
from experiments.figures.grid_map import GridMap
from experiments.figures.plan_map import PlanMap
from experiments.figures.road_map import RoadMap
from prefplan import GridModel, Plan, Scenario
from prefplan.models.graph_file import GraphFileModel

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


def svg(plan_map: PlanMap, plan: Plan, *, title: str, folder: Path) -> str:
    """Return a map with the path of a plan as inline SVG, without margins; the title is for screen readers.

    Pixels are written as files to a folder beside the page: maps with the same background share one.

    Its parts have the classes `ground`, `path`, `arrow`, `name`, `start`, `goal`, `task`, `leader`; on a grid
    also `grid`, `region` and `obstacle`, and on a graph `place` and, unless they are drawn as pixels, `roads`.
    """
    scale = SIDE_IN / max(plan_map.size)
    with drawing(size=(scale * plan_map.size[0], scale * plan_map.size[1])) as figure:
        figure.set_layout_engine("none")
        axes = figure.add_axes((0, 0, 1, 1))
        plan_map.draw(axes, plan)
        figure.draw_without_rendering()
        plan_map.label(axes, plan, font_size=FONT_SIZE_PT)
        root = parsed_svg(figure)
    for image in root.iter(f"{SVG}image"):
        pixels = base64.b64decode(image.attrib[LINK].partition(",")[2])
        file = folder / f"{hashlib.sha256(pixels).hexdigest()[:12]}.png"
        if not file.exists():
            write_bytes(file, pixels)
        image.set(LINK, f"{folder.name}/{file.name}")
    return inline_svg(root, kind="map", title=title)
