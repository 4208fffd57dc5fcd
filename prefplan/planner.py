"""From a problem to its plans: one plan, one under a bound, or the whole Pareto front."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import combinations
from typing import TypedDict, Unpack

import numpy as np

from prefplan.errors import PreferenceError
from prefplan.exact_costs import Number, exact, inclusive, to_number
from prefplan.front import Front, NoPlanError, Plan, Reason, Stats, UnfinishedError
from prefplan.heuristics.preprocessing import Options, Prepared, bytes_to_prepare
from prefplan.limits import Limits, available_memory
from prefplan.preferences.kinds import WeightedSum
from prefplan.problem import Problem, Task
from prefplan.product.product_automaton import Product
from prefplan.search.driver import BiObjectiveSearch, Found, Search, in_units
from prefplan.search.exact_search import ExactSearch
from prefplan.search.vector_search import VectorSearch

MEMORY_SHARE = 0.8
"""Part of the free memory that a search may take unless told otherwise."""


class FrontLimits(TypedDict, total=False):
    """Where the search for a front ends; None or nothing for no bound.

    Attributes:
        max_cost: inclusive bound of the total cost; needed for a preference whose contract is `general`.
        max_seconds: time.
        max_memory: bytes of memory; None for most of what is free.
    """

    max_cost: Number | None
    max_seconds: float | None
    max_memory: float | None


class PlanLimits(FrontLimits, total=False):
    """Where the search for one plan ends.

    Attributes:
        max_preference: inclusive bound of mu.
    """

    max_preference: Number | None


def pareto_front(problem: Problem, *, options: Options | None = None, **limits: Unpack[FrontLimits]) -> Front:
    """Return the Pareto front of total cost and preference; empty, with a reason, if there is no plan.

    A limit of time or memory leaves the points found so far; `ended` says which it was.

    Args:
        problem: what to plan.
        options: how to search; the front does not depend on it.
        **limits: `max_cost`, `max_seconds` and `max_memory`, see `FrontLimits`.

    Raises:
        PreferenceError: if a cost bound is needed.
    """
    return Planner(problem, options=options).front(**limits)


def cheapest_plan(problem: Problem, *, options: Options | None = None, **limits: Unpack[PlanLimits]) -> Plan:
    """Return the plan of least total cost whose mu does not exceed a bound (Algorithm 1), of least mu among those.

    Args:
        problem: what to plan.
        options: how to search; cost and mu do not depend on it.
        **limits: those of `pareto_front`, and `max_preference`, see `PlanLimits`.

    Raises:
        NoPlanError: if there is none; its reason has the smallest mu that is possible.
        UnfinishedError: if a limit ended the search first.
        PreferenceError: if a cost bound is needed.
    """
    return Planner(problem, options=options).cheapest(**limits)


def preferred_plan(problem: Problem, *, options: Options | None = None, **limits: Unpack[PlanLimits]) -> Plan:
    """Return the plan of least mu, and of least total cost among those.

    Args:
        problem: what to plan.
        options: how to search; cost and mu do not depend on it.
        **limits: those of `pareto_front`, and `max_preference`, see `PlanLimits`.

    Raises:
        NoPlanError: if there is none, or its mu exceeds the bound.
        UnfinishedError: if a limit ended the search first; its `best` is the plan of least mu known by then.
        PreferenceError: if a cost bound is needed.
    """
    return Planner(problem, options=options).preferred(**limits)


class Planner:
    """A problem made ready to be searched.

    Attributes:
        problem: what is planned.
        stats: work and time of the last search.
    """

    def __init__(self, problem: Problem, *, options: Options | None = None) -> None:
        """Build the automata and the product's tables."""
        began = time.perf_counter()
        self.problem = problem
        self._options = options or Options()
        self._product = Product(problem)
        self._build_seconds = time.perf_counter() - began
        self.stats = Stats(build_seconds=self._build_seconds)

    def front(self, *, keep_on_interrupt: bool = False, **wanted: Unpack[FrontLimits]) -> Front:
        """Return the Pareto front; see `pareto_front`.

        Args:
            keep_on_interrupt: return the points found so far on Ctrl-C, instead of raising KeyboardInterrupt.
            **wanted: see `FrontLimits`.
        """
        limits = _limits(**wanted)
        self._require_bound(**wanted)
        plans: list[Plan] = []
        try:
            for plan in self._search(limits, **wanted):
                plans.append(plan)
        except KeyboardInterrupt:
            if not keep_on_interrupt:
                raise
            limits.ended = "interrupt"
        front = Front(
            tuple(plans),
            ended=limits.ended,
            resolution=self.problem.resolution,
            claimed=self.problem.measure.claimed,
            stats=self.stats,
        )
        if limits.ended is not None:
            return replace(front, complete_below=self._below(limits))
        return front if plans else replace(front, reason=self._why_not(limits, **wanted))

    def cheapest(self, **wanted: Unpack[PlanLimits]) -> Plan:
        """Return the plan of least total cost within a bound on mu; see `cheapest_plan`."""
        if wanted.get("max_preference") is not None:
            self._require_bound(**wanted)
        elif self.problem.measure.contract == "general" and (reason := self._infeasible()):
            raise NoPlanError(reason)
        limits = _limits(**wanted)
        plans = self._search(limits, single=True, **wanted)
        if (plan := next(plans, None)) is not None:
            return plan
        if limits.ended:
            raise UnfinishedError(limits.ended, complete_below=self._below(limits))
        raise NoPlanError(self._why_not(limits, **wanted))

    def preferred(self, *, max_preference: Number | None = None, **wanted: Unpack[FrontLimits]) -> Plan:
        """Return the plan of least mu; see `preferred_plan`."""
        front = self.front(**wanted)
        if front.reason:
            raise NoPlanError(front.reason)
        best: Plan | None = front[-1] if front else None
        smallest = None if best is None else best.preference
        if best and max_preference is not None and exact(best.preference) > inclusive(max_preference):
            best = None
        if front.ended:
            raise UnfinishedError(front.ended, complete_below=front.complete_below, best=best)
        if best is None:
            raise NoPlanError(Reason("bound", smallest=smallest))
        return best

    def _below(self, limits: Limits) -> Number | None:
        """Return up to which cost a search that was stopped has found everything, in the user's units."""
        return (
            to_number(Fraction(limits.complete_below) * self.problem.units.cost)
            if limits.complete_below < math.inf
            else None
        )

    def _require_bound(self, **wanted: Unpack[PlanLimits]) -> None:
        if self.problem.measure.contract == "general" and wanted.get("max_cost") is None:
            raise PreferenceError(
                "preference: its contract is 'general', so that its front may be infinite; "
                "a bound on the total cost is needed (--max-cost)"
            )

    def _search(self, limits: Limits, *, single: bool = False, **wanted: Unpack[PlanLimits]) -> Iterator[Plan]:
        """Yield the plans of the front, or its first one only, accounting for the work as it is done."""
        began = time.perf_counter()
        mu, cost = wanted.get("max_preference"), wanted.get("max_cost")
        max_mu = None if mu is None else inclusive(mu, "max_preference")
        max_cost = math.inf if cost is None else math.floor(inclusive(cost, "max_cost") / self.problem.units.cost)
        yielded = -1
        for exact_numbers in (False, True):
            try:
                search = self._prepared_search(max_mu, max_cost, limits, single=single, exact_numbers=exact_numbers)
                if search is None:
                    return
                for found in search.goals(limits) if not limits.ended else ():
                    self._account(search, began)
                    if found.cost > yielded:
                        yielded = found.cost
                        self._check(found)
                        yield found.plan
                        if single:
                            return
                self._account(search, began)
                return
            except OverflowError:
                if exact_numbers:
                    raise
                # What 64 bits may not hold is searched again in Python's integers.
                limits.ended = None

    def _prepared_search(
        self, max_mu: Fraction | None, max_cost: float, limits: Limits, *, single: bool, exact_numbers: bool
    ) -> Search | ExactSearch | None:
        """Return the search that fits the measure; None if memory does not suffice for it.

        Raises:
            OverflowError: 64 bits may not hold its numbers.
        """
        measure, options = self.problem.measure, self._options
        if exact_numbers or measure.rounds or not options.compiled:
            return ExactSearch(self._product, max_mu=max_mu, max_cost=max_cost)
        if bytes_to_prepare(self._product) > limits.bytes:
            limits.ended = "memory"
            return None
        prepared = Prepared(self._product, options, single=single, max_bytes=limits.bytes)
        if not measure.bi_objective:
            return VectorSearch(prepared, max_mu=max_mu, max_cost=max_cost)
        if single and max_mu is None:
            return self._tightest(prepared, limits, max_cost)
        return BiObjectiveSearch(prepared, max_mu=max_mu, max_cost=max_cost, first_only=single)

    def _tightest(self, prepared: Prepared, limits: Limits, max_cost: float) -> Search:
        """Return a search for the least mu among the cheapest plans: one of those is found by A*, then improved on."""
        alone = BiObjectiveSearch(prepared, max_cost=max_cost, cost_only=True)
        cheapest = next(alone.goals(limits), None)
        if cheapest is None:
            return alone
        return BiObjectiveSearch(prepared, max_mu=Fraction(cheapest.mu), max_cost=cheapest.cost)

    def _check(self, found: Found) -> None:
        """Assert that a plan worked out from the model is worth what the search counted."""
        assert found.plan.cost == to_number(found.cost * self.problem.units.cost)
        assert found.label_mu is None or found.label_mu == in_units(self._product, found.mu)

    def _account(self, search: Search | ExactSearch, began: float) -> None:
        seconds = time.perf_counter() - began
        self.stats = replace(search.work, build_seconds=self._build_seconds, seconds=seconds)

    def _why_not(self, limits: Limits, **wanted: Unpack[PlanLimits]) -> Reason:
        """Return why a search found nothing; what else was possible is looked for within what its limits leave."""
        reason = self._infeasible()
        if reason is not None:
            return reason
        if wanted.get("max_preference") is None:
            assert wanted.get("max_cost") is not None
            try:
                cheapest = self.cheapest(max_seconds=limits.seconds_left, max_memory=limits.bytes)
            except UnfinishedError:
                return Reason("bound")
            return Reason("bound", smallest=cheapest.cost)
        front = self.front(max_cost=wanted.get("max_cost"), max_seconds=limits.seconds_left, max_memory=limits.bytes)
        return Reason("bound", smallest=front[-1].preference if front and front.complete else None)

    def _infeasible(self) -> Reason | None:
        """Return which tasks cannot be satisfied together, or None if all of them can."""
        if satisfiable(self.problem, self.problem.tasks):
            return None
        blame = conflict(self.problem)
        return Reason("task" if len(blame) == 1 else "conflict", blame)


