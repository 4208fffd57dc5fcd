"""Runs of the benchmark: one way to plan, on one instance, in a process of its own."""

from __future__ import annotations

import math
import multiprocessing
import resource
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection

from experiments.benchmark.facts import KNOWN
from experiments.benchmark.instances import RANDOM, instance, known, points
from prefplan import Options, Planner, Problem
from prefplan.front import UnfinishedError
from prefplan.heuristics.preprocessing import Prepared
from prefplan.limits import Limits
from prefplan.product.product_automaton import Product
from prefplan.search.driver import BiObjectiveSearch

SINGLE, FRONT = "single", "front"
KINDS = (SINGLE, FRONT)

OURS, MAX_MIN, BARE = "ours", "max-min", "no heuristic"
"""Our search, and the yardstick with the paper's heuristic and with none: its method, in our compiled kernels."""

YARDSTICKS = {
    MAX_MIN: Options(heuristic=1, preference_bound=False, contraction=False),
    BARE: Options(heuristic=0, preference_bound=False, contraction=False),
}

MAX_BYTES = 8e9
"""Memory of any search: what a laptop of 16 GB has to spare."""

UNIT_OF_PEAK = 1 if sys.platform == "darwin" else 1024
"""Bytes that the system counts peak memory in."""

POLL_PERIOD = 0.2
"""Seconds between two looks at a process that runs."""


@dataclass(frozen=True)
class BenchmarkRun:
    """What to time.

    Attributes:
        family: where the instance comes from.
        kind: the single plan of least cost, or the front.
        method: how it is planned.
        tasks: N.
        seed: which instance.
        max_seconds: time after which it is ended.
    """

    family: str
    kind: str
    method: str
    tasks: int
    seed: int
    max_seconds: float


@dataclass(frozen=True)
class Timing:
    """What a run took.

    Attributes:
        seconds: product, heuristics and search; a lower bound if the run was ended.
        expanded: labels expanded, as far as that was told before the run was ended.
        peak_bytes: peak memory of the process, beyond that before the run.
        baseline_bytes: memory of the process before the run, with everything loaded and compiled.
        points: (cost, preference) of the front; of a single plan the cost only. None if the run was ended.
        ended: None, or what ended the run: `time`, `memory`, or `killed` by the system.
    """

    seconds: float
    expanded: int
    peak_bytes: int
    baseline_bytes: int
    points: tuple[tuple[float, ...], ...] | None
    ended: str | None


def warm_up() -> None:
    """Plan a small instance in all ways, so that later runs find everything loaded and compiled."""
    for method in (OURS, *YARDSTICKS):
        for plan in (_single, _front):
            plan(method, instance(RANDOM, 3, 0), math.inf)


def wrong_fronts() -> list[str]:
    """Return those of the known instances whose front our engine gets wrong, with what it says."""
    wrong = []
    for name, (_, expected) in KNOWN.items():
        found = points(Planner(known(name)).front())
        if found != expected:
            wrong.append(f"{name}: found {found}, known is {expected}")
    return wrong


def carry_out(run: BenchmarkRun, tick: Callable[[], None]) -> Timing:
    """Carry a run out in a fork of this process, calling `tick` now and then.

    A fork starts with everything loaded and compiled, and its memory is counted anew.
    """
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_send, args=(sender, run), daemon=True)
    began = time.perf_counter()
    process.start()
    sender.close()
    try:
        while not receiver.poll(POLL_PERIOD):
            tick()
        outcome: Timing = receiver.recv()
    except EOFError:
        outcome = Timing(time.perf_counter() - began, 0, 0, 0, None, "killed")
    finally:
        process.kill()
        process.join()
        receiver.close()
    return outcome


def _send(sender: Connection, run: BenchmarkRun) -> None:
    plan = _front if run.kind == FRONT else _single
    # A fork's first use of each page of memory copies it, which should not count.
    plan(run.method, instance(RANDOM, 3, 0), math.inf)
    problem = instance(run.family, run.tasks, run.seed)
    baseline = _peak()
    seconds, expanded, found, ended = plan(run.method, problem, run.max_seconds)
    sender.send(Timing(seconds, expanded, _peak() - baseline, baseline, found, ended))


def _peak() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * UNIT_OF_PEAK


Planned = tuple[float, int, tuple[tuple[float, ...], ...] | None, str | None]


def _front(method: str, problem: Problem, max_seconds: float) -> Planned:
    """Plan the front: the yardstick is BOA* over the whole product, without a bound of mu's growth."""
    planner = Planner(problem, options=YARDSTICKS.get(method))
    front = planner.front(max_seconds=max_seconds, max_memory=MAX_BYTES)
    stats = planner.stats
    return stats.build_seconds + stats.seconds, stats.expanded, points(front) if front.complete else None, front.ended


def _single(method: str, problem: Problem, max_seconds: float) -> Planned:
    """Plan the cheapest plan: the yardstick is A* over the whole product, with one cost for each state."""
    if method == OURS:
        return _cheapest(problem, max_seconds)
    began = time.perf_counter()
    limits = Limits(max_seconds, MAX_BYTES)
    product = Product(problem)
    search = BiObjectiveSearch(Prepared(product, YARDSTICKS[method], single=True), cost_only=True)
    goal = next(search.goals(limits), None)
    seconds = time.perf_counter() - began
    found = None if goal is None else ((float(goal.cost * product.units.cost),),)
    return seconds, search.work.expanded, found, limits.ended


def _cheapest(problem: Problem, max_seconds: float) -> Planned:
    """Plan the cheapest plan with our search."""
    planner = Planner(problem)
    found, ended = None, None
    try:
        found = ((float(planner.cheapest(max_seconds=max_seconds, max_memory=MAX_BYTES).cost),),)
    except UnfinishedError as error:
        ended = error.ended
    return planner.stats.build_seconds + planner.stats.seconds, planner.stats.expanded, found, ended
