"""Time the planner on the paper's benchmark (Table I) beside the paper's own method in the same compiled kernels."""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import platform
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from datetime import date
from functools import partial
from pathlib import Path
from typing import Any

import numba
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

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
from experiments.cli.start import INTERRUPTED

SIZES = {SINGLE: (2, 3, 4, 5, 6, 7, 8, 10, 12), FRONT: (2, 3, 4, 5, 6, 7, 8, 9, 10)}
"""Numbers of tasks: the paper's, and on to where minutes or gigabytes end it."""

MANY = {SINGLE: 12, FRONT: 8}
"""The most tasks for which all instances are planned; larger ones take minutes, and are but a few on random cells."""

FEW_SEEDS = 3

YARDSTICK_SIZE = 8
"""The most tasks that leave the yardstick a chance to end within its limits."""

OUR_SECONDS, YARDSTICK_SECONDS = 150, 120

WRONG = 1
"""Exit status when an answer is wrong, so that its time means nothing."""

ABOUT = (
    "Tasks `F(a & F(b) & F(c))` on a 10 x 10 grid with unit costs, from its corner, preferred in the order listed; "
    "medians over instances. `ours` is `Planner.cheapest()` and `Planner.front()`. `max-min` and `no h` are the "
    "paper's method in our compiled kernels, over the whole product: A* with one cost a state for one plan, "
    "BOA* for the front, with the paper's heuristic and with none, and no bound for the second objective. "
    "`x ours` is the median of time over ours on the same instance."
)

