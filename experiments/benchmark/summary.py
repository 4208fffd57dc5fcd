"""Statistics of a benchmark's runs: medians, maxima, ratios, and a table of them."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from experiments.benchmark.runs import FRONT, SINGLE, Record

MEGABYTE = 1e6

FOUND = ("seconds", "expanded", "points", "within", "ended", "peak_bytes", "baseline_bytes")
"""Entries of a record with results; the others identify the run."""

STATISTICS: dict[str, Callable[[Sequence[float]], float]] = {
    "median": statistics.median,
    "mean": statistics.fmean,
    "min": min,
    "max": max,
}

TableColumns = tuple[tuple[str, str, str], ...]
"""Columns of a table: heading, entry of the cell, and statistic; `ratio` is the time over the first method's."""

EFFORT: TableColumns = (
    ("s", "seconds", "median"),
    ("at most s", "seconds", "max"),
    ("x first", "ratio", "median"),
    ("labels expanded", "expanded", "median"),
    ("MB", "peak_mb", "median"),
)
COLUMNS: TableColumns = (*EFFORT, ("points", "points", "mean"), ("within %", "within", "median"))


def _key(record: Record, *without: str) -> tuple[tuple[str, Any], ...]:
    return tuple((name, value) for name, value in record.items() if name not in (*FOUND, *without))


def disagreements(records: Sequence[Record]) -> list[str]:
    """Return the instances on which two methods that finished find different fronts or least costs."""
    found: dict[tuple[tuple[str, Any], ...], dict[str, Any]] = {}
    for record in records:
        if record["points"] is not None:
            found.setdefault(_key(record, "method"), {})[record["method"]] = record["points"]
            if record["kind"] == FRONT:
                single = _key(record | {"kind": SINGLE}, "method")
                found.setdefault(single, {})[f"front, {record['method']}"] = [record["points"][0][:1]]
    return [f"{dict(what)}: {said}" for what, said in found.items() if len(set(map(str, said.values()))) > 1]


def cells(records: Iterable[Record]) -> list[dict[str, Any]]:
    """Return a cell with statistics for each set of runs that differ only in their seed, in the order of the runs."""
    groups: dict[tuple[tuple[str, Any], ...], dict[int, Record]] = {}
    first: dict[tuple[tuple[str, Any], ...], dict[int, Record]] = {}
    for record in records:
        by_seed = groups.setdefault(_key(record, "seed"), {})
        by_seed[record["seed"]] = record
        first.setdefault(_key(record, "seed", "method"), by_seed)
    return [
        {**dict(what), **_cell([*by_seed.values()])}
        | {"ratio": _ratio(by_seed, first[tuple(entry for entry in what if entry[0] != "method")])}
        for what, by_seed in groups.items()
    ]


def _cell(records: Sequence[Record]) -> dict[str, Any]:
    ended = [record["ended"] is not None for record in records]
    return {
        "runs": len(records),
        "ended": [record["ended"] for record in records if record["ended"]],
        "seconds": _spread([record["seconds"] for record in records], ended),
        "expanded": _spread([record["expanded"] for record in records], ended),
        "peak_mb": _spread([record["peak_bytes"] / MEGABYTE for record in records], ended),
        "points": _spread([len(record["points"] or ()) for record in records], ended),
        "within": _spread([record["within"] or 0 for record in records], [r["within"] is None for r in records]),
        "baseline_mb": round(max(record["baseline_bytes"] for record in records) / MEGABYTE, 1),
    }


def _ratio(runs: Mapping[int, Record], first: Mapping[int, Record]) -> dict[str, Any] | None:
    """Return the time of a method over that of the first one on the same instances."""
    both = [seed for seed in runs if runs is not first and seed in first and first[seed]["ended"] is None]
    ratios = [runs[seed]["seconds"] / first[seed]["seconds"] for seed in both]
    return _spread(ratios, [runs[seed]["ended"] is not None for seed in both]) if both else None


def _spread(numbers: Sequence[float], is_bound: Sequence[bool]) -> dict[str, Any]:
    """Return statistics of numbers of which some are only lower bounds.

    `at_least` names those that are lower bounds themselves: greater values would change them.
    """
    raised = [math.inf if bound else value for value, bound in zip(numbers, is_bound, strict=True)]
    at_least = [name for name, statistic in STATISTICS.items() if statistic(raised) != statistic(numbers)]
    return {name: _rounded(statistic(numbers)) for name, statistic in STATISTICS.items()} | {"at_least": at_least}


def _rounded(value: float) -> float:
    """Return a number rounded to three significant digits, or from 1000 on to a whole number."""
    return float(f"{value:.3g}") if abs(value) < 1000 else round(value)


def table(found: Iterable[Mapping[str, Any]], names: Sequence[str], columns: TableColumns = COLUMNS) -> str:
    """Return a Markdown table with a row for each cell, which begins with the entries that `names` lists."""
    rows = [[*names, *(heading for heading, *_ in columns)]]
    rows += [[*(str(cell[name]) for name in names), *(_show(cell, *which) for _, *which in columns)] for cell in found]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    rows.insert(1, ["-" * (width - 1) + ":" for width in widths])
    lines = (" | ".join(map(str.rjust, cells, widths)) for cells in rows)
    return "\n".join(f"| {line} |" for line in lines)


def _show(cell: Mapping[str, Any], what: str, statistic: str) -> str:
    if cell.get(what) is None:
        return ""
    value = cell[what][statistic]
    if what == "peak_mb" and value < 1:
        return "< 1"
    text = f"{value:,.0f}" if value >= 100 or what == "expanded" else f"{value:.2g}"
    return f">= {text}" if statistic in cell[what]["at_least"] else text
