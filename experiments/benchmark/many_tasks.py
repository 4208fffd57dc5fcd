"""Many tasks of the paper's benchmark: CPU time to the end, and the gap that is proven when the search is stopped."""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Sequence

from experiments.benchmark.instances import RANDOM, instance
from prefplan import Planner, Problem, UnfinishedError

PLAN, FRONT = "plan", "front"


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a table, and return the exit status."""
    parser = argparse.ArgumentParser(prog="many_tasks", description=__doc__)
    parser.add_argument("what", choices=(PLAN, FRONT), help="the cheapest plan, or the whole front")
    parser.add_argument("--tasks", type=int, nargs="+", required=True, metavar="N", help="sizes")
    parser.add_argument("--seeds", type=int, default=3, help="instances of each size (default: 3)")
    parser.add_argument("--stop", type=float, nargs="*", metavar="S", help="stop after so many seconds each")
    options = parser.parse_args(arguments)
    # The first search loads compiled code.
    for kind in (PLAN, FRONT):
        _stopped(kind, instance(RANDOM, 10, 0), 1)
    _finished(options.what, instance(RANDOM, 3, 0))
    if options.stop:
        print(
            "| N | stopped after s | gap: least | median | most | without any |\n| --- | --- | --- | --- | --- | --- |"
        )
    else:
        print("| N | CPU s, median | CPU s, most | labels expanded, median | MB of the search, most |")
        print("| --- | --- | --- | --- | --- |")
    for tasks in options.tasks:
        problems = [instance(RANDOM, tasks, seed) for seed in range(options.seeds)]
        if not options.stop:
            runs = [_finished(options.what, problem) for problem in problems]
            seconds, expanded, size = zip(*runs, strict=True)
            print(
                f"| {tasks} | {statistics.median(seconds):.2f} | {max(seconds):.2f} "
                f"| {statistics.median(expanded):,.0f} | {max(size) / 1e6:.0f} |",
                flush=True,
            )
        for limit in options.stop or ():
            gaps = [_stopped(options.what, problem, limit) for problem in problems]
            known = sorted(gap for gap in gaps if gap is not None)
            shown = (
                [f"{gap:.1f} %" for gap in (known[0], statistics.median(known), known[-1])] if known else ["", "", ""]
            )
            print(f"| {tasks} | {limit:g} |", " | ".join(shown), f"| {len(gaps) - len(known)} |", flush=True)
    return 0


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