def _limits(
    *,
    max_seconds: float | None = None,
    max_memory: float | None = None,
    max_cost: Number | None = None,
    max_preference: Number | None = None,
) -> Limits:
    """Return the limits of time and memory; the search itself keeps the bounds of cost and mu."""
    memory = MEMORY_SHARE * available_memory() if max_memory is None else max_memory
    return Limits(math.inf if max_seconds is None else max_seconds, memory)


def satisfiable(problem: Problem, tasks: tuple[Task, ...]) -> bool:
    """Return whether some plan satisfies some of a problem's tasks, as relaxed as they may be."""
    nothing = WeightedSum({task.name: 0 for task in tasks}, over="violation")
    # What anything costs does not matter.
    system = replace(problem.system, costs=np.zeros(len(problem.system.costs), dtype=np.int64))
    free = tuple(
        replace(task, relax=tuple(replace(r, cost=0) for r in task.relax), skip=None if task.skip is None else 0)
        for task in tasks
    )
    product = Product(Problem(system, free, nothing))
    search = BiObjectiveSearch(Prepared(product, Options(heuristic=1), single=True), cost_only=True)
    return next(search.goals(Limits()), None) is not None


def conflict(problem: Problem) -> tuple[str, ...]:
    """Return the names of a smallest set of tasks that cannot be satisfied together; empty if all of them can."""
    for size in range(1, len(problem.tasks) + 1):
        for tasks in combinations(problem.tasks, size):
            if not satisfiable(problem, tasks):
                return tuple(task.name for task in tasks)
    return ()
