"""Fronts within some percent beside the exact front: CPU time and points, on the paper's benchmark."""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Sequence

from experiments.benchmark.instances import RANDOM, instance
from prefplan import Front, Problem, pareto_front

PERCENT = (0, 1, 5, 20, 50)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a table, and return the exit status."""
    parser = argparse.ArgumentParser(prog="approximate", description=__doc__)
    parser.add_argument("--tasks", type=int, nargs="+", default=[8, 9], metavar="N", help="sizes (default: 8 9)")
    parser.add_argument("--seeds", type=int, default=10, help="instances of each size (default: 10)")
    parser.add_argument("--within", type=float, nargs="+", default=PERCENT, metavar="P", help="percentages, 0: exact")
    options = parser.parse_args(arguments)
    _timed(instance(RANDOM, 9, 0), 5)  # The first search loads compiled code.
    print("| N | within | CPU s, median | CPU s, most | labels expanded, median | points, mean |")
    print("| --- | --- | --- | --- | --- | --- |")
    for tasks in options.tasks:
        for percent in options.within:
            runs = [_timed(instance(RANDOM, tasks, seed), percent) for seed in range(options.seeds)]
            seconds = [taken for taken, _ in runs]
            expanded = statistics.median(front.stats.expanded for _, front in runs)
            points = statistics.mean(len(front) for _, front in runs)
            name = f"{percent:g} %" if percent else "exact"
            print(
                f"| {tasks} | {name} | {statistics.median(seconds):.2f} | {max(seconds):.2f} "
                f"| {expanded:,.0f} | {points:.1f} |",
                flush=True,
            )
    return 0


def _timed(problem: Problem, percent: float) -> tuple[float, Front]:
    """Return the CPU seconds of a front and the front."""
    began = time.process_time()
    front = pareto_front(problem, within=percent)
    return time.process_time() - began, front


if __name__ == "__main__":
    raise SystemExit(main())
