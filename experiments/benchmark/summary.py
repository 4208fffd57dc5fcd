"""Statistics of the benchmark's runs: medians, maxima, ratios, and a table of them."""

from __future__ import annotations

import io
import math
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from experiments.benchmark.instances import FAMILIES, Points
from experiments.benchmark.published import PUBLISHED
from experiments.benchmark.runs import BARE, FRONT, KINDS, MAX_MIN, OURS, SINGLE, BenchmarkRun, Timing

MEGABYTE = 1e6

TITLES = {SINGLE: "one plan of least cost", FRONT: "Pareto front"}

Results = Mapping[BenchmarkRun, Timing]


def disagreements(results: Results) -> list[str]:
    """Return the instances on which two methods that were not ended find different fronts, or least costs."""
    found: dict[tuple[str, str, int, int], dict[str, Points]] = {}
    for run, outcome in results.items():
        if outcome.points is not None:
            found.setdefault((run.family, run.kind, run.tasks, run.seed), {})[run.method] = outcome.points
            if run.kind == FRONT:
                cost = (outcome.points[0][:1],)
                found.setdefault((run.family, SINGLE, run.tasks, run.seed), {})[f"front, {run.method}"] = cost
    return [f"{where}: {said}" for where, said in found.items() if len(set(said.values())) > 1]


def cells(results: Results) -> list[dict[str, Any]]:
    """Return statistics of all runs of one family, kind, size and method, cell by cell."""
    groups: dict[tuple[str, str, int, str], dict[int, Timing]] = {}
    for run, outcome in results.items():
        groups.setdefault((run.family, run.kind, run.tasks, run.method), {})[run.seed] = outcome
    return [
        {
            "family": family,
            "kind": kind,
            "tasks": tasks,
            "method": method,
            **_cell(by_seed),
            "ratio_to_ours": _ratio(by_seed, groups.get((family, kind, tasks, OURS), {})) if method != OURS else None,
            "published_mean_seconds": PUBLISHED.get((kind, method), {}).get(tasks),
        }
        for (family, kind, tasks, method), by_seed in sorted(groups.items())
    ]


def _cell(by_seed: Mapping[int, Timing]) -> dict[str, Any]:
    outcomes = list(by_seed.values())
    return {
        "runs": len(outcomes),
        "ended": [outcome.ended for outcome in outcomes if outcome.ended],
        "seconds": _spread((outcome.seconds, outcome.ended is not None) for outcome in outcomes),
        "expanded": _spread((outcome.expanded, outcome.ended is not None) for outcome in outcomes),
        "peak_mb": _spread((outcome.peak_bytes / MEGABYTE, outcome.ended is not None) for outcome in outcomes),
        "baseline_mb": round(max(outcome.baseline_bytes for outcome in outcomes) / MEGABYTE, 1),
    }


def _ratio(yardstick: Mapping[int, Timing], ours: Mapping[int, Timing]) -> dict[str, Any] | None:
    """Return the time of the yardstick over ours on the same instances."""
    both = [seed for seed in yardstick if seed in ours and ours[seed].ended is None]
    if not both:
        return None
    return _spread((yardstick[seed].seconds / ours[seed].seconds, yardstick[seed].ended is not None) for seed in both)


STATISTICS: dict[str, Callable[[Sequence[float]], float]] = {
    "median": statistics.median,
    "mean": statistics.fmean,
    "min": min,
    "max": max,
}


def _spread(values: Iterable[tuple[float, bool]]) -> dict[str, Any]:
    """Return statistics of (value, whether it is only a lower bound).

    `at_least` names those that are lower bounds themselves: greater values would change them.
    """
    known = list(values)
    numbers, raised = [value for value, _ in known], [math.inf if is_bound else value for value, is_bound in known]
    at_least = [name for name, statistic in STATISTICS.items() if statistic(raised) != statistic(numbers)]
    return {name: _rounded(statistic(numbers)) for name, statistic in STATISTICS.items()} | {"at_least": at_least}


def _rounded(value: float) -> float:
    """Return three significant digits, all of whole numbers before the point."""
    return float(f"{value:.3g}") if abs(value) < 1000 else round(value)


COLUMNS = (
    ("ours: s", OURS, "seconds", "median"),
    ("max s", OURS, "seconds", "max"),
    ("expanded", OURS, "expanded", "median"),
    ("MB", OURS, "peak_mb", "median"),
    ("max-min: s", MAX_MIN, "seconds", "median"),
    ("max s", MAX_MIN, "seconds", "max"),
    ("expanded", MAX_MIN, "expanded", "median"),
    ("MB", MAX_MIN, "peak_mb", "median"),
    ("x ours", MAX_MIN, "ratio_to_ours", "median"),
    ("no h: s", BARE, "seconds", "median"),
    ("MB", BARE, "peak_mb", "median"),
    ("x ours", BARE, "ratio_to_ours", "median"),
)
"""Columns of the tables: heading, method, entry of the cell, and statistic."""


def markdown(report: Mapping[str, Any]) -> str:
    """Return the results as a page: a table for each family of instances and kind of planning."""
    machine = report["machine"]
    lines = [
        "# The benchmark of the paper's Table I",
        "",
        report["about"],
        "",
        f"{report['date']}, {machine['cpu']}, {machine['cores']} cores, Python {machine['python']}, "
        f"numba {machine['numba']}.",
        "",
        *(f"- {note}" for note in report["notes"]),
        "",
    ]
    for family in FAMILIES:
        for kind in KINDS:
            found = [cell for cell in report["cells"] if (cell["family"], cell["kind"]) == (family, kind)]
            if found:
                lines += [f"## {TITLES[kind].capitalize()}, {family}", "", table(kind, found), ""]
    return "\n".join(lines)


def table(kind: str, found: Sequence[Mapping[str, Any]]) -> str:
    """Return the cells of one family of instances and kind of planning as a Markdown table, a row for each N."""
    by_place = {(cell["tasks"], cell["method"]): cell for cell in found}
    rows = Table(box=box.MARKDOWN)
    for heading in ("N", *(heading for heading, *_ in COLUMNS), "paper, h: s", "paper, no h: s"):
        rows.add_column(heading, justify="right")
    for tasks in sorted({cell["tasks"] for cell in found}):
        cells = [_show(by_place.get((tasks, method)), what, statistic) for _, method, what, statistic in COLUMNS]
        rows.add_row(str(tasks), *cells, *(str(PUBLISHED[kind, method].get(tasks, "")) for method in (MAX_MIN, BARE)))
    text = io.StringIO()
    Console(width=1000, file=text).print(rows)
    return "\n".join(line.strip() for line in text.getvalue().strip().splitlines())


def _show(cell: Mapping[str, Any] | None, what: str, statistic: str) -> str:
    if cell is None or cell[what] is None:
        return ""
    value = cell[what][statistic]
    if what == "peak_mb" and value < 1:
        return "< 1"
    text = f"{value:,.0f}" if value >= 100 or what == "expanded" else f"{value:.2g}"
    return f">= {text}" if statistic in cell[what]["at_least"] else text
