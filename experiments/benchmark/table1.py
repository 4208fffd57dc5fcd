"""Time the planner on the paper's benchmark (Table I) beside the paper's own method in the same compiled kernels."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
import sys
from collections.abc import Mapping, Sequence
from datetime import date
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import click
import numba

import experiments.benchmark
import prefplan
from experiments.benchmark.instances import FAMILIES, RANDOM, instance
from experiments.benchmark.plot import TITLES, draw
from experiments.benchmark.published import PUBLISHED
from experiments.benchmark.runs import (
    FRONT,
    KINDS,
    MAX_BYTES,
    OURS,
    SINGLE,
    YARDSTICKS,
    Record,
    Search,
    method,
    run_search,
    warm_up,
    wrong_fronts,
)
from experiments.benchmark.summary import EFFORT, cells, disagreements, table
from experiments.cli.command import call, command
from experiments.cli.files import make_folder, write_json
from experiments.cli.journal import Journal
from experiments.cli.status import DONE
from experiments.cli.values import PATH, positive

SIZES = {SINGLE: (2, 3, 4, 5, 6, 7, 8, 10, 12), FRONT: (2, 3, 4, 5, 6, 7, 8, 9, 10, 11)}
"""Numbers of tasks: those of the paper and more, up to instances that take minutes or gigabytes."""

MANY = {SINGLE: 12, FRONT: 8}
"""Greatest number of tasks with all instances; above it, only `FEW_SEEDS` are run, on random cells."""

FEW_SEEDS = 3
"""Greatest number of instances for the yardstick, and for fronts of more tasks than `MANY`."""

YARDSTICK_SIZE = 8
"""Greatest number of tasks that the yardstick can finish within its limits."""

OUR_SECONDS, YARDSTICK_SECONDS = 150, 120
"""Time limits of a run."""

WRONG = 1
"""Exit status when a plan or a front is wrong, so that its time means nothing."""

PAPER = "paper: s"
"""Heading of the column with the published times."""

ABOUT = (
    "Tasks `F(a & F(b) & F(c))` on a 10 x 10 grid with unit costs, starting in a corner, with order preference; "
    "medians over instances. `ours` is `Planner.cheapest()` and `Planner.front()`. `max-min` and `no heuristic` are "
    "the paper's method in our compiled kernels, on the whole product: A* with one cost per state for one plan, BOA* "
    "for the front, with the paper's heuristic or none, and no bound for the second objective. These two are the "
    "yardstick. `x first` is the median of the ratio of the time to ours on the same instance."
)

NOTES = (
    "Times are CPU seconds. They include product, heuristics, search and plans, but not the model and the tasks' "
    "automata (about 1 ms per task), which all methods are given. Every kernel was compiled and loaded before. "
    "MB is the peak memory of the run's process beyond its memory before the run.",
    f"A run of the yardstick ends after {YARDSTICK_SECONDS} s, one of ours after {OUR_SECONDS} s, and any at "
    f"{MAX_BYTES / 1e9:g} GB; it then counts with the time and memory used, and `>=` marks statistics that are "
    "therefore lower bounds.",
    "The paper's times are its printed means, of its C++ on its machine, over orderings of its list of formulas, for a "
    "preference that counts delays in positions, not in cost; those with the heuristic exclude computing it, ours "
    "include it. They show the trend; ours should be compared with the yardstick.",
    "The yardstick uses our labels and open list: a new label is compared with all undominated ones of its state, "
    "and ties between equal estimates are broken last in, first out. BOA* as published keeps the least preference "
    "penalty of each state and breaks ties by it.",
    "Before timing, our search reproduced every known front; all methods agreed on all instances that they finished.",
)


@command
@click.option(
    "--tasks",
    "sizes",
    type=click.IntRange(2, SIZES[SINGLE][-1]),
    multiple=True,
    metavar="N",
    help="Only this number of tasks; may be repeated.",
)
@click.option("--seeds", type=positive, metavar="N", help="Instances of each size (default: 10; --quick: 3).")
@click.option("--quick", is_flag=True, help="2 to 5 tasks, 3 instances: less than a minute.")
@click.option(
    "--out", type=PATH, default="out/table1", metavar="DIR", help="Folder for the results (default: out/table1)."
)
def benchmark(sizes: Sequence[int], seeds: int | None, quick: bool, out: Path) -> int:
    """Time the planner on the paper's benchmark (Table I), beside the paper's own method in the same compiled kernels.

    After an interruption, the same command continues.
    """
    seeds = seeds or (3 if quick else 10)
    runs = plan_runs(sorted(set(sizes or (range(2, 6) if quick else SIZES[SINGLE] + SIZES[FRONT]))), seeds)
    make_folder(out)
    warm_up()
    if wrong := wrong_fronts():
        return _refuse("fronts differ from the known ones, so that times would mean nothing", wrong)
    results = run_searches(runs, out / "table1.runs.jsonl")
    if wrong := disagreements(results):
        return _refuse("two methods disagree, so that times would mean nothing", wrong)
    few = min(seeds, FEW_SEEDS)
    instances = (
        f"Instances of each size: {seeds} for ours, {few} of them for the yardstick and for fronts of more than "
        f"{MANY[FRONT]} tasks."
    )
    print(markdown(write(results, out, instances)))
    return DONE


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry the command out and return its exit status."""
    return call(benchmark, "python -m experiments.benchmark.table1", arguments)


