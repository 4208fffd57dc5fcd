"""The planner, timed on groups of searches: `python -m experiments.benchmark GROUP...`."""

import os
import platform
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
import numba

import prefplan
from experiments.benchmark.groups import GROUPS, TASKS
from experiments.benchmark.plot import draw
from experiments.benchmark.runs import SINGLE, Record, Search, run_search, warm_up, wrong_fronts
from experiments.benchmark.summary import cells, disagreements, tables
from experiments.cli.command import call, command
from experiments.cli.files import only_writer
from experiments.cli.journal import Journal
from experiments.cli.status import DONE
from experiments.cli.values import PATH, POSITIVE

WRONG = 1
"""Exit status when a plan or a front is wrong, so that its time means nothing."""


@command
@click.argument("groups", nargs=-1, required=True, type=click.Choice(GROUPS), metavar="GROUP...", help="What to time.")
@click.option("--seeds", type=POSITIVE, default="3", metavar="N", help="Instances of each size (default: 3).")
@click.option(
    "--tasks",
    "sizes",
    type=click.IntRange(2, TASKS[SINGLE][-1]),
    multiple=True,
    metavar="N",
    help="Only instances with this number of tasks; may be repeated.",
)
@click.option(
    "--out", type=PATH, default="out/benchmark", metavar="DIR", help="Folder for the results (default: out/benchmark)."
)
def benchmark(groups: Sequence[str], seeds: int, sizes: Sequence[int], out: Path) -> int:
    """Time the planner on groups of searches, each in a separate process, and print tables for each group.

    Times are CPU seconds of the search, its heuristics included, and mostly medians over some instances. After an
    interruption, the same command continues.

    Groups:
      table1           the paper's benchmark (Table I), beside its own method in our compiled kernels, with a figure
      stopped          instances like those of Table I, stopped after some seconds: the gap that is proven by then
      ablation         the planner without one of its components at a time
      large, measured  manipulation models too large to enumerate, also with measured costs
    """
    warm_up()
    if wrong := wrong_fronts():
        return _refuse("fronts differ from the known ones", wrong)
    for group in groups:
        with only_writer(out):
            runs = [run for run in GROUPS[group](seeds) if not sizes or run.what.get("tasks") in sizes]
            records = run_searches(runs, out / f"{group}.jsonl", seeds=seeds, tasks=sorted(sizes))
        if wrong := disagreements(records):
            return _refuse("two methods disagree", wrong)
        found = cells(records)
        print(tables(found), end="\n\n", flush=True)
        if group == "table1":
            draw(found, out / "table1.png")
    return DONE


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry the command out and return its exit status."""
    return call(benchmark, "python -m experiments.benchmark", arguments)


def run_searches(runs: Sequence[Search], path: Path, **options: Any) -> list[Record]:
    """Carry runs out one after the other, except those that are in the journal, and return all records.

    Raises:
        PrefplanError: the journal was written with other options, by another version or on another machine.
    """
    models = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    machine = {"cpu": models[0] if models else platform.machine(), "cores": os.cpu_count()}
    versions = {"prefplan": prefplan.__version__, "python": platform.python_version(), "numba": numba.__version__}
    journal = Journal(path, {**versions, **machine, **options}, key="run")
    # The first search in another kind of model loads further kernels, which should not count.
    runs[0].search(runs[0].instance())
    for number, run in enumerate(runs):
        if number not in journal.done:
            print(f"run {number} of {len(runs)}: {', '.join(map(str, run.what.values()))}", file=sys.stderr)
            journal.add({"run": number, **run_search(run)})
    return [journal.done[number] for number in range(len(runs))]


def _refuse(why: str, wrong: Sequence[str]) -> int:
    print("\n".join([f"{why}, so that times would mean nothing:", *wrong]), file=sys.stderr)
    return WRONG


if __name__ == "__main__":
    sys.exit(main())
