"""Time the planner on the paper's benchmark (Table I) beside the paper's own method in the same compiled kernels."""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import platform
import re
import sys
from collections.abc import Sequence
from dataclasses import asdict
from datetime import date
from pathlib import Path
from typing import Any

import numba

import prefplan
from experiments.benchmark.instances import FAMILIES, RANDOM
from experiments.benchmark.plot import draw
from experiments.benchmark.runs import (
    FRONT,
    KINDS,
    MAX_BYTES,
    OURS,
    SINGLE,
    YARDSTICKS,
    BenchmarkRun,
    Timing,
    carry_out,
    warm_up,
    wrong_fronts,
)
from experiments.benchmark.summary import cells, disagreements, markdown
from experiments.cli.files import make_folder
from experiments.cli.journal import Journal
from experiments.cli.status import BAD_INPUT, DONE, INTERRUPTED

SIZES = {SINGLE: (2, 3, 4, 5, 6, 7, 8, 10, 12), FRONT: (2, 3, 4, 5, 6, 7, 8, 9, 10, 11)}
"""Numbers of tasks: those of the paper and more, up to minutes or gigabytes."""

MANY = {SINGLE: 12, FRONT: 8}
"""Greatest number of tasks with all instances; larger fronts take minutes: only `FEW_SEEDS`, on random cells."""

FEW_SEEDS = 3
"""Greatest number of instances for the yardstick, and for fronts of more tasks than `MANY`."""

YARDSTICK_SIZE = 8
"""Greatest number of tasks that the yardstick can finish within its limits."""

OUR_SECONDS, YARDSTICK_SECONDS = 150, 120
"""Time limits of a run."""

WRONG = 1
"""Exit status when a plan or a front is wrong, so that its time means nothing."""

ABOUT = (
    "Tasks `F(a & F(b) & F(c))` on a 10 x 10 grid with unit costs, from its corner, preferred in the order listed; "
    "medians over instances. `ours` is `Planner.cheapest()` and `Planner.front()`. `max-min` and `no h` are the "
    "paper's method in our compiled kernels, over the whole product: A* with one cost a state for one plan, "
    "BOA* for the front, with the paper's heuristic and with none, and no bound for the second objective. "
    "`x ours` is the median of time over ours on the same instance."
)

