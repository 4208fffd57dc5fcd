"""From a problem to its plans: a single plan, within bounds if wanted, or the whole Pareto front."""

from __future__ import annotations

import math
import time
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Unpack

from prefplan.errors import LimitError, PreferenceError, PrefplanError, choices
from prefplan.exact_costs import Number, to_number
from prefplan.front import Front, NoPlanError, Reason, Stats, UnfinishedError
from prefplan.heuristics.prepare import Options
from prefplan.limits import Limits
from prefplan.models.feasibility import Geometry
from prefplan.plan import Plan, Plans
from prefplan.product.reduction import Reduction
from prefplan.scenario.decode import ProblemLike, problem_of
from prefplan.search.bounds import FrontLimits, PlanLimits, limits_of, require_bounds
from prefplan.search.choice import choose_search
from prefplan.search.infeasibility import infeasible
from prefplan.search.reference import ReferenceSearch
from prefplan.search.result import Result, ended_by


def pareto_front(problem: ProblemLike, *, options: Options | None = None, **limits: Unpack[FrontLimits]) -> Front:
    """Return the Pareto front of all costs and preferences; empty, with a reason, if there is no plan.

    If a limit of time or memory ends the search, the front has the points found so far, and `ended` names the limit.

    Args:
        problem: the problem, or a scenario, or its name or path; see `problem_of`.
        options: how to search; the front does not depend on it.
        **limits: `max_cost`, `at_most`, `max_seconds` and `max_memory`, see `FrontLimits`.

    Raises:
        PreferenceError: if a cost bound is needed.
    """
    return Planner(problem, options=options).front(**limits)


def cheapest_plan(problem: ProblemLike, *, options: Options | None = None, **limits: Unpack[PlanLimits]) -> Plan:
    """Return the plan of least total cost whose mu does not exceed a bound (Algorithm 1), of least mu among those.

    Args:
        problem: the problem.
        options: how to search; cost and mu do not depend on it.
        **limits: those of `pareto_front`, and `max_preference`, see `PlanLimits`.

    Raises:
        NoPlanError: if there is none; its `reason` says why.
        UnfinishedError: if a limit ended the search first; its `best` is the best plan known by then.
        PreferenceError: if a cost bound is needed.
    """
    return Planner(problem, options=options).cheapest(**limits)


def preferred_plan(problem: ProblemLike, *, options: Options | None = None, **limits: Unpack[PlanLimits]) -> Plan:
    """Return the plan of least mu, and of least total cost among those; for the rest see `cheapest_plan`."""
    return Planner(problem, options=options).preferred(**limits)


def best_plan(
    problem: ProblemLike, objective: str, *, options: Options | None = None, **limits: Unpack[PlanLimits]
) -> Plan:
    """Return the plan of least value of an objective, a cost or preference given by name.

    Ties go to the least values of the other objectives, in their order. For the rest see `cheapest_plan`.

    Raises:
        PrefplanError: if there is no objective with this name.
    """
    return Planner(problem, options=options).best(objective, **limits)


