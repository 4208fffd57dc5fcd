"""What the benchmark's runs came to: medians, maxima, ratios, and a table of them."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from experiments.benchmark.facts import PUBLISHED
from experiments.benchmark.instances import FAMILIES
from experiments.benchmark.runs import BARE, FRONT, KINDS, MAX_MIN, OURS, SINGLE, BenchmarkRun, Timing

MEGABYTE = 1e6

TITLES = {SINGLE: "one plan of least cost", FRONT: "Pareto front"}

Results = Mapping[BenchmarkRun, Timing]


def disagreements(results: Results) -> list[str]:
    """Return the instances on which two methods that ran to their end disagree about the front, or the least cost."""
    found: dict[tuple[str, str, int, int], dict[str, tuple[tuple[float, ...], ...]]] = {}
    for run, outcome in results.items():
        if outcome.points is not None:
            found.setdefault((run.family, run.kind, run.tasks, run.seed), {})[run.method] = outcome.points
            if run.kind == FRONT:
                cost = (outcome.points[0][:1],)
                found.setdefault((run.family, SINGLE, run.tasks, run.seed), {})[f"front, {run.method}"] = cost
    return [f"{where}: {said}" for where, said in found.items() if len(set(said.values())) > 1]


def cells(results: Results) -> list[dict[str, Any]]:
    """Return what all runs of one family, kind, size and method came to, cell by cell."""
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
    """Return how many times longer than ours the yardstick took on the same instances."""
    both = [seed for seed in yardstick if seed in ours and ours[seed].ended is None]
    if not both:
        return None
    return _spread((yardstick[seed].seconds / ours[seed].seconds, yardstick[seed].ended is not None) for seed in both)


def _spread(values: Iterable[tuple[float, bool]]) -> dict[str, Any]:
    """Return median, mean, least and largest of values, of which some are lower bounds only.

    `at_least` names the statistics that are lower bounds for that.
    """
    known = list(values)
    numbers = [value for value, _ in known]
    bounds = [value for value, is_bound in known if is_bound]
    at_least = ["mean", "max"] if bounds else []
    if any(bound <= statistics.median_high(numbers) for bound in bounds):
        at_least.append("median")
    if any(bound <= min(numbers) for bound in bounds):
        at_least.append("min")
    return {
        "median": _rounded(statistics.median(numbers)),
        "mean": _rounded(statistics.fmean(numbers)),
        "min": _rounded(min(numbers)),
        "max": _rounded(max(numbers)),
        "at_least": at_least,
    }


def _rounded(value: float) -> float:
    """Return three significant digits, all of whole numbers before the point."""
    return float(f"{value:.3g}") if abs(value) < 1000 else round(value)


def markdown(report: Mapping[str, Any]) -> str:
    """Return the results as a page: a table for each family of instances and kind of planning."""
    machine = report["machine"]
    lines = ["# The benchmark of the paper's Table I, again", "", report["about"], ""]
    lines += [
        f"{report['date']}, {machine['cpu']}, {machine['cores']} cores, Python {machine['python']}, "
        f"numba {machine['numba']}.",
        "",
    ]
    lines += [*(f"- {note}" for note in report["notes"]), ""]
    for family in FAMILIES:
        for kind in KINDS:
            some = [cell for cell in report["cells"] if (cell["family"], cell["kind"]) == (family, kind)]
            if some:
                lines += [f"## {TITLES[kind].capitalize()}, {family}", "", *_table(some), ""]
    return "\n".join(lines)


HEADINGS = (
    "N",
    "ours: s",
    "max s",
    "expanded",
    "MB",
    "max-min: s",
    "max s",
    "expanded",
    "MB",
    "x ours",
    "no h: s",
    "MB",
    "x ours",
    "paper, h: s",
    "paper, no h: s",
)


def _table(some: Sequence[Mapping[str, Any]]) -> list[str]:
    by_place = {(cell["tasks"], cell["method"]): cell for cell in some}
    rows = [list(HEADINGS)]
    kind = some[0]["kind"]
    for tasks in sorted({cell["tasks"] for cell in some}):
        ours, with_h, bare = (by_place.get((tasks, method)) for method in (OURS, MAX_MIN, BARE))
        rows.append(
            [
                str(tasks),
                _show(ours, "seconds"),
                _show(ours, "seconds", "max"),
                _show(ours, "expanded"),
                _show(ours, "peak_mb"),
                _show(with_h, "seconds"),
                _show(with_h, "seconds", "max"),
                _show(with_h, "expanded"),
                _show(with_h, "peak_mb"),
                _show(with_h, "ratio_to_ours"),
                _show(bare, "seconds"),
                _show(bare, "peak_mb"),
                _show(bare, "ratio_to_ours"),
                *(str(PUBLISHED[kind, method].get(tasks, "")) for method in (MAX_MIN, BARE)),
            ]
        )
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEADINGS))]
    lines = [
        "| " + " | ".join(text.rjust(width) for text, width in zip(row, widths, strict=True)) + " |" for row in rows
    ]
    lines.insert(1, "|" + "|".join("-" * (width + 1) + ":" for width in widths) + "|")
    return lines


def _show(cell: Mapping[str, Any] | None, what: str, statistic: str = "median") -> str:
    if cell is None or cell[what] is None:
        return ""
    value = cell[what][statistic]
    if what == "peak_mb" and value < 1:
        return "< 1"
    text = f"{value:,.0f}" if value >= 100 or what == "expanded" else f"{value:.2g}"
    return f">= {text}" if statistic in cell[what]["at_least"] else text