NOTES = (
    "Times are CPU seconds. They hold product, heuristics, search and plans; not the model and the tasks' automata "
    "(about 1 ms a task), which all methods are given. Every kernel was compiled and loaded before. "
    "MB is the peak memory of the run's process beyond what it held before the run.",
    f"A run of the yardstick ends after {YARDSTICK_SECONDS} s, one of ours after {OUR_SECONDS} s, and any at "
    f"{MAX_BYTES / 1e9:g} GB; it then counts with what it took, and `>=` marks what is a lower bound for that.",
    "The paper's times are its printed means, of its C++ on its machine, over orderings of its list of formulas, for a "
    "preference that counts delays in positions, not in cost; its columns with h leave out building the heuristic, "
    "ours hold it. They show the trend; the yardstick is what ours compares with.",
    "The yardstick shares our labels and open list: a new label is compared with all undominated ones of its state, "
    "and of equal estimates the last in is the first out. BOA* as published keeps the least preference penalty of "
    "a state and breaks ties by it.",
    "Before timing, every known front was met, and all methods agreed on all instances that they finished.",
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry the benchmark out and return its exit status."""
    options = _options(arguments)
    runs = plan_runs(options.tasks, options.seeds)
    journal = options.out / "table1.runs.jsonl"
    try:
        make_folder(options.out)
        warm_up()
        if wrong := wrong_fronts():
            return _refuse("fronts differ from the known ones, so that times would mean nothing", wrong)
        results = carry_out_all(runs, journal)
    except KeyboardInterrupt:
        print(f"interrupted; {journal} has the finished runs, the same command goes on", file=sys.stderr)
        return INTERRUPTED
    except prefplan.PrefplanError as error:
        print(f"table1: {error}", file=sys.stderr)
        return BAD_INPUT
    if wrong := disagreements(results):
        return _refuse("two methods disagree, so that times would mean nothing", wrong)
    few = min(options.seeds, FEW_SEEDS)
    instances = (
        f"Instances of each size: {options.seeds} for ours, {few} of them for the yardstick and for fronts of over "
        f"{MANY[FRONT]} tasks."
    )
    report = write(results, options.out, instances)
    print(markdown(report))
    journal.unlink()
    return DONE


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tasks", type=_span, help="numbers of tasks, like 2-8 (default: 2-12)")
    parser.add_argument("--seeds", type=int, help="instances of each size (default: 10)")
    parser.add_argument("--quick", action="store_true", help="2 to 5 tasks, 3 instances: less than a minute")
    parser.add_argument("--out", type=Path, default=Path("out", "table1"), help="folder (default: out/table1)")
    options = parser.parse_args(arguments)
    options.tasks = options.tasks or (range(2, 6) if options.quick else range(2, 13))
    if options.seeds is None:
        options.seeds = 3 if options.quick else 10
    return options


def _span(text: str) -> range:
    first, _, last = text.partition("-")
    span = range(int(first), int(last or first) + 1)
    if not span or span[0] < 2 or span[-1] > SIZES[SINGLE][-1]:
        raise argparse.ArgumentTypeError(f"{text!r} is not a range like 2-8 within 2-{SIZES[SINGLE][-1]}")
    return span


def plan_runs(sizes: range, seeds: int) -> list[BenchmarkRun]:
    """Return all runs, small instances first."""
    runs = []
    for tasks in sizes:
        for kind in KINDS:
            for family in FAMILIES:
                many = tasks <= MANY[kind]
                if tasks not in SIZES[kind] or not (many or family == RANDOM):
                    continue
                few = range(min(seeds, FEW_SEEDS))
                ours = range(seeds) if many else few
                runs += [BenchmarkRun(family, kind, OURS, tasks, seed, OUR_SECONDS) for seed in ours]
                for method in YARDSTICKS if tasks <= YARDSTICK_SIZE else ():
                    runs += [BenchmarkRun(family, kind, method, tasks, seed, YARDSTICK_SECONDS) for seed in few]
    return runs


def carry_out_all(runs: Sequence[BenchmarkRun], path: Path) -> dict[BenchmarkRun, Timing]:
    """Carry runs out one after the other, except those in the journal of an interrupted benchmark.

    Raises:
        PrefplanError: the journal is one of other runs, another planner or another machine.
    """
    conditions = hashlib.sha256(json.dumps([_machine(), [asdict(run) for run in runs]]).encode())
    for source in sorted(Path(prefplan.__file__).parent.rglob("*.py")):
        conditions.update(source.read_bytes())
    header = {"prefplan": prefplan.__version__, "conditions": conditions.hexdigest()}
    with Journal(path, header, key="run") as journal:
        for number, run in enumerate(runs):
            if number not in journal.done:
                what = f"{run.kind}, {run.tasks} tasks, {run.method}, seed {run.seed}"
                print(f"run {number} of {len(runs)}: {what}", file=sys.stderr)
                journal.add({"run": number, "timing": asdict(carry_out(run))})
        return {run: _timing(journal.done[number]["timing"]) for number, run in enumerate(runs)}


def _timing(values: dict[str, Any]) -> Timing:
    points = values["points"]
    return Timing(**values | {"points": None if points is None else tuple(map(tuple, points))})


def _machine() -> dict[str, Any]:
    """Return the hardware and software that times depend on."""
    models = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    return {
        "cpu": models[0] if models else platform.machine(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        "numba": numba.__version__,
    }


def write(results: dict[BenchmarkRun, Timing], folder: Path, remark: str) -> dict[str, Any]:
    """Write the results as JSON, a page and a picture, and return what the JSON holds."""
    report: dict[str, Any] = {
        "about": ABOUT,
        "notes": [*NOTES, remark],
        "date": date.today().isoformat(),
        "machine": _machine(),
        "limits": {"seconds": {"ours": OUR_SECONDS, "yardstick": YARDSTICK_SECONDS}, "bytes": MAX_BYTES},
        "cells": cells(results),
        "runs": [{**asdict(run), **asdict(outcome)} for run, outcome in results.items()],
    }
    (folder / "table1.json").write_text(json.dumps(report, indent=1) + "\n")
    (folder / "table1.md").write_text(markdown(report))
    draw(report, folder / "table1.png")
    return report


def _refuse(why: str, wrong: Sequence[str]) -> int:
    print("\n".join([f"{why}:", *wrong]), file=sys.stderr)
    return WRONG


if __name__ == "__main__":
    sys.exit(main())
