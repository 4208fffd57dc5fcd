"""Runs of a benchmark: one search of one instance, in a separate process."""

import math
import resource
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from typing import Any

from experiments.benchmark.instances import RANDOM, Points, instance, known, points
from prefplan import Options, Planner, Problem, UnfinishedError, load
from prefplan.heuristics.prepare import Prepared
from prefplan.limits import Limits
from prefplan.models.kernels import compile_kernels
from prefplan.product.product_automaton import Product
from prefplan.search.driver import LabelSearch

SINGLE, FRONT = "single", "front"
KINDS = (SINGLE, FRONT)

OURS = "ours"
"""Our search."""

MAX_MIN = "max-min"
"""The yardstick: the paper's method in our compiled kernels, with its heuristic."""

BARE = "no heuristic"
"""The yardstick without a heuristic."""

YARDSTICKS = (MAX_MIN, BARE)

METHODS = {
    OURS: Options(),
    MAX_MIN: Options(heuristic=1, preference_bound=False, contraction=False),
    BARE: Options(heuristic=0, preference_bound=False, contraction=False),
}

MAX_BYTES = 8e9
"""Memory limit of every search, bytes: what a laptop with 16 GB has to spare."""

Record = dict[str, Any]
"""Result of a run, JSON-ready: `Search.what`, and

- `seconds`: CPU time of product, heuristics and search; a lower bound if the run was ended.
- `expanded`: labels expanded until the end.
- `points`: those of the front, or the cost of a single plan; None if the run was ended.
- `within`: percentage by which the result exceeds the optimum at most, 0 if exact; None if nothing is proven.
- `ended`: None, or what ended the run: `time`, `memory`, or `killed` by the system.
- `peak_bytes`: peak memory of the process beyond `baseline_bytes`.
- `baseline_bytes`: memory of the process before the run, with everything loaded and compiled.
"""


@dataclass(frozen=True)
class Search:
    """One search of one instance.

    Attributes:
        what: identifies the run, JSON-ready: at least its `kind`, `method` and `seed`. Runs that differ only in their
            `seed` are summarised together, and runs that differ in their `method` are compared with the first method.
        instance: makes the instance.
        options: of the planner.
        max_seconds: time limit.
    """

    what: Mapping[str, Any]
    instance: Callable[[], Problem]
    options: Options = Options()
    max_seconds: float = math.inf

    def search(self, problem: Problem) -> Record:
        """Search an instance, and return the record without `what` and memory."""
        kind, limits = self.what["kind"], Limits(self.max_seconds, MAX_BYTES)
        if kind == SINGLE and self.what["method"] in YARDSTICKS:
            return search_whole_product(problem, self.options, limits)
        return search(kind, problem, self.options, limits)


def search(kind: str, problem: Problem, options: Options, limits: Limits) -> Record:
    """Search for the plan of least cost or for the front."""
    began, planner = time.process_time(), Planner(problem, options=options)
    found: Points | None = None
    proven: float | None = 0.0
    ended: str | None = None
    try:
        with limits:
            if kind == SINGLE:
                found = [[float(planner.cheapest().cost)]]
            else:
                front = planner.front()
                found, proven, ended = (points(front), 0.0, None) if front.complete else (None, None, front.ended)
    except UnfinishedError as error:
        proven, ended = None if error.within is None else float(error.within), error.ended
    return _record(began, planner.stats.expanded, found, proven, ended)


def search_whole_product(problem: Problem, options: Options, limits: Limits) -> Record:
    """Search for the plan of least cost as the yardstick does: A* over the whole product, one cost for each state."""
    began, product = time.process_time(), Product(problem)
    astar = LabelSearch(Prepared(product, options, single=True), bounds={}, first=problem.cost_names[0])
    with limits:
        result = astar.run()
    if result.ended == "interrupt":
        raise KeyboardInterrupt
    found = [[float(goal.objectives[0])] for goal in result.goals if result.ended is None] or None
    return _record(began, result.work.expanded, found, None if found is None else 0.0, result.ended)


def _record(began: float, expanded: int, found: Points | None, within: float | None, ended: str | None) -> Record:
    seconds = time.process_time() - began
    return {"seconds": seconds, "expanded": expanded, "points": found, "within": within, "ended": ended}


def warm_up() -> None:
    """Plan small instances with all methods, so that later runs find everything loaded and compiled."""
    compile_kernels()
    small = partial(instance, RANDOM, 3, 0)
    for kind in KINDS:
        for name, options in METHODS.items():
            Search({"kind": kind, "method": name}, small, options).search(small())
        # Long searches use further kernels.
        search(kind, instance(RANDOM, 9, 1), Options(), Limits(1))
    search(FRONT, load("case_study_3").problem(), Options(), Limits())


def wrong_fronts() -> list[str]:
    """Return the known instances for which our search finds another front, with that front."""
    return [
        f"{line}, but found {found}"
        for line, problem, expected in known()
        if (found := points(Planner(problem).front())) != expected
    ]


def run_search(run: Search) -> Record:
    """Carry a run out in a fork of this process, where everything is loaded and compiled."""
    began = time.perf_counter()
    with ProcessPoolExecutor(1, mp_context=get_context("fork")) as pool:
        try:
            found = pool.submit(_measure, run).result()
        except BrokenProcessPool:
            nothing = {"expanded": 0, "points": None, "within": None, "peak_bytes": 0, "baseline_bytes": 0}
            found = nothing | {"seconds": time.perf_counter() - began, "ended": "killed"}
    return {**run.what, **found}


def _measure(run: Search) -> Record:
    # A fork copies each page of memory when it is first written to, which should not count.
    run.search(instance(RANDOM, 3, 0))
    problem = run.instance()
    baseline = _peak()
    found = run.search(problem)
    return {**found, "peak_bytes": _peak() - baseline, "baseline_bytes": baseline}


def _peak() -> int:
    """Return the greatest memory of this process so far, bytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
