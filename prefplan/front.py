"""Plans and Pareto fronts: what the search found, in the user's words and units."""

from __future__ import annotations

import math
import time
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations

from prefplan.errors import PrefplanError
from prefplan.heuristic import max_min
from prefplan.preference import Order
from prefplan.problem import Problem
from prefplan.product import Product
from prefplan.quanta import Number, exact, from_quanta
from prefplan.search import Label, Statistics, boa_star


@dataclass(frozen=True)
class Plan:
    """One way to satisfy all tasks.

    Attributes:
        cost: total cost (equation 1).
        preference: mu (Definition 5).
        task_costs: c_i by task name (equation 2).
        actions: the plan.
        states: the trajectory, one state more than there are actions.
    """

    cost: Number
    preference: Number
    task_costs: dict[str, Number]
    actions: tuple[str, ...]
    states: tuple[Hashable, ...]


@dataclass(frozen=True)
class Reason:
    """Why there is no plan.

    Attributes:
        kind: `task` (it can never be satisfied), `conflict` (these cannot be satisfied together) or `bound`.
        tasks: the tasks to blame; empty for `bound`.
        smallest: for `bound`, the smallest mu (or, under a cost bound, the smallest cost) that is possible.
    """

    kind: str
    tasks: tuple[str, ...] = ()
    smallest: Number | None = None

    def __str__(self) -> str:
        """Return the reason as a sentence."""
        names = ", ".join(self.tasks)
        if self.kind == "task":
            return f"task {names} can never be satisfied"
        if self.kind == "conflict":
            return f"tasks {names} cannot be satisfied together, though any fewer of them can"
        return f"no plan lies within the bound; the smallest possible is {self.smallest}"


class NoPlanError(PrefplanError):
    """No plan satisfies all tasks within the bounds; `reason` says why."""

    def __init__(self, reason: Reason) -> None:
        """Keep the reason and make it the message."""
        super().__init__(str(reason))
        self.reason = reason


@dataclass(frozen=True)
class Stats:
    """Work and time of a search.

    Attributes:
        states: product states met.
        expanded: labels expanded.
        generated: labels made.
        build_seconds: automata and product tables.
        seconds: heuristic and search.
    """

    states: int = 0
    expanded: int = 0
    generated: int = 0
    build_seconds: float = 0.0
    seconds: float = 0.0


@dataclass(frozen=True)
class Front(Sequence[Plan]):
    """All non-dominated (cost, mu), one plan each, in order of rising cost and falling mu.

    Attributes:
        plans: the points.
        complete: whether the search ran to its end.
        reason: why there is no plan; None if there is one.
        stats: work and time.
    """

    plans: tuple[Plan, ...]
    complete: bool = True
    reason: Reason | None = None
    stats: Stats = field(default_factory=Stats)

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.plans)

    def __getitem__(self, index):  # type: ignore[no-untyped-def]
        """Return a point by its place."""
        return self.plans[index]


def pareto_front(problem: Problem, *, max_cost: Number | None = None) -> Front:
    """Return the Pareto front of total cost and preference.

    Args:
        problem: what to plan.
        max_cost: only plans of at most this total cost.
    """
    search = _Search(problem)
    limit = math.inf if max_cost is None else float(exact(max_cost).scaleb(problem.decimals))
    plans = tuple(search.plan(label) for label in search.labels(max_cost=limit))
    reason = None if plans else search.reason(max_cost=max_cost)
    return Front(plans, reason=reason, stats=search.stats())


def cheapest_plan(problem: Problem, *, max_preference: Number | None = None) -> Plan:
    """Return the plan of least total cost whose mu does not exceed a bound (Algorithm 1).

    Raises:
        NoPlanError: if there is none; its reason has the smallest mu that is possible.
    """
    search = _Search(problem)
    limit = math.inf
    if max_preference is not None:
        limit = float(exact(max_preference).scaleb(problem.measure.decimals))
    for label in search.labels(max_preference=limit):
        return search.plan(label)
    raise NoPlanError(search.reason())


def preferred_plan(problem: Problem) -> Plan:
    """Return the plan of least mu, and of least total cost among those.

    Raises:
        NoPlanError: if no plan satisfies all tasks.
    """
    front = pareto_front(problem)
    if front.reason:
        raise NoPlanError(front.reason)
    return front[-1]


class _Search:
    """A problem made ready to be searched, and the way back to the user's words."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.statistics = Statistics()
        began = time.perf_counter()
        self.product = Product(problem)
        self.measure = problem.measure
        self.built = time.perf_counter()
        self.build_seconds = self.built - began
        self.heuristic = max_min(self.product)

    def labels(self, *, max_preference: float = math.inf, max_cost: float = math.inf) -> Iterator[Label]:
        return boa_star(
            self.product,
            self.measure,
            self.heuristic,
            max_preference=max_preference,
            max_cost=max_cost,
            statistics=self.statistics,
        )

    def stats(self) -> Stats:
        done = self.statistics
        seconds = time.perf_counter() - self.built
        return Stats(len(done.met), done.expanded, done.generated, self.build_seconds, seconds)

    def plan(self, label: Label) -> Plan:
        system, decimals = self.problem.system, self.problem.decimals
        edges, states = [], []
        at: Label | None = label
        while at is not None:
            states.append(system.states[at.state[0]])
            if at.parent:
                edges.append(at.edge)
            at = at.parent
        return Plan(
            cost=from_quanta(label.cost, decimals),
            preference=from_quanta(label.preference, self.measure.decimals),
            task_costs={
                name: from_quanta(c, decimals) for name, c in zip(self.problem.names, label.task_costs, strict=True)
            },
            actions=tuple(system.action_names[system.actions[edge]] for edge in reversed(edges)),
            states=tuple(reversed(states)),
        )

    def reason(self, *, max_cost: Number | None = None) -> Reason:
        """Return why no plan was found."""
        if (blame := conflict(self.problem)) is not None:
            return Reason("task" if len(blame) == 1 else "conflict", blame)
        if max_cost is not None:
            return Reason("bound", smallest=cheapest_plan(self.problem).cost)
        return Reason("bound", smallest=preferred_plan(self.problem).preference)


def conflict(problem: Problem) -> tuple[str, ...] | None:
    """Return a smallest set of tasks that cannot be satisfied together, or None if all of them can."""
    for size in range(1, len(problem.tasks) + 1):
        for tasks in combinations(problem.tasks, size):
            search = _Search(Problem(problem.system, tasks, Order()))
            if next(search.labels(), None) is None:
                return tuple(task.name for task in tasks)
    return None