class Planner:
    """Plans for one problem; its product is built once for all searches.

    Attributes:
        problem: the problem.
        stats: work and time of the last search.
        geometry: what searches have left out since the arm cannot do it; None for an abstract problem.
    """

    def __init__(self, problem: ProblemLike, *, options: Options | None = None) -> None:
        """Take the problem; its product is built at the first search, within the limits of that search."""
        self.problem = problem_of(problem)
        self.stats = Stats()
        self._options = options or Options()
        self._reduction = Reduction(self.problem)
        feasible, past = self.problem.feasible, len(self.problem.past.actions)
        self.geometry = None if feasible is None else Geometry(feasible, past)

    def front(
        self, *, over: Collection[str] = (), keep_on_interrupt: bool = False, **wanted: Unpack[FrontLimits]
    ) -> Front:
        """Return the Pareto front; see `pareto_front`.

        Args:
            over: the names of the objectives that count; none for all.
            keep_on_interrupt: return the points found so far on Ctrl-C, instead of raising KeyboardInterrupt.
            **wanted: see `FrontLimits`.
        """
        search = partial(self._front, over, keep_on_interrupt=keep_on_interrupt, **wanted)
        front = search()
        try:
            with limits_of(self.problem, **wanted)[0]:
                while front.ended is None and self._leave_out(front):
                    front = replace(again := search(), stats=front.stats + again.stats)
        except (LimitError, KeyboardInterrupt) as error:
            if isinstance(error, KeyboardInterrupt) and not keep_on_interrupt:
                raise
            front = replace(front, ended=ended_by(error), complete_below=None)
        self.stats = front.stats
        if self.geometry is None:
            return front
        if front.ended is not None:
            front = replace(front, plans=tuple(filter(self.geometry.holds, front)))
        note = self.geometry.note
        return replace(front, assumptions=(*front.assumptions, note)) if note else front

    def _front(self, over: Collection[str], *, keep_on_interrupt: bool, **wanted: Unpack[FrontLimits]) -> Front:
        """Return the front of the problem without what the arm is known to be unable to do."""
        one = next(iter(over)) if len(set(over)) == 1 else None
        result, reason = self._solve(one, keep_on_interrupt=keep_on_interrupt, **wanted)
        result.check()
        goals = result.goals or result.incumbents
        front = Front(
            Plans([goal.point for goal in goals], [goal.plan for goal in goals]) if goals else (),
            reason=reason,
            ended=result.ended,
            complete_below=None if result.ended is None or one else self._below(result),
            assumptions=self.problem.assumptions,
            stats=self.stats,
        )
        return front.over(over) if over else front

    def cheapest(self, *, keep_on_interrupt: bool = False, **wanted: Unpack[PlanLimits]) -> Plan:
        """Return the plan of least total cost within a bound on mu; see `cheapest_plan` and `best`."""
        return self.best(self.problem.cost_names[0], keep_on_interrupt=keep_on_interrupt, **wanted)

    def preferred(self, *, keep_on_interrupt: bool = False, **wanted: Unpack[PlanLimits]) -> Plan:
        """Return the plan of least mu; see `preferred_plan` and `best`."""
        if not self.problem.preferences:
            raise PrefplanError(f"there is no preference {choices('', self.problem.objective_names)}")
        return self.best(self.problem.preferences[0].name, keep_on_interrupt=keep_on_interrupt, **wanted)

    def best(self, objective: str, *, keep_on_interrupt: bool = False, **wanted: Unpack[PlanLimits]) -> Plan:
        """Return the plan of least value of one objective; see `best_plan`.

        With `keep_on_interrupt`, Ctrl-C raises UnfinishedError in place of KeyboardInterrupt.
        """
        search = partial(self._best, objective, keep_on_interrupt=keep_on_interrupt, **wanted)
        try:
            plan, work = search(), self.stats
            with limits_of(self.problem, **wanted)[0]:
                while self._leave_out([plan]):
                    plan, work = search(), work + self.stats
        except UnfinishedError as error:
            if error.best is None or self.geometry is None or self.geometry.holds(error.best):
                raise
            raise UnfinishedError(error.ended, complete_below=error.complete_below) from None
        except (LimitError, KeyboardInterrupt) as error:
            if isinstance(error, KeyboardInterrupt) and not keep_on_interrupt:
                raise
            raise UnfinishedError(ended_by(error)) from None
        self.stats = work
        return plan

    def _leave_out(self, plans: Sequence[Plan]) -> bool:
        """Leave out what plans need and the arm cannot do; return whether there is anything of the kind.

        Raises:
            LimitError: a limit was reached before all is known of what the plans need.
        """
        barred = self.geometry.excluded(plans) if self.geometry else ()
        if not barred:
            return False
        problem = self._reduction.problem
        self._reduction = Reduction(problem.over(problem.system.without(barred)))
        return True

    def _best(self, objective: str, *, keep_on_interrupt: bool, **wanted: Unpack[PlanLimits]) -> Plan:
        """Return the plan of least value of an objective without what the arm is known to be unable to do."""
        result, reason = self._solve(objective, keep_on_interrupt=keep_on_interrupt, **wanted)
        if reason is not None:
            raise NoPlanError(reason)
        goal = next(iter(result.goals or result.incumbents), None)
        plan = None if goal is None else goal.plan()
        if plan is not None and result.ended is None:
            return plan
        below, within = self._below(result), None
        if goal is not None and objective == self.problem.objective_names[0] and 0 < result.complete_below < math.inf:
            gap = 100 * max(goal.cost - result.complete_below, 0) / result.complete_below
            within = math.ceil(10 * gap) / 10
        raise UnfinishedError(result.ended or "", complete_below=below, best=plan, within=within)

    def _solve(
        self, objective: str | None, *, keep_on_interrupt: bool, **wanted: Unpack[PlanLimits]
    ) -> tuple[Result, Reason | None]:
        """Return what a search finds, and why there is no plan if there is none.

        Args:
            objective: the one whose least value is wanted, the only goal then; None for the front.
            keep_on_interrupt: whether Ctrl-C counts as a limit.
            **wanted: see `PlanLimits`.
        """
        names = self.problem.objective_names
        if objective is not None and objective not in names:
            raise PrefplanError(f"unknown objective {objective!r} {choices(objective, names)}")
        limits, bounds = limits_of(self.problem, **wanted)
        is_cheapest = self.problem.is_bi_objective and objective == names[0] and names[1] not in bounds
        if not is_cheapest:
            require_bounds(self.problem, bounds)
        result, reason, began = Result(), None, time.perf_counter()
        try:
            with limits:
                if is_cheapest and self.problem.is_general:
                    # Without a bound, the search for a plan that does not exist need not end.
                    reason = infeasible(self._reduction, limits)
                if reason is None:
                    result = self._search(limits, bounds, objective)
                    seconds = time.perf_counter() - began
                    self.stats = replace(result.work, build_seconds=self._reduction.build_seconds, seconds=seconds)
                    if not result.goals and result.ended is None:
                        reason = self._why_not(limits, bounds)
        except (LimitError, KeyboardInterrupt) as error:
            result = replace(result, ended=ended_by(error))
        if result.ended == "interrupt" and not keep_on_interrupt:
            raise KeyboardInterrupt
        return result if objective is None else result.with_best(names.index(objective)), reason

    def _search(self, limits: Limits, bounds: Mapping[str, Fraction], objective: str | None) -> Result:
        """Search in compiled code, or in Python's integers where a number might not fit 64 bits."""
        with suppress(OverflowError):
            return choose_search(self._reduction.product, self._options, limits, bounds, objective)(limits)
        return self._search_in_python(limits, bounds, objective)

    def _search_in_python(self, limits: Limits, bounds: Mapping[str, Fraction], objective: str | None) -> Result:
        product = self._reduction.listed_product(self._reduction.problem)
        single = self.problem.is_bi_objective and objective == self.problem.objective_names[0]
        return ReferenceSearch(product, bounds=bounds, single=single).run(limits)

    def _below(self, result: Result) -> Number | None:
        """Return the cost below which a search has every point, in the user's units; None if it ran to its end."""
        if result.complete_below == math.inf:
            return None
        return to_number(Fraction(result.complete_below) * self.problem.units.cost)

    def _why_not(self, limits: Limits, bounds: Mapping[str, Fraction]) -> Reason:
        """Return why a search found nothing; the least possible value is searched for within what its limits leave."""
        reason = infeasible(self._reduction, limits)
        if reason is not None:
            return reason
        smallest: Number | None = None
        *others, bounded = sorted(bounds, key=self.problem.objective_names.index)
        if self.problem.is_bi_objective or not others:
            left = PlanLimits(
                at_most={name: bounds[name] for name in others},
                max_seconds=limits.seconds_left,
                max_memory=limits.bytes,
            )
            with suppress(NoPlanError, UnfinishedError, PreferenceError):
                smallest = self.best(bounded, **left).objectives[bounded]
        return Reason("bound", smallest=smallest)
