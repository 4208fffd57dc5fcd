"""Groups of cases on which the planner is timed, beside Table I: `python -m experiments.benchmark.cases`."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path

import click

from experiments.benchmark.instances import RANDOM, instance
from experiments.benchmark.large_models import MEASURED, SIZES, Size, large_problem
from experiments.benchmark.runs import FRONT, KINDS, SINGLE, Record, Search, SearchMethod, run_search, search, warm_up
from experiments.benchmark.summary import cells, table
from experiments.cli.command import call, command
from experiments.cli.status import DONE
from experiments.cli.values import Choice, positive
from prefplan import Expression, NamedPreference, Options, Order, Preference, Problem, WeightedSum, load

NAMES = ("problem", "method")
"""Entries with which the rows of a table begin."""

ABLATED = {SINGLE: (8, 10), FRONT: (6, 7, 8)}
"""Numbers of tasks of the problems in `ablation`."""

Preferred = Preference | Sequence[NamedPreference]


def _weights(tasks: int) -> WeightedSum:
    return WeightedSum({f"phi{1 + i}": 1 + i % 3 for i in range(tasks)})


PREFERRED: dict[str, tuple[int, Preferred]] = {
    "weighted sum": (8, _weights(8)),
    "order and weighted sum": (6, [NamedPreference("order", Order()), NamedPreference("sum", _weights(6))]),
    "spread": (7, Expression("max(phi1, phi2) - min(phi1, phi2) + phi3")),
}
"""Numbers of tasks and preferences, other than an order alone, of further fronts in `ablation`."""

DEVICES = {
    "whole planner": Options(),
    "no contraction": Options(contraction=False),
    "no topological sweep": Options(sweep=False),
    "tables of pairs of tasks": Options(heuristic=2),
    "no preference bound": Options(preference_bound=False),
    "no Lagrangian bound": Options(lagrangian=False),
    "no landmarks": Options(landmarks=False),
}
"""The planner without one of its components."""

Group = Callable[[Path, range], Iterator[Search]]
"""Yields runs, given a folder for files and the seeds of instances."""


def _runs(
    problem: str, instances: Iterable[Callable[[], Problem]], searches: Mapping[str, SearchMethod]
) -> list[Search]:
    """Return all searches of all instances of a problem, instance by instance."""
    return [
        Search({"problem": problem, "method": name, "seed": seed}, made, searched)
        for seed, made in enumerate(instances)
        for name, searched in searches.items()
    ]


def _of_size(tasks: int, seeds: range) -> list[Callable[[], Problem]]:
    return [partial(instance, RANDOM, tasks, seed) for seed in seeds]


def many_tasks(folder: Path, seeds: range) -> Iterator[Search]:
    """Yield searches without a time limit."""
    for kind, sizes in {SINGLE: (9, 10, 12, 15), FRONT: (9, 10)}.items():
        for tasks in sizes:
            yield from _runs(f"{kind}, {tasks} tasks", _of_size(tasks, seeds), {"whole": partial(search, kind)})


def stopped(folder: Path, seeds: range) -> Iterator[Search]:
    """Yield searches with a time limit."""
    for kind, tasks, limits in ((SINGLE, 14, (1, 5, 20)), (SINGLE, 20, (1, 5, 20)), (FRONT, 10, (2, 10))):
        searches = {f"{limit} s": partial(search, kind, max_seconds=limit) for limit in limits}
        yield from _runs(f"{kind}, {tasks} tasks", _of_size(tasks, seeds), searches)


def ablation(folder: Path, seeds: range) -> Iterator[Search]:
    """Yield searches without one component of the planner."""
    problems = {(kind, f"{n} tasks"): _of_size(n, seeds) for kind, sizes in ABLATED.items() for n in sizes}
    for name, (n, preference) in PREFERRED.items():
        problems[FRONT, f"{n} tasks, {name}"] = [partial(_with_preference, preference, n, seed) for seed in seeds]
    problems |= {(FRONT, name): [partial(_shipped, name)] * len(seeds) for name in ("case_study_3", "kitchen")}
    for (kind, name), instances in problems.items():
        searches = {device: partial(search, kind, options=options) for device, options in DEVICES.items()}
        yield from _runs(f"{kind}, {name}", instances, searches)


def _with_preference(preference: Preferred, tasks: int, seed: int) -> Problem:
    problem = instance(RANDOM, tasks, seed)
    return Problem(problem.system, problem.tasks, preference)


def _shipped(name: str) -> Problem:
    return load(name).problem()


def large(sizes: Mapping[str, Size], folder: Path, seeds: range) -> Iterator[Search]:
    """Yield searches for the cheapest plan and the front in models too large to enumerate."""
    for name, size in sizes.items():
        made = partial(large_problem, size, folder / "large.toml")
        yield from _runs(name, [made], {kind: partial(search, kind) for kind in KINDS})


GROUPS: dict[str, Group] = {
    "tasks": many_tasks,
    "stopped": stopped,
    "ablation": ablation,
    "large": partial(large, SIZES),
    "measured": partial(large, MEASURED),
}


def told(run: Search) -> Record:
    """Announce a run on stderr, carry it out and return its record."""
    print(", ".join(map(str, run.what.values())), file=sys.stderr)
    return run_search(run)


@command
@click.argument("groups", nargs=-1, required=True, type=Choice(GROUPS), metavar="GROUP...", help="What to time.")
@click.option("--seeds", type=positive, default="3", metavar="N", help="Instances of each size (default: 3).")
def time_groups(groups: Sequence[str], seeds: int) -> int:
    """Time the planner on groups of cases, each search in a separate process, and print a table for each group.

    Times are CPU seconds of the search, its heuristics included, and mostly medians over some instances.

    Groups:
      tasks            instances like those of the paper's Table I, with many tasks
      stopped          the same, stopped after some seconds: the gap that is proven by then
      ablation         the planner without one of its components at a time
      large, measured  manipulation models too large to enumerate, also with measured costs
    """
    warm_up()
    search(FRONT, _shipped("case_study_3"))
    for group in groups:
        with tempfile.TemporaryDirectory() as folder:
            runs = list(GROUPS[group](Path(folder), range(seeds)))
            # The first search of another kind of model loads further kernels.
            runs[0].search(runs[0].instance())
            found = cells(map(told, runs))
        print(table(found, NAMES), end="\n\n", flush=True)
    return DONE


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry the command out and return its exit status."""
    return call(time_groups, "python -m experiments.benchmark.cases", arguments)


if __name__ == "__main__":
    sys.exit(main())
