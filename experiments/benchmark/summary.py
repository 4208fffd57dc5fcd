"""Statistics of a benchmark's runs: medians, maxima, ratios, and tables of them."""

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from statistics import fmean, median
from typing import Any, NamedTuple

from experiments.benchmark.published import PUBLISHED
from experiments.benchmark.runs import FRONT, SINGLE, Record

FOUND = ("run", "seconds", "expanded", "points", "within", "ended", "peak_bytes", "baseline_bytes")
"""Entries of a record that are not of `Search.what`."""

Statistic = Callable[[Sequence[float]], float]

COLUMNS: dict[str, tuple[str, Statistic]] = {
    "s": ("seconds", median),
    "at most s": ("seconds", max),
    "x first": ("ratio", median),
    "labels expanded": ("expanded", median),
    "MB": ("megabytes", median),
    "points": ("count", fmean),
    "within %": ("within", median),
}
"""Columns of a table by heading: an entry of a run of a `Cell`, and the statistic."""

PAPER = "paper: s"
"""Heading of the column with the published times."""

Key = tuple[tuple[str, Any], ...]


class Cell(NamedTuple):
    """Runs that differ only in their seed.

    Attributes:
        what: `Search.what` without the seed.
        runs: their records, and of each the `ratio` of its time to that of the first method on the same instance (None
            for that method, or if that run was ended), the `count` of points, and its peak memory in `megabytes`.
    """

    what: Mapping[str, Any]
    runs: list[Record]

    def statistic(self, entry: str, of: Statistic) -> tuple[float, bool] | None:
        """Return a statistic of an entry, and whether it is only a lower bound; None if no run has the entry.

        It is a lower bound if greater numbers in place of those of ended runs, or of what is not proven, would change
        it.
        """
        told = [run for run in self.runs if run[entry] is not None or entry == "within"]
        if not told:
            return None
        numbers = [float(run[entry] or 0) for run in told]
        is_open = [run["within"] is None if entry == "within" else run["ended"] is not None for run in told]
        raised = [math.inf if is_bound else number for number, is_bound in zip(numbers, is_open, strict=True)]
        return of(numbers), of(raised) != of(numbers)


def cells(records: Iterable[Record]) -> list[Cell]:
    """Return a cell for each set of runs that differ only in their seed, in the order of the runs."""
    runs = defaultdict[Key, list[Record]](list)
    firsts: dict[Key, Record] = {}
    for record in records:
        first = firsts.setdefault(_key(record, "method"), record)
        ratio = None if first is record or first["ended"] else record["seconds"] / first["seconds"]
        more = {"ratio": ratio, "count": len(record["points"] or ()), "megabytes": record["peak_bytes"] / 1e6}
        runs[_key(record, "seed")].append(record | more)
    return [Cell(dict(what), found) for what, found in runs.items()]


def disagreements(records: Sequence[Record]) -> list[str]:
    """Return the instances on which two methods that finished find different fronts or least costs."""
    found: dict[Key, dict[str, Any]] = {}
    for record in records:
        if record["points"] is not None:
            found.setdefault(_key(record, "method"), {})[record["method"]] = record["points"]
            if record["kind"] == FRONT:
                single = _key(record | {"kind": SINGLE}, "method")
                found.setdefault(single, {})[f"front, {record['method']}"] = [record["points"][0][:1]]
    return [f"{dict(what)}: {said}" for what, said in found.items() if len(set(map(str, said.values()))) > 1]


def _key(record: Record, *without: str) -> Key:
    return tuple((name, value) for name, value in record.items() if name not in (*FOUND, *without))


def tables(found: Iterable[Cell]) -> str:
    """Return a Markdown table for each kind of search, and family of instances, with a row for each cell."""
    parts: dict[str, list[Cell]] = {}
    for cell in found:
        parts.setdefault(", ".join(map(str, [*cell.what.values()][:-2])), []).append(cell)
    return "\n\n".join(f"## {heading}\n\n{table(part)}" for heading, part in parts.items())


def table(found: Sequence[Cell]) -> str:
    """Return a Markdown table of cells of one kind of search, with the paper's times if it has any."""
    published = [PUBLISHED.get((cell.what["kind"], cell.what["method"]), {}) for cell in found]
    paper = [PAPER] if any(published) else []
    rows = [[*[*found[0].what][-2:], *paper, *COLUMNS]]
    for cell, seconds in zip(found, published, strict=True):
        names = [*cell.what.values()][-2:]
        times = [seconds.get(cell.what["tasks"], "")] if paper else []
        rows.append([*map(str, [*names, *times]), *(_show(cell, *column) for column in COLUMNS.values())])
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    rows.insert(1, ["-" * (width - 1) + ":" for width in widths])
    lines = (" | ".join(map(str.rjust, cells, widths)) for cells in rows)
    return "\n".join(f"| {line} |" for line in lines)


def _show(cell: Cell, entry: str, of: Statistic) -> str:
    found = cell.statistic(entry, of)
    if found is None:
        return ""
    value, is_bound = found
    if entry == "megabytes" and value < 1:
        return "< 1"
    text = f"{value:,.0f}" if value >= 100 or entry == "expanded" else f"{value:.2g}"
    return f">= {text}" if is_bound else text
