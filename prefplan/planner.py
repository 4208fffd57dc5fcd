"""From a problem to its plans: one plan, one under a bound, or the whole Pareto front."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from itertools import combinations

from prefplan.front import Front, NoPlanError, Plan, Reason, Stats
from prefplan.heuristic import max_min
from prefplan.preference import Order
from prefplan.problem import Problem
from prefplan.product import Product
from prefplan.quanta import Number, exact, from_quanta
from prefplan.search import Label, Statistics, boa_star


def pareto_front(problem: Problem, *, max_cost: Number | None = None) -> Front:
    """Return the Pareto front of total cost and preference; empty, with a reason, if there is no plan.

    Args:
        problem: what to plan.
        max_cost: only plans of at most this total cost.
    """
    return Planner(problem).front(max_cost=max_cost)


def cheapest_plan(problem: Problem, *, max_preference: Number | None = None) -> Plan:
    """Return the plan of least total cost whose mu does not exceed a bound (Algorithm 1).

    Raises:
        NoPlanError: if there is none; its reason has the smallest mu that is possible.
    """
    return Planner(problem).cheapest(max_preference=max_preference)


def preferred_plan(problem: Problem, *, max_preference: Number | None = None) -> Plan:
    """Return the plan of least mu, and of least total cost among those.

    Raises:
        NoPlanError: if there is none, or its mu exceeds the bound.
    """
    return Planner(problem).preferred(max_preference=max_preference)


class Planner:
    """A problem made ready to be searched.

    Attributes:
        problem: what is planned.
        stats: work and time of the last search.
    """

    def __init__(self, problem: Problem) -> None:
        """Build the automata, the product's tables and the heuristic."""
        began = time.perf_counter()
        self.problem = problem
        self._product = Product(problem)
        self._build_seconds = time.perf_counter() - began
        began = time.perf_counter()
        self._heuristic = max_min(self._product)
        self._heuristic_seconds = time.perf_counter() - began
        self.stats = Stats(build_seconds=self._build_seconds)

    def front(self, *, max_cost: Number | None = None) -> Front:
        """Return the Pareto front; see `pareto_front`."""
        limit = math.inf if max_cost is None else float(exact(max_cost).scaleb(self.problem.decimals))
        plans = tuple(map(self._plan, self._search(max_cost=limit)))
        stats = self.stats
        return Front(plans, reason=None if plans else self._why_not(max_cost=max_cost), stats=stats)

    def cheapest(self, *, max_preference: Number | None = None) -> Plan:
        """Return the plan of least total cost within a bound on mu; see `cheapest_plan`."""
        limit = math.inf
        if max_preference is not None:
            limit = float(exact(max_preference).scaleb(self.problem.measure.decimals))
        for label in self._search(max_preference=limit):
            return self._plan(label)
        raise NoPlanError(self._why_not())

    def preferred(self, *, max_preference: Number | None = None) -> Plan:
        """Return the plan of least mu; see `preferred_plan`."""
        front = self.front()
        if front.reason:
            raise NoPlanError(front.reason)
        if max_preference is not None and exact(front[-1].preference) > exact(max_preference):
            raise NoPlanError(Reason("bound", smallest=front[-1].preference))
        return front[-1]

    def _search(self, *, max_preference: float = math.inf, max_cost: float = math.inf) -> Iterator[Label]:
        began, work = time.perf_counter(), Statistics()
        for label in boa_star(
            self._product,
            self.problem.measure,
            self._heuristic,
            max_preference=max_preference,
            max_cost=max_cost,
            statistics=work,
        ):
            self._account(work, began)
            yield label
        self._account(work, began)

    def _account(self, work: Statistics, began: float) -> None:
        seconds = self._heuristic_seconds + time.perf_counter() - began
        self.stats = Stats(len(work.met), work.expanded, work.generated, self._build_seconds, seconds)

    def _plan(self, label: Label) -> Plan:
        """Return a path of the search in the user's words and units."""
        system, problem = self.problem.system, self.problem
        edges, states = [], []
        at: Label | None = label
        while at is not None:
            states.append(system.states[at.state[0]])
            if at.parent:
                edges.append(at.edge)
            at = at.parent
        costs = [from_quanta(c, problem.decimals) for c in label.task_costs]
        return Plan(
            cost=from_quanta(label.cost, problem.decimals),
            preference=from_quanta(label.preference, problem.measure.decimals),
            task_costs=dict(zip(problem.names, costs, strict=True)),
            actions=tuple(system.action_names[system.actions[edge]] for edge in reversed(edges)),
            states=tuple(reversed(states)),
        )

    def _why_not(self, *, max_cost: Number | None = None) -> Reason:
        """Return why a search found nothing."""
        cheapest = next(self._search(), None)
        if cheapest is None:
            blame = conflict(self.problem)
            return Reason("task" if len(blame) == 1 else "conflict", blame)
        if max_cost is not None:
            return Reason("bound", smallest=self._plan(cheapest).cost)
        return Reason("bound", smallest=self.preferred().preference)


def conflict(problem: Problem) -> tuple[str, ...]:
    """Return the names of a smallest set of tasks that cannot be satisfied together; empty if all of them can."""
    for size in range(1, len(problem.tasks) + 1):
        for tasks in combinations(problem.tasks, size):
            alone = Product(Problem(problem.system, tasks, Order()))
            if next(boa_star(alone, alone.problem.measure, max_min(alone)), None) is None:
                return tuple(task.name for task in tasks)
    return ()
