"""Time the planner with one device left out at a time: CPU time as a multiple of what the whole planner takes."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from contextlib import nullcontext
from statistics import median
from typing import Any
from unittest import mock

from experiments.benchmark.instances import RANDOM, instance
from experiments.benchmark.runs import FRONT, SINGLE
from experiments.scenarios import find
from prefplan import Options, Planner, Problem
from prefplan.heuristics import cost_to_go

WHOLE = "whole planner"

DEVICES: dict[str, Options] = {
    WHOLE: Options(),
    "no contraction": Options(contraction=False),
    "no topological sweep": Options(),
    "tables of pairs of tasks": Options(heuristic=2),
    "no preference bound": Options(preference_bound=False),
}

SIZES = {SINGLE: (8, 10), FRONT: (6, 7, 8)}
SCENARIOS = ("case_study_3", "kitchen")


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5, help="instances of each size (default: 5)")
    seeds = range(parser.parse_args(arguments).seeds)
    problems = {
        f"{kind}, {n} tasks": [instance(RANDOM, n, seed) for seed in seeds] for kind in SIZES for n in SIZES[kind]
    }
    problems |= {f"{FRONT}, {name}": [find(name).problem()] * len(seeds) for name in SCENARIOS}
    for device in DEVICES:
        for kind in SIZES:
            _cpu_seconds(device, kind, instance(RANDOM, 3, 0))
    print("| problem | CPU s |", " | ".join(list(DEVICES)[1:]), "|")
    print("| --- " * (len(DEVICES) + 1) + "|")
    for name, instances in problems.items():
        kind = name.partition(",")[0]
        runs = [{device: _cpu_seconds(device, kind, problem) for device in DEVICES} for problem in instances]
        ratios = [median(run[device] / run[WHOLE] for run in runs) for device in list(DEVICES)[1:]]
        cells = [f"{median(run[WHOLE] for run in runs):.3f}", *(f"{ratio:.1f}" for ratio in ratios)]
        print(f"| {name} |", " | ".join(cells), "|", flush=True)
    return 0


def _cpu_seconds(device: str, kind: str, problem: Problem) -> float:
    """Return the CPU time of a front or a cheapest plan without a device."""
    without: Any = nullcontext()
    if device == "no topological sweep":
        without = mock.patch.object(cost_to_go, "stages_of", lambda product, view: None)
    with without:
        began = time.process_time()
        planner = Planner(problem, options=DEVICES[device])
        planner.front() if kind == FRONT else planner.cheapest()
        return time.process_time() - began


if __name__ == "__main__":
    sys.exit(main())
