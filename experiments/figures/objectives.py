"""Fronts of three and more objectives: every pair of objectives, and all of them in parallel coordinates."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from prefplan.front import Front
from prefplan.text.layout import number

PANEL_IN = 3.4
"""Width and height of a panel with two objectives, inches."""

COLUMNS = 3
"""Greatest number of such panels side by side."""

MOST_NUMBERED = 30
"""Greatest number of plans of a front whose points are numbered."""

NUMBERED_APART = 0.045
"""Least distance between two plan numbers on an axis, as a share of it; closer numbers share one label."""

COLORS = "viridis"
"""Colour map of the plans, from the first of the front to the last; suits colour-blind readers."""


def draw_objectives(figure: Figure, front: Front) -> None:
    """Draw every pair of objectives of a front, and all objectives below; this sets the size of the figure."""
    pairs = list(combinations(front.objectives, 2))
    rows, columns = -(-len(pairs) // COLUMNS), min(len(pairs), COLUMNS)
    figure.set_size_inches(PANEL_IN * columns, PANEL_IN * (rows + 1))
    grid = figure.add_gridspec(rows + 1, columns)
    for k, pair in enumerate(pairs):
        draw_pair(figure.add_subplot(grid[k // COLUMNS, k % COLUMNS]), front, *pair)
    draw_parallel(figure.add_subplot(grid[rows, :]), front)


def draw_pair(axes: Axes, front: Front, first: str, second: str) -> None:
    """Draw two objectives: every plan, and the border of the region that the front of these two alone dominates."""
    values, colors = _values(front), _colors(front)
    x, y = (values[:, front.objectives.index(name)] for name in (first, second))
    alone = front.over([first, second])
    steps = sorted((float(plan.objectives[first]), float(plan.objectives[second])) for plan in alone)
    axes.step(*zip(*steps, strict=True), where="post", color="#999999", linewidth=1.0, zorder=2)
    axes.scatter(x, y, s=34, c=colors, edgecolors="white", linewidths=0.6, zorder=4)
    if len(front) <= MOST_NUMBERED:
        for i, at in enumerate(zip(x, y, strict=True)):
            axes.annotate(str(i), at, (4, 3), textcoords="offset points", fontsize=6.5, zorder=5)
    axes.set(xlabel=first, ylabel=second)
    axes.margins(0.09)


def draw_parallel(axes: Axes, front: Front) -> None:
    """Draw every plan as a line over all objectives; lower is better on each axis, which has its own scale."""
    values = _values(front)
    low, high = values.min(axis=0), values.max(axis=0)
    shares = (values - low) / np.where(high > low, high - low, 1.0)
    places = range(values.shape[1])
    for share, color in zip(shares, _colors(front), strict=True):
        axes.plot(places, share, "o-", color=color, linewidth=1.3, markersize=4, alpha=0.85, zorder=3)
    near: list[list[int]] = []
    for i in np.argsort(shares[:, 0], kind="stable").tolist() if len(front) <= MOST_NUMBERED else ():
        if near and shares[i, 0] - shares[near[-1][0], 0] < NUMBERED_APART:
            near[-1].append(i)
        else:
            near.append([i])
    for plans in near:
        text, at = ", ".join(map(str, plans)), float(shares[plans, 0].mean())
        axes.annotate(text, (0, at), (-6, 0), textcoords="offset points", ha="right", va="center", fontsize=6.5)
    for place, least, most in zip(places, low, high, strict=True):
        axes.axvline(place, color="#444444", linewidth=0.9, zorder=2)
        for value, at, offset in ((least, 0, -11), (most, 1, 5)):
            axes.annotate(
                number(float(value)), (place, at), (7, offset), textcoords="offset points", ha="left", fontsize=7.5
            )
    axes.set_xticks(places, front.objectives)
    axes.tick_params(axis="x", length=0, pad=14)
    axes.set(yticks=[], xlim=(-0.25, len(places) - 0.75), ylim=(-0.08, 1.12))
    axes.grid(False)
    axes.spines[:].set_visible(False)


def _values(front: Front) -> np.ndarray:
    """Return the objectives of the plans, (plans, objectives)."""
    return np.array([[float(value) for value in plan.objectives.values()] for plan in front])


def _colors(front: Front) -> np.ndarray:
    """Return a colour for each plan, (plans, 4)."""
    return np.asarray(colormaps[COLORS](np.linspace(0, 0.9, len(front))))
