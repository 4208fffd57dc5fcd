"""Runs of the benchmark: one method on one instance, in a process of its own."""

from __future__ import annotations

import math
import resource
import time
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context

from experiments.benchmark.instances import RANDOM, Points, instance, known, points
from prefplan import Options, Planner, Problem
from prefplan.front import UnfinishedError
from prefplan.heuristics.preprocessing import Prepared
from prefplan.limits import Limits
from prefplan.product.product_automaton import Product
from prefplan.search.bi_objective_search import BiObjectiveSearch

SINGLE, FRONT = "single", "front"
KINDS = (SINGLE, FRONT)

OURS, MAX_MIN, BARE = "ours", "max-min", "no heuristic"
"""Our search, and the yardstick (the method of the paper in our compiled kernels) with its heuristic and with none."""

YARDSTICKS = {
    MAX_MIN: Options(heuristic=1, preference_bound=False, contraction=False),
    BARE: Options(heuristic=0, preference_bound=False, contraction=False),
}

MAX_BYTES = 8e9
"""Memory limit of every search: what a laptop with 16 GB has to spare."""


@dataclass(frozen=True)
class BenchmarkRun:
    """What to time.

    Attributes:
        family: of the instance, one of `FAMILIES`.
        kind: `SINGLE` for the plan of least cost, `FRONT` for the front.
        method: `OURS` or one of `YARDSTICKS`.
        tasks: number of tasks, N.
        seed: of the instance.
        max_seconds: time limit.
    """

    family: str
    kind: str
    method: str
    tasks: int
    seed: int
    max_seconds: float


@dataclass(frozen=True)
class Timing:
    """Time and memory of a run.

    Attributes:
        seconds: CPU time of product, heuristics and search; a lower bound if the run was ended.
        expanded: labels expanded until the end.
        peak_bytes: peak memory of the process beyond `baseline_bytes`.
        baseline_bytes: memory of the process before the run, with everything loaded and compiled.
        points: of the front; the cost alone of a single plan. None if the run was ended.
        ended: None, or what ended the run: `time`, `memory`, or `killed` by the system.
    """

    seconds: float
    expanded: int
    peak_bytes: int
    baseline_bytes: int
    points: Points | None
    ended: str | None


def warm_up() -> None:
    """Plan a small instance with all methods, so that later runs find everything loaded and compiled."""
    for method in (OURS, *YARDSTICKS):
        for plan in (_single, _front):
            plan(method, instance(RANDOM, 3, 0), math.inf)
    # Long searches take kernels of their own.
    _front(OURS, instance(RANDOM, 9, 1), math.inf)


def wrong_fronts() -> list[str]:
    """Return those known instances whose front our search gets wrong, with the front found."""
    return [
        f"{line}, but found {found}"
        for line, problem, expected in known()
        if (found := points(Planner(problem).front())) != expected
    ]


def carry_out(run: BenchmarkRun) -> Timing:
    """Carry a run out in a fork of this process: everything is loaded and compiled, and memory is counted from 0."""
    began = time.perf_counter()
    with ProcessPoolExecutor(1, mp_context=get_context("fork")) as pool:
        try:
            return pool.submit(_measure, run).result()
        except BrokenProcessPool:
            return Timing(time.perf_counter() - began, 0, 0, 0, None, "killed")


def _measure(run: BenchmarkRun) -> Timing:
    plan = _front if run.kind == FRONT else _single
    # A fork copies each page of memory at its first use, which should not count.
    plan(run.method, instance(RANDOM, 3, 0), math.inf)
    problem = instance(run.family, run.tasks, run.seed)
    baseline = _peak()
    seconds, expanded, found, ended = plan(run.method, problem, run.max_seconds)
    return Timing(seconds, expanded, _peak() - baseline, baseline, found, ended)


def _peak() -> int:
    """Return the greatest memory of this process so far, bytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


Planned = tuple[float, int, Points | None, str | None]
"""Seconds, labels expanded, points and what ended the run, as in `Timing`."""


def _front(method: str, problem: Problem, max_seconds: float) -> Planned:
    """Plan the front: the yardstick is BOA* over the whole product, without a bound on the second objective."""
    began, planner = time.process_time(), Planner(problem, options=YARDSTICKS.get(method))
    front = planner.front(max_seconds=max_seconds, max_memory=MAX_BYTES)
    seconds = time.process_time() - began
    return seconds, planner.stats.expanded, points(front) if front.complete else None, front.ended


def _single(method: str, problem: Problem, max_seconds: float) -> Planned:
    """Plan the cheapest plan: the yardstick is A* over the whole product, with one cost for each state."""
    began = time.process_time()
    if method == OURS:
        planner, found, ended = Planner(problem), None, None
        try:
            found = ((float(planner.cheapest(max_seconds=max_seconds, max_memory=MAX_BYTES).cost),),)
        except UnfinishedError as error:
            ended = error.ended
        return time.process_time() - began, planner.stats.expanded, found, ended
    limits = Limits(max_seconds, MAX_BYTES)
    product = Product(problem)
    search = BiObjectiveSearch(Prepared(product, YARDSTICKS[method], single=True), cost_only=True)
    goal = next(search.goals(limits), None)
    seconds = time.process_time() - began
    found = None if goal is None else ((float(goal.cost * product.units.cost),),)
    return seconds, search.work.expanded, found, limits.ended
