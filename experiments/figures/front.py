"""The Pareto front as a figure."""

import math
from collections.abc import Mapping
from itertools import accumulate, combinations
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Bbox

from experiments.figures.figures import drawing, write_figure
from prefplan import Front, ManipulationModel, PrefplanError, Scenario
from prefplan.models.manipulation.action_costs import QUANTITIES, MeasuredCosts
from prefplan.text.layout import counted, number

SIZE_IN = (6.4, 4.4)
"""Width and height of a figure of two objectives, inches."""

PANEL_IN = 3.4
"""Width and height of each panel in a figure of more objectives, inches."""

COLUMNS = 3
"""Greatest number of such panels side by side."""

MARGIN = 0.09
"""Empty border around the points, as a fraction of their range."""

MARGIN_FOR_LABEL = 0.17
"""The same to the left of the first point if points have labels."""


def draw(scenario: Scenario, front: Front, path: Path) -> None:
    """Write a figure of a front with at least one point: a panel for every pair of its objectives.

    Raises:
        PrefplanError: the file cannot be written.
    """
    pairs = list(combinations(front.objectives, 2))
    columns = min(len(pairs), COLUMNS)
    rows = -(-len(pairs) // columns)
    size = SIZE_IN if len(pairs) == 1 else (PANEL_IN * columns, PANEL_IN * rows)
    with drawing(size=size) as figure:
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes in panels[len(pairs) :]:
            axes.set_axis_off()
        figure.suptitle(f"{scenario.name}: {counted(len(front), 'best trade-off')}")
        for axes, pair in zip(panels, pairs, strict=False):
            draw_front(axes, scenario, front, pair, brief=len(pairs) > 1)
        # Inside the axes the legend could cover the front, and its marker would look like a plan.
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        write_figure(figure, path)


def draw_front(
    axes: Axes, scenario: Scenario, front: Front, pair: tuple[str, str] | None = None, *, brief: bool = False
) -> None:
    """Draw the front of two objectives: its points, the region that they dominate, the ideal point, and other plans.

    The two are the first and the last unless others are given. If `brief`, points have the plans' indices only.

    Raises:
        PrefplanError: its values are too large.
    """
    names = pair or (front.objectives[0], front.objectives[-1])
    try:
        points = sorted((*(float(plan.objectives[name]) for name in names), i) for i, plan in enumerate(front))
    except OverflowError:
        raise PrefplanError("a front with values beyond 1e308 cannot be drawn") from None
    lowest = accumulate((point[1] for point in points), min, initial=math.inf)
    best = [point for point, low in zip(points, lowest, strict=False) if point[1] < low]
    costs, mu, _ = np.array(best).T
    left, right = _limits(np.array(points)[:, 0], before=MARGIN if brief else MARGIN_FOR_LABEL)
    low, high = _limits(np.array(points)[:, 1])
    axes.set(xlim=(left, right), ylim=(low, high))
    # Extend the border of the dominated region to the edges of the picture.
    x, y = np.array([costs[0], *costs, right]), np.array([high, *mu, mu[-1]])
    axes.fill_between(x, y, high, step="post", color="C0", alpha=0.10, linewidth=0, label="dominated")
    axes.step(x, y, where="post", color="C0", linewidth=1.2, zorder=2)
    if len(best) > 1:
        axes.plot(costs[0], mu[-1], "*", color="C3", markersize=11, label="ideal, out of reach", zorder=3)
    axes.plot(costs, mu, "o", color="C0", markersize=6.5, markeredgecolor="white", label="plan", zorder=4)
    if front.complete_below is not None and names[0] == front.objectives[0]:
        axes.axvline(
            float(front.complete_below), color="C1", linestyle="--", linewidth=1.2, label="complete up to here"
        )
    others = [point for point in points if point not in best]
    if others:
        x, y, _ = np.array(others).T
        axes.plot(x, y, "o", color="C6", markersize=5, label="best in other objectives", zorder=3)
    axes.set(xlabel=names[0], ylabel=names[1])
    if scenario.problem().is_bi_objective:
        unit = cost_unit(scenario)
        axes.set_xlabel(f"total cost ({unit})" if unit else "total cost")
        axes.set_ylabel("penalty μ" if brief else "penalty μ (lower is better)")
    shown = best + others
    _label(axes, {f"{i}" if brief else f"{i}: ({number(a)}, {number(b)})": (a, b) for a, b, i in shown})


def _limits(values: np.ndarray, *, before: float = MARGIN) -> tuple[float, float]:
    spread = float(np.ptp(values)) or abs(float(values[0])) or 1.0
    return float(values.min()) - before * spread, float(values.max()) + 2.4 * MARGIN * spread


def cost_unit(scenario: Scenario) -> str | None:
    """Return the measured quantity and its unit, such as `energy, J`; None if costs were given as numbers."""
    model = scenario.model
    if isinstance(model, ManipulationModel) and isinstance(model.costs, MeasuredCosts):
        return f"{model.costs.quantity}, {QUANTITIES[model.costs.quantity]}"
    return None


def _label(axes: Axes, points: Mapping[str, tuple[float, float]]) -> None:
    """Label points, first the ends; omit labels that would overlap others or leave the axes."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.draw_without_rendering()
    taken: list[Bbox] = []
    inside = axes.get_window_extent()
    for text, at in sorted(
        points.items(), key=lambda item: item[1] not in (min(points.values()), max(points.values()))
    ):
        for offset, side, end in (((6, 5), "left", "bottom"), ((-6, -5), "right", "top")):
            label = axes.annotate(text, at, offset, textcoords="offset points", ha=side, va=end, fontsize=8.5, zorder=5)
            extent = label.get_window_extent()
            if extent.x0 > inside.x0 and not any(extent.overlaps(other) for other in taken):
                taken.append(extent)
                break
            label.remove()
