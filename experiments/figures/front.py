"""The Pareto front as a figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from experiments.figures.figures import drawing, write_figure
from experiments.figures.objectives import draw_objectives, draw_parallel
from prefplan.front import Front
from prefplan.models.manipulation.action_costs import QUANTITIES, MeasuredCosts
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import Scenario
from prefplan.text.layout import counted, number

SIZE_IN = (6.4, 4.4)
"""Inches."""

MARGIN = 0.09
"""Empty border around the points, as a fraction of their range."""

MARGIN_FOR_LABEL = 0.17
"""The same to the left of the first point if points have labels."""


TICK_GAP_PX = 1.5
"""Half the least distance between tick labels, px."""


def draw(scenario: Scenario, front: Front, path: Path) -> None:
    """Write a figure of a front with at least one point.

    Raises:
        PrefplanError: the file cannot be written.
    """
    count = counted(len(front), "best trade-off")
    with drawing(size=SIZE_IN) as figure:
        if scenario.problem().is_bi_objective:
            axes = figure.subplots()
            draw_front(axes, scenario, front)
            axes.set_title(f"{scenario.name}: {count}")
            # Inside the axes the legend could cover the front, and its marker would look like a plan.
            figure.legend(loc="outside lower center", ncols=4)
        else:
            draw_objectives(figure, front)
            figure.suptitle(f"{scenario.name}: {count}; lower is better")
        write_figure(figure, path)


def draw_front(axes: Axes, scenario: Scenario, front: Front, *, brief: bool = False) -> None:
    """Draw a front: its points, the region that they dominate, and the ideal point; if `brief`, label indices only.

    A front of more than two objectives is drawn in parallel coordinates.
    """
    if not scenario.problem().is_bi_objective:
        draw_parallel(axes, front)
        return
    costs, mu = (
        np.array(values, dtype=float) for values in zip(*((plan.cost, plan.preference) for plan in front), strict=True)
    )
    left, right = _limits(costs, before=MARGIN if brief else MARGIN_FOR_LABEL)
    low, high = _limits(mu)
    axes.set_xlim(left, right)
    axes.set_ylim(low, high)
    # Extend the border of the dominated region to the edges of the picture.
    x, y = np.array([costs[0], *costs, right]), np.array([high, *mu, mu[-1]])
    axes.fill_between(x, y, high, step="post", color="C0", alpha=0.10, linewidth=0, label="dominated")
    axes.step(x, y, where="post", color="C0", linewidth=1.2, zorder=2)
    if len(front) > 1:
        axes.plot(costs[0], mu[-1], "*", color="C3", markersize=11, label="ideal, out of reach", zorder=3)
    axes.plot(costs, mu, "o", color="C0", markersize=6.5, markeredgecolor="white", label="plan", zorder=4)
    if front.complete_below is not None:
        axes.axvline(
            float(front.complete_below), color="C1", linestyle="--", linewidth=1.2, label="complete up to here"
        )
    axes.set_xticks(costs, [number(plan.cost) for plan in front])
    axes.set_yticks(mu, [number(plan.preference) for plan in front])
    unit = cost_unit(scenario)
    axes.set_xlabel(f"total cost ({unit})" if unit else "total cost")
    texts = [f"{i}: ({number(plan.cost)}, {number(plan.preference)})" for i, plan in enumerate(front)]
    if brief:
        axes.set_ylabel("μ", rotation=0)
        texts = [str(i) for i in range(len(front))]
    else:
        axes.set_ylabel("penalty μ (lower is better)")
    _label(axes, texts, costs, mu)


def _limits(values: np.ndarray, *, before: float = MARGIN) -> tuple[float, float]:
    spread = float(np.ptp(values)) or abs(float(values[0])) or 1.0
    return float(values.min()) - before * spread, float(values.max()) + 2.4 * MARGIN * spread


def cost_unit(scenario: Scenario) -> str | None:
    """Return the measured quantity and its unit, such as `energy, J`; None if costs were given as numbers."""
    model = scenario.model
    if isinstance(model, ManipulationModel) and isinstance(model.costs, MeasuredCosts):
        return f"{model.costs.quantity}, {QUANTITIES[model.costs.quantity]}"
    return None


def _label(axes: Axes, texts: list[str], x: np.ndarray, y: np.ndarray) -> None:
    """Label the points, first the ends of the front; omit labels that would overlap others or leave the axes."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.draw_without_rendering()
    _thin_out(axes.get_xticklabels())
    _thin_out(axes.get_yticklabels())
    taken: list[Bbox] = []
    inside = axes.get_window_extent()
    for i in sorted(range(len(x)), key=lambda i: (0 < i < len(x) - 1, i)):
        for offset, side, end in (((6, 5), "left", "bottom"), ((-6, -5), "right", "top")):
            text = axes.annotate(
                texts[i], (x[i], y[i]), offset, textcoords="offset points", ha=side, va=end, fontsize=8.5, zorder=5
            )
            extent = text.get_window_extent()
            if extent.x0 > inside.x0 and not any(extent.overlaps(other) for other in taken):
                taken.append(extent)
                break
            text.remove()


def _thin_out(labels: Sequence[Text]) -> None:
    """Hide tick labels that overlap others; the first and the last stay if they do not overlap."""
    taken: list[Bbox] = []
    for i in sorted(range(len(labels)), key=lambda i: (0 < i < len(labels) - 1, i)):
        extent = labels[i].get_window_extent().padded(TICK_GAP_PX)
        labels[i].set_visible(not any(extent.overlaps(other) for other in taken))
        if labels[i].get_visible():
            taken.append(extent)