NOTES = (
    "Times hold product, heuristics, search and plans; not the model and the tasks' automata (about 1 ms a task), "
    "which all methods are given. Every kernel was compiled and loaded before. "
    "MB is the peak memory of the run's process beyond what it held before the run.",
    f"A run of the yardstick ends after {YARDSTICK_SECONDS} s, one of ours after {OUR_SECONDS} s, and any at "
    f"{MAX_BYTES / 1e9:g} GB; it then counts with what it took, and `>=` marks what is a lower bound for that.",
    "The paper's times are its printed means, of its C++ on its machine, over orderings of its list of formulas, for a "
    "preference that counts delays in positions, not in cost; its columns with h leave out building the heuristic, "
    "ours hold it. They show the trend; the yardstick is what ours compares with.",
    "The yardstick shares our labels and open list: a new label is compared with all undominated ones of its state, "
    "and of equal estimates the last in is the first out. BOA* as published keeps the least preference value of "
    "a state and breaks ties by it.",
    "Before timing, every known front was met, and all methods agreed on all instances that they finished.",
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry the benchmark out and return its exit status."""
    options = _options(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    try:
        warm_up()
        if wrong := wrong_fronts():
            return _refuse("fronts differ from the known ones, so that times would mean nothing", wrong)
        results = carry_out_all(plan_runs(options.tasks, options.seeds, options.yardstick_seeds), options.out)
    except KeyboardInterrupt:
        print(f"interrupted; {_journal(options.out)} has what is done, and the same call goes on", file=sys.stderr)
        return INTERRUPTED
    if wrong := disagreements(results):
        return _refuse("two methods disagree, so that times would mean nothing", wrong)
    yardstick, few = (min(options.seeds, most) for most in (options.yardstick_seeds, FEW_SEEDS))
    instances = (
        f"Instances of each size: {options.seeds} for ours, {yardstick} of them for the yardstick; "
        f"{few} for fronts of over {MANY[FRONT]} tasks."
    )
    report = write(results, options.out, [instances, *([options.note] if options.note else [])])
    print(markdown(report))
    _journal(options.out).unlink(missing_ok=True)
    return 0


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tasks", type=_span, default=None, help="numbers of tasks, like 2-8 (default: 2-12)")
    parser.add_argument("--seeds", type=int, default=None, help="instances of each size (default: 10)")
    parser.add_argument("--yardstick-seeds", type=int, default=None, help="of these, for the yardstick (default: 3)")
    parser.add_argument("--quick", action="store_true", help="2 to 5 tasks, 3 instances: less than a minute")
    parser.add_argument("--out", type=Path, default=Path("out", "table1"), help="folder (default: out/table1)")
    parser.add_argument("--note", help="remark to keep with the results")
    options = parser.parse_args(arguments)
    tasks, seeds = ((2, 5), 3) if options.quick else ((2, 12), 10)
    options.tasks = options.tasks or range(tasks[0], tasks[1] + 1)
    options.seeds = seeds if options.seeds is None else options.seeds
    options.yardstick_seeds = 3 if options.yardstick_seeds is None else options.yardstick_seeds
    return options


def _span(text: str) -> range:
    first, _, last = text.partition("-")
    span = range(int(first), int(last or first) + 1)
    if not span or span[0] < 2 or span[-1] > SIZES[SINGLE][-1]:
        raise argparse.ArgumentTypeError(f"{text!r} is not a range like 2-8 within 2-{SIZES[SINGLE][-1]}")
    return span


def plan_runs(sizes: range, seeds: int, yardstick_seeds: int) -> list[BenchmarkRun]:
    """Return all runs, small instances first."""
    runs = []
    for tasks in sizes:
        for kind in KINDS:
            for family in FAMILIES:
                few = tasks > MANY[kind]
                if tasks not in SIZES[kind] or (few and family != RANDOM):
                    continue
                ours = min(seeds, FEW_SEEDS) if few else seeds
                runs += [BenchmarkRun(family, kind, OURS, tasks, seed, OUR_SECONDS) for seed in range(ours)]
                for method in YARDSTICKS if tasks <= YARDSTICK_SIZE else ():
                    numbers = range(min(yardstick_seeds, seeds))
                    runs += [BenchmarkRun(family, kind, method, tasks, seed, YARDSTICK_SECONDS) for seed in numbers]
    return runs


def carry_out_all(runs: Sequence[BenchmarkRun], folder: Path) -> dict[BenchmarkRun, Timing]:
    """Carry runs out one after the other, except those that an interrupted benchmark has done."""
    conditions = _conditions()
    journal = _journal(folder)
    done = dict(_read(journal, conditions))
    with journal.open("w") as file, _progress(len(runs)) as advance:

        def keep(run: BenchmarkRun) -> None:
            entry = {"conditions": conditions, "run": asdict(run), "outcome": asdict(done[run])}
            print(json.dumps(entry), file=file, flush=True)

        for run in done:
            keep(run)
        for run in runs:
            if run not in done:
                label = f"{run.kind}, {run.tasks} tasks, {run.method}, seed {run.seed}"
                done[run] = carry_out(run, partial(advance, 0, label))
                keep(run)
            advance(1, "")
    return {run: done[run] for run in runs}


def _journal(folder: Path) -> Path:
    return folder / "table1.runs.jsonl"


def _read(journal: Path, conditions: str) -> Iterator[tuple[BenchmarkRun, Timing]]:
    """Yield the runs of a journal that were carried out under the same conditions."""
    for line in journal.read_text().splitlines() if journal.exists() else []:
        try:
            entry = json.loads(line)
        except ValueError:
            continue
        if entry["conditions"] == conditions:
            outcome = entry["outcome"]
            if outcome["points"] is not None:
                outcome["points"] = tuple(map(tuple, outcome["points"]))
            yield BenchmarkRun(**entry["run"]), Timing(**outcome)


def _conditions() -> str:
    """Return a digest of planner and machine: times taken under others must not mix."""
    digest = hashlib.sha256(json.dumps(_machine()).encode())
    for source in sorted(Path(prefplan.__file__).parent.rglob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


@contextmanager
def _progress(total: int) -> Iterator[Callable[[int, str], None]]:
    """Show a bar on stderr if it is a terminal.

    It is drawn by calls only: a thread that draws might hold a lock while the process forks.
    """
    console = Console(stderr=True)
    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.description}"))
    bar = Progress(*columns, console=console, transient=True, auto_refresh=False, disable=not console.is_terminal)
    with bar:
        task = bar.add_task("", total=total)

        def advance(done: int, label: str) -> None:
            bar.update(task, advance=done, description=label, refresh=True)

        yield advance


def _machine() -> dict[str, Any]:
    """Return what times depend on."""
    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        models = [line.partition(":")[2].strip() for line in info.read_text().splitlines() if "model name" in line]
        cpu = models[0] if models else cpu
    return {
        "cpu": cpu,
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        "numba": numba.__version__,
    }


def write(results: dict[BenchmarkRun, Timing], folder: Path, remarks: Sequence[str]) -> dict[str, Any]:
    """Write the results as JSON, a page and a picture, and return what the JSON holds."""
    report: dict[str, Any] = {
        "about": ABOUT,
        "notes": [*NOTES, *remarks],
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
