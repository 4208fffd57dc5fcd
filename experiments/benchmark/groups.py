"""Groups of searches that are timed: the paper's Table I, and other cases beside it."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from typing import Any

from experiments.benchmark.instances import FAMILIES, RANDOM, instance
from experiments.benchmark.large_models import MEASURED, SIZES, Size, large_problem
from experiments.benchmark.runs import FRONT, KINDS, METHODS, OURS, SINGLE, YARDSTICKS, Search
from prefplan import Expression, NamedPreference, Options, Order, Preference, Problem, WeightedSum, load

TASKS = {SINGLE: (2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 15), FRONT: (2, 3, 4, 5, 6, 7, 8, 9, 10, 11)}
"""Numbers of tasks in Table I: the paper's and more, up to instances that take minutes or gigabytes."""

MANY = {SINGLE: 12, FRONT: 8}
"""Greatest number of tasks with all instances; above it, only `FEW_SEEDS` are run, on random cells."""

FEW_SEEDS = 3
"""Greatest number of instances for the yardstick, and for searches with more tasks than `MANY`."""

YARDSTICK_TASKS = 8
"""Greatest number of tasks that the yardstick can finish within its limits."""

OUR_SECONDS = 150
"""Time limit of a run of our search for Table I, s."""

YARDSTICK_SECONDS = 120
"""Time limit of a run of the yardstick for Table I, s."""


def _weights(tasks: int) -> WeightedSum:
    return WeightedSum({f"phi{1 + i}": 1 + i % 3 for i in range(tasks)})


ABLATED: dict[tuple[str, str], tuple[int, Preference | Sequence[NamedPreference]]] = {
    **{(SINGLE, f"{n} tasks"): (n, Order()) for n in (8, 10)},
    **{(FRONT, f"{n} tasks"): (n, Order()) for n in (6, 7, 8)},
    (FRONT, "8 tasks, weighted sum"): (8, _weights(8)),
    (FRONT, "6 tasks, order and weighted sum"): (
        6,
        [NamedPreference("order", Order()), NamedPreference("sum", _weights(6))],
    ),
    (FRONT, "7 tasks, spread"): (7, Expression("max(phi1, phi2) - min(phi1, phi2) + phi3")),
}
"""Number of tasks and preference of each problem in `ablation`."""

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


def _searches(
    instances: Iterable[Callable[[], Problem]], methods: Mapping[str, Options], *, limit: float = math.inf, **what: Any
) -> Iterator[Search]:
    """Yield all searches of all instances of a problem, instance by instance."""
    for seed, made in enumerate(instances):
        for name, options in methods.items():
            yield Search({**what, "method": name, "seed": seed}, made, options, limit)


def _of_size(tasks: int, seeds: int, family: str = RANDOM) -> list[Callable[[], Problem]]:
    return [partial(instance, family, tasks, seed) for seed in range(seeds)]


def table1(seeds: int) -> Iterator[Search]:
    """Yield the searches of Table I, those with few tasks first, and for each size our method first."""
    for tasks, kind, family in product(sorted({*TASKS[SINGLE], *TASKS[FRONT]}), KINDS, FAMILIES):
        many, few = tasks <= MANY[kind], min(seeds, FEW_SEEDS)
        if tasks not in TASKS[kind] or not (many or family == RANDOM):
            continue
        counts = {OURS: seeds if many else few} | (dict.fromkeys(YARDSTICKS, few) if tasks <= YARDSTICK_TASKS else {})
        for name, count in counts.items():
            instances, methods = _of_size(tasks, count, family), {name: METHODS[name]}
            limit = OUR_SECONDS if name == OURS else YARDSTICK_SECONDS
            yield from _searches(instances, methods, limit=limit, family=family, kind=kind, tasks=tasks)


def stopped(seeds: int) -> Iterator[Search]:
    """Yield searches of many tasks with a time limit."""
    for kind, tasks, limits in ((SINGLE, 14, (1, 5, 20)), (SINGLE, 20, (1, 5, 20)), (FRONT, 10, (2, 10))):
        for limit in limits:
            yield from _searches(_of_size(tasks, seeds), {f"{limit} s": Options()}, limit=limit, kind=kind, tasks=tasks)


def ablation(seeds: int) -> Iterator[Search]:
    """Yield searches without one component of the planner."""
    problems: dict[tuple[str, str], list[Callable[[], Problem]]] = {
        what: [partial(_with_preference, preference, tasks, seed) for seed in range(seeds)]
        for what, (tasks, preference) in ABLATED.items()
    }
    problems |= {(FRONT, name): [load(name).problem] * seeds for name in ("case_study_3", "kitchen")}
    for (kind, name), instances in problems.items():
        yield from _searches(instances, DEVICES, kind=kind, problem=name)


def _with_preference(preference: Preference | Sequence[NamedPreference], tasks: int, seed: int) -> Problem:
    problem = instance(RANDOM, tasks, seed)
    return Problem(problem.system, problem.tasks, preference)


def large(sizes: Mapping[str, Size], seeds: int) -> Iterator[Search]:
    """Yield searches for the cheapest plan and the front in models too large to enumerate."""
    for name, kind in product(sizes, KINDS):
        yield from _searches([partial(large_problem, sizes[name])], {OURS: Options()}, kind=kind, problem=name)


GROUPS: dict[str, Callable[[int], Iterator[Search]]] = {
    "table1": table1,
    "stopped": stopped,
    "ablation": ablation,
    "large": partial(large, SIZES),
    "measured": partial(large, MEASURED),
}
"""Each yields searches, given the number of instances of each size."""
