"""Many tasks of the paper's benchmark: CPU time to the end, also of fronts within some percent, and proven gaps."""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Sequence

from experiments.benchmark.instances import RANDOM, instance
from prefplan import Planner, Problem, UnfinishedError

PLAN, FRONT = "plan", "front"

FINISHED = ("N", "CPU s, median", "CPU s, most", "labels expanded, median", "MB of the search, most")
STOPPED = ("N", "stopped after s", "gap: least", "median", "most", "without any")
WITHIN = ("N", "within", "CPU s, median", "CPU s, most", "labels expanded, median", "points, mean")
"""Headings of the tables."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a table, and return the exit status."""
    parser = argparse.ArgumentParser(prog="many_tasks", description=__doc__)
    parser.add_argument("what", choices=(PLAN, FRONT), help="the cheapest plan, or the whole front")
    parser.add_argument("--tasks", type=int, nargs="+", required=True, metavar="N", help="sizes")
    parser.add_argument("--seeds", type=int, default=3, help="instances of each size (default: 3)")
    parser.add_argument("--stop", type=float, nargs="*", metavar="S", help="stop after so many seconds each")
    parser.add_argument("--within", type=float, nargs="*", metavar="P", help="fronts within so many percent, 0: exact")
    options = parser.parse_args(arguments)
    # The first search loads compiled code.
    for kind in (PLAN, FRONT):
        _stopped(kind, instance(RANDOM, 10, 0), 1)
    _finished(options.what, instance(RANDOM, 3, 0))
    headings: tuple[str, ...] = FINISHED
    if options.within or options.stop:
        headings = WITHIN if options.within else STOPPED
    print("|", " | ".join(headings), "|\n|", " | ".join(["---"] * len(headings)), "|")
    for tasks in options.tasks:
        problems = [instance(RANDOM, tasks, seed) for seed in range(options.seeds)]
        rows = [_within(problems, percent) for percent in options.within or ()]
        rows += [_gaps(options.what, problems, limit) for limit in options.stop or ()]
        for row in rows or [_whole(options.what, problems)]:
            print(f"| {tasks} | {row} |", flush=True)
    return 0


def _whole(what: str, problems: Sequence[Problem]) -> str:
    """Return the rest of the row of searches to their end."""
    seconds, expanded, size = zip(*(_finished(what, problem) for problem in problems), strict=True)
    times = f"{statistics.median(seconds):.2f} | {max(seconds):.2f}"
    return f"{times} | {statistics.median(expanded):,.0f} | {max(size) / 1e6:.0f}"


def _gaps(what: str, problems: Sequence[Problem], limit: float) -> str:
    """Return the rest of the row of searches that are stopped."""
    gaps = [_stopped(what, problem, limit) for problem in problems]
    known = sorted(gap for gap in gaps if gap is not None)
    shown = [f"{gap:.1f} %" for gap in (known[0], statistics.median(known), known[-1])] if known else ["", "", ""]
    return f"{limit:g} | {' | '.join(shown)} | {len(gaps) - len(known)}"


def _within(problems: Sequence[Problem], percent: float) -> str:
    """Return the rest of the row of fronts within some percent."""
    seconds, fronts = [], []
    for problem in problems:
        began = time.process_time()
        fronts.append(Planner(problem).front(within=percent))
        seconds.append(time.process_time() - began)
    expanded, points = ([front.stats.expanded for front in fronts], [len(front) for front in fronts])
    name = f"{percent:g} %" if percent else "exact"
    times = f"{statistics.median(seconds):.2f} | {max(seconds):.2f}"
    return f"{name} | {times} | {statistics.median(expanded):,.0f} | {statistics.mean(points):.1f}"


def _finished(what: str, problem: Problem) -> tuple[float, int, int]:
    """Return the CPU seconds of a search to its end, the labels that it expanded, and its memory in bytes."""
    began, planner = time.process_time(), Planner(problem)
    if what == PLAN:
        planner.cheapest()
    else:
        planner.front()
    return time.process_time() - began, planner.stats.expanded, planner.stats.bytes


def _stopped(what: str, problem: Problem, seconds: float) -> float | None:
    """Return the percentage that is proven by a search stopped after some seconds, None if there is none."""
    planner = Planner(problem)
    if what == FRONT:
        within = planner.front(max_seconds=seconds).within
        return None if within is None else float(within)
    try:
        planner.cheapest(max_seconds=seconds)
    except UnfinishedError as error:
        return error.within
    return 0.0


if __name__ == "__main__":
    raise SystemExit(main())
