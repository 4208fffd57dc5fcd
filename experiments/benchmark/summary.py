"""Statistics of a benchmark's runs: medians, maxima, ratios, and tables of them."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean, median
from typing import Any

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
    "points": ("points", fmean),
    "within %": ("within", median),
}
"""Columns of a table by heading: an entry of `Cell.statistic`, and the statistic."""

PAPER = "paper: s"
"""Heading of the column with the published times."""

Runs = dict[int, Record]
"""Records by seed."""

Key = tuple[tuple[str, Any], ...]


@dataclass(frozen=True)
class Cell:
    """Runs that differ only in their seed.

    Attributes:
        what: `Search.what` without the seed.
        runs: their records.
        first: the records of the first method on the same instances.
    """

    what: Mapping[str, Any]
    runs: Runs
    first: Runs

    def statistic(self, entry: str, of: Statistic) -> tuple[float, bool] | None:
        """Return a statistic, and whether it is only a lower bound; None if no run has the entry.

        Args:
            entry: an entry of the records; `megabytes` of memory, or `ratio`: the time over that of the first method.
            of: the statistic. It is a lower bound if greater numbers in place of those of ended runs would change it.
        """
        values = {seed: self._value(entry, seed) for seed in self.runs}
        numbers = {seed: value for seed, value in values.items() if value is not None}
        if not numbers:
            return None
        end = "within" if entry == "within" else "ended"
        open_ended = {seed for seed in numbers if (self.runs[seed][end] is None) == (end == "within")}
        raised = [math.inf if seed in open_ended else number for seed, number in numbers.items()]
        found = of([*numbers.values()])
        return found, of(raised) != found

    def _value(self, entry: str, seed: int) -> float | None:
        run, first = self.runs[seed], self.first.get(seed)
        if entry == "ratio":
            if first is None or first is run or first["ended"]:
                return None
            return float(run["seconds"] / first["seconds"])
        if entry == "megabytes":
            return float(run["peak_bytes"] / 1e6)
        return float(len(run["points"] or ()) if entry == "points" else run[entry] or 0)


def cells(records: Iterable[Record]) -> list[Cell]:
    """Return a cell for each set of runs that differ only in their seed, in the order of the runs."""
    groups: dict[Key, Runs] = {}
    first: dict[Key, Runs] = {}
    for record in records:
        runs = groups.setdefault(_key(record, "seed"), {})
        runs[record["seed"]] = record
        first.setdefault(_key(record, "seed", "method"), runs)
    return [
        Cell(dict(what), runs, first[tuple(entry for entry in what if entry[0] != "method")])
        for what, runs in groups.items()
    ]


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
