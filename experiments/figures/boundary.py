"""The boundary of one perturbation as a figure: the share of completed rollouts by amount."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from experiments.figures.figures import drawing, write_figure

SIZE_IN = (6.4, 3.6)
"""Inches."""


def draw(result: Mapping[str, Any], path: Path) -> None:
    """Write a figure of a result of `experiments.sweep.boundary`.

    Raises:
        PrefplanError: the file cannot be written.
    """
    trials = [trial for trial in result["trials"] if trial["rollouts"]]
    with drawing(size=SIZE_IN, layout=True) as figure:
        axes = figure.subplots()
        if trials:
            amounts, shares = np.array([(t["amount"], t["completed"] / t["rollouts"]) for t in trials]).T
            away = np.abs(np.array([trial["interval"] for trial in trials]).T - shares)
            axes.errorbar(
                amounts, shares, away, fmt="o", color="C0", capsize=3, label="completed, 95 % interval (Wilson)"
            )
        axes.axhline(result["threshold"], color="C6", linestyle="--", label=f"{result['threshold']:.0%}")
        low, high = result["boundary"] or (None, None)
        if low is not None and high is not None:
            axes.axvspan(low, high, color="C1", alpha=0.25, linewidth=0, label=f"boundary, {low:g} to {high:g}")
        axes.set_xlim(-0.03 * result["greatest"], 1.03 * result["greatest"])
        axes.set_ylim(-0.03, 1.03)
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
        axes.set_xlabel(f"{result['key']}, {result['unit']}")
        axes.set_title(f"{result['scenario']}, plan {result['plan']}: rollouts completed by {result['key']}")
        figure.legend(loc="outside lower center", ncols=3)
        write_figure(figure, path)