def plan_runs(sizes: Sequence[int], seeds: int) -> list[Search]:
    """Return all runs, those with few tasks first, and for each instance our method first."""
    runs = []
    for tasks, kind, family in product(sizes, KINDS, FAMILIES):
        many, few = tasks <= MANY[kind], min(seeds, FEW_SEEDS)
        if tasks not in SIZES[kind] or not (many or family == RANDOM):
            continue
        counts = {OURS: seeds if many else few}
        if tasks <= YARDSTICK_SIZE:
            counts |= dict.fromkeys(YARDSTICKS, few)
        for name, count in counts.items():
            what = {"family": family, "kind": kind, "tasks": tasks, "method": name}
            searched = method(kind, name, max_seconds=OUR_SECONDS if name == OURS else YARDSTICK_SECONDS)
            runs += [Search(what | {"seed": i}, partial(instance, family, tasks, i), searched) for i in range(count)]
    return runs


def run_searches(runs: Sequence[Search], path: Path) -> list[Record]:
    """Carry runs out one after the other, except those that are in the journal, and return all records.

    Raises:
        PrefplanError: the journal was written for other runs, by other sources or on another machine.
    """
    conditions = hashlib.sha256(json.dumps([_machine(), [run.what for run in runs]]).encode())
    for package in (prefplan, experiments.benchmark):
        for source in sorted(Path(str(package.__file__)).parent.rglob("*.py")):
            conditions.update(source.read_bytes())
    header = {"prefplan": prefplan.__version__, "conditions": conditions.hexdigest()}
    with Journal(path, header, key="run") as journal:
        for number, run in enumerate(runs):
            if number not in journal.done:
                print(f"run {number} of {len(runs)}: {', '.join(map(str, run.what.values()))}", file=sys.stderr)
                journal.add({"run": number, **run_search(run)})
        return [{name: value for name, value in journal.done[i].items() if name != "run"} for i in range(len(runs))]


def _machine() -> dict[str, Any]:
    """Return the hardware and software on which times depend."""
    models = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    return {
        "cpu": models[0] if models else platform.machine(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        "numba": numba.__version__,
    }


def write(records: Sequence[Record], folder: Path, remark: str) -> dict[str, Any]:
    """Write the results as JSON, Markdown and a picture, and return the contents of the JSON file."""
    report: dict[str, Any] = {
        "about": ABOUT,
        "notes": [*NOTES, remark],
        "date": date.today().isoformat(),
        "machine": _machine(),
        "limits": {"seconds": {"ours": OUR_SECONDS, "yardstick": YARDSTICK_SECONDS}, "bytes": MAX_BYTES},
        "cells": cells(records),
    }
    write_json(folder / "table1.json", report)
    (folder / "table1.md").write_text(markdown(report))
    draw(report, folder / "table1.png")
    return report


def markdown(report: Mapping[str, Any]) -> str:
    """Return the results as Markdown, with a table for each family of instances and kind of search."""
    machine = report["machine"]
    made = f"{machine['cpu']}, {machine['cores']} cores, Python {machine['python']}, numba {machine['numba']}"
    lines = ["# The benchmark of the paper's Table I", "", report["about"], "", f"{report['date']}, {made}.", ""]
    lines += [*(f"- {note}" for note in report["notes"]), ""]
    for family in FAMILIES:
        for kind in KINDS:
            found = [cell for cell in report["cells"] if (cell["family"], cell["kind"]) == (family, kind)]
            if found:
                lines += [f"## {TITLES[kind].capitalize()}, {family}", "", table_of(kind, found), ""]
    return "\n".join(lines)


def table_of(kind: str, found: Sequence[Mapping[str, Any]]) -> str:
    """Return a table of the cells of one family and kind of search, with the paper's times."""
    published = [PUBLISHED.get((kind, cell["method"]), {}).get(cell["tasks"], "") for cell in found]
    rows = [{**cell, PAPER: seconds} for cell, seconds in zip(found, published, strict=True)]
    return table(rows, ("tasks", "method", PAPER), EFFORT)


def _refuse(why: str, wrong: Sequence[str]) -> int:
    print("\n".join([f"{why}:", *wrong]), file=sys.stderr)
    return WRONG


if __name__ == "__main__":
    sys.exit(main())
