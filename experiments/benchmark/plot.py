"""A figure of the benchmark: time against the number of tasks, with the times that the paper published."""

from collections.abc import Sequence
from pathlib import Path
from statistics import median

from matplotlib.axes import Axes

from experiments.benchmark.instances import FAMILIES
from experiments.benchmark.published import PUBLISHED
from experiments.benchmark.runs import BARE, FRONT, KINDS, MAX_MIN, OURS, SINGLE
from experiments.benchmark.summary import Cell
from experiments.figures.figures import drawing, write_figure

SIZE_IN = (9.5, 8.0)
"""Width and height, inches."""

TITLES = {SINGLE: "one plan of least cost", FRONT: "Pareto front"}

STYLES = {
    OURS: ("C0", "o", "prefplan", None),
    MAX_MIN: ("C1", "s", "paper's method, our kernels", "paper, published"),
    BARE: ("C2", "D", "the same without heuristic", "paper, published, without heuristic"),
}
"""Colour, marker and name of each method, and the name of its published times, if there are any."""


def draw(found: Sequence[Cell], path: Path) -> None:
    """Write a figure with one panel for each family of instances and kind of planning."""
    with drawing(size=SIZE_IN) as figure:
        panels = figure.subplots(len(FAMILIES), len(KINDS), sharex=True, sharey=True, squeeze=False)
        for row, family in zip(panels, FAMILIES, strict=True):
            for axes, kind in zip(row, KINDS, strict=True):
                cells = [cell for cell in found if (cell.what["family"], cell.what["kind"]) == (family, kind)]
                _panel(axes, cells, kind)
                axes.set(title=f"{TITLES[kind]}, {family}", xlabel="tasks", ylabel="seconds", yscale="log")
                axes.label_outer()
        marks = {
            label: line for axes in panels.flat for line, label in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        figure.legend(marks.values(), marks.keys(), loc="outside lower center", ncols=3)
        write_figure(figure, path)


def _panel(axes: Axes, cells: list[Cell], kind: str) -> None:
    """Draw medians with their range; a triangle marks a median that is a lower bound."""
    for method, (colour, marker, name, published) in STYLES.items():
        shown = {cell.what["tasks"]: cell for cell in cells if cell.what["method"] == method}
        medians = {tasks: cell.statistic("seconds", median) or (0.0, False) for tasks, cell in shown.items()}
        seconds = [[run["seconds"] for run in cell.runs.values()] for cell in shown.values()]
        axes.plot(list(shown), [value for value, _ in medians.values()], f"{marker}-", color=colour, label=name)
        axes.fill_between(
            list(shown), [*map(min, seconds)], [*map(max, seconds)], color=colour, alpha=0.15, linewidth=0
        )
        cut = [(tasks, value) for tasks, (value, is_bound) in medians.items() if is_bound]
        if cut:
            label = "lower bound: runs were stopped"
            axes.plot(*zip(*cut, strict=True), "^", color=colour, markersize=10, label=label)
        if published:
            times = PUBLISHED[kind, method]
            axes.plot(list(times), list(times.values()), "--", color=colour, linewidth=1, label=published)
