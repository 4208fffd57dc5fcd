"""Every plan of a front in one figure: its path on the map, or else on the graph."""

import math
import textwrap
from pathlib import Path

from experiments.figures.diagrams import route
from experiments.figures.figures import drawing, write_figure
from experiments.figures.front import draw_front
from experiments.figures.maps import map_of
from prefplan import Front, PrefplanError, Scenario
from prefplan.errors import prefixed
from prefplan.plan import objectives_text

PANEL_IN = 3.1
"""Width of a panel with a map, inches."""

MOST_PLANS = 23
"""Greatest number of plans in a figure; with the front it has two dozen panels."""

COLUMNS = 4

TITLE_LETTERS = 34
"""Greatest number of letters in a line of a panel's title."""

LINE = 0.18
"""Height of each further line of text, inches."""


def draw(scenario: Scenario, front: Front, path: Path) -> None:
    """Write a map for each plan and the front, like the paper's Figures 3 and 4; without a map, each plan's graph.

    Raises:
        PrefplanError: there are too many plans, one visits too many states, or the file cannot be written.
    """
    plan_map = map_of(scenario)
    if plan_map is None:
        with prefixed(f"{scenario.path}: ", route.SystemSizeError):
            return route.draw(scenario.problem().system, front, path)
    if len(front) > MOST_PLANS:
        raise PrefplanError(
            f"{scenario.path}: the front has {len(front)} plans, and up to {MOST_PLANS} can be drawn in one picture; "
            "--max-cost draws the cheaper ones"
        )
    columns = min(COLUMNS, math.ceil((len(front) + 1) / 2))
    rows = math.ceil((len(front) + 1) / columns)
    shape = min(1.6, max(0.6, plan_map.size[1] / plan_map.size[0]))
    titles = [
        textwrap.fill(f"{i}: {objectives_text(plan, penalty='μ =')}", TITLE_LETTERS) for i, plan in enumerate(front)
    ]
    lines = max(title.count("\n") for title in titles) + max(len(plan.relaxations) for plan in front)
    size = (columns * PANEL_IN, rows * (PANEL_IN * shape + 0.35 + LINE * lines))
    with drawing(size=size) as figure:
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, plan, title in zip(panels, front, titles, strict=False):
            plan_map.draw(axes, plan)
            axes.set_xlabel("\n".join(map(str, plan.relaxations)), fontsize=7.5)
            axes.set_title(title)
        draw_front(panels[len(front)], scenario, front, brief=True)
        panels[len(front)].set_title("Pareto front")
        for axes in panels[len(front) + 1 :]:
            axes.set_axis_off()
        figure.draw_without_rendering()
        for axes, plan in zip(panels, front, strict=False):
            plan_map.label(axes, plan)
        write_figure(figure, path)
