"""From a problem to its plans: a single plan, within bounds if wanted, or the whole Pareto front."""

import math
import time
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from typing import Unpack

from prefplan.errors import LimitError, PreferenceError, PrefplanError, choices
from prefplan.exact_costs import exact, to_number
from prefplan.front import Front, NoPlanError, Reason, Stats, UnfinishedError
from prefplan.heuristics.prepare import Options
from prefplan.models.feasibility import Geometry
from prefplan.plan import OnDemand, Plan
from prefplan.product.product_automaton import Product
from prefplan.product.reduction import product_of
from prefplan.scenario.decode import ProblemLike, problem_of
from prefplan.search.bounds import FrontLimits, PlanLimits, limits_of, require_bounds
from prefplan.search.incumbent import run_search
from prefplan.search.infeasibility import infeasible
from prefplan.search.paths import ended_by


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
    """Return the plan of least total cost whose mu does not exceed a bound (Algorithm 1); ties go to the least mu.

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
    """Return the plan of least mu; ties go to the least total cost. For the rest see `cheapest_plan`."""
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
        geometry: the actions that searches left out because the arm cannot do them; None for an abstract problem.
    """

    _search = staticmethod(run_search)

    def __init__(self, problem: ProblemLike, *, options: Options | None = None) -> None:
        """Take the problem; its product is built at the first search, within the limits of that search."""
        self.problem = problem_of(problem)
        self.stats = Stats()
        self._options = options or Options()
        # The problem without the actions that the arm is known to be unable to do, and its product once it is built.
        self._ahead = self.problem
        self._product: Product | None = None
        feasible, past = self.problem.feasible, len(self.problem.past.actions)
        self.geometry = None if feasible is None else Geometry(feasible, past)

    def front(
        self, *, over: Collection[str] = (), keep_on_interrupt: bool = False, **wanted: Unpack[FrontLimits]
    ) -> Front:
        """Return the Pareto front; see `pareto_front`.

        Args:
            over: the names of the objectives that count; empty for all.
            keep_on_interrupt: return the points found so far on Ctrl-C, instead of raising KeyboardInterrupt.
            **wanted: see `FrontLimits`.
        """
        front = self._front(over, keep_on_interrupt=keep_on_interrupt, **wanted)
        return replace(front, complete_below=None) if len(set(over)) == 1 else front

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
        front = self._front([objective], keep_on_interrupt=keep_on_interrupt, **wanted)
        if front.reason is not None:
            raise NoPlanError(front.reason)
        plan, below, within = next(iter(front), None), front.complete_below, None
        if plan is not None and front.ended is None:
            return plan
        if plan is not None and below and objective == self.problem.objective_names[0]:
            gap = exact(plan.cost) / exact(below) - 1
            within = max(0.0, math.ceil(1000 * gap) / 10)
        raise UnfinishedError(front.ended or "", complete_below=below, best=plan, within=within)

    def _front(self, over: Collection[str], *, keep_on_interrupt: bool = False, **wanted: Unpack[PlanLimits]) -> Front:
        """Return the front over some objectives, of one plan if there is one objective; see `front`.

        The search is repeated, without what the arm turned out to be unable to do, until the arm can do all its plans.
        """
        names = self.problem.objective_names
        for name in over:
            if name not in names:
                raise PrefplanError(f"unknown objective {name!r} {choices(name, names)}")
        objective = next(iter(over)) if len(set(over)) == 1 else None
        limits, bounds = limits_of(self.problem, **wanted)
        front, self.stats = Front((), complete_below=0), Stats()
        try:
            with limits:
                while True:
                    front = self._solve(objective, bounds)
                    front = front.over(over) if over else front
                    if self.geometry is None or front.ended is not None:
                        break
                    if not self.geometry.exclude(front):
                        break
                    self._ahead, self._product = self.geometry.without(self.problem), None
        except (LimitError, KeyboardInterrupt) as error:
            front = replace(front, ended=ended_by(error))
        if front.ended == "interrupt" and not keep_on_interrupt:
            raise KeyboardInterrupt
        assumptions = self.problem.assumptions
        if self.geometry is not None and front.ended is not None:
            front = replace(front, plans=tuple(filter(self.geometry.holds, front)), known_points=None)
        if self.geometry is not None:
            self.geometry.compare(front)
            assumptions += (self.geometry.note,) if self.geometry.note else ()
        return replace(front, assumptions=assumptions, stats=self.stats)

    def _solve(self, objective: str | None, bounds: Mapping[str, Fraction]) -> Front:
        """Return the front, or the plan of least value of an objective, without actions that the arm cannot do."""
        names, began = self.problem.objective_names, time.perf_counter()
        is_cheapest = self.problem.is_bi_objective and objective == names[0] and names[1] not in bounds
        if self.problem.is_general and not is_cheapest:
            require_bounds(self.problem, bounds)
        elif self.problem.is_general and (reason := infeasible(self._ahead)):
            # Without a bound, the search may never end if there is no plan.
            return Front((), reason=reason)
        product = self._product = self._product or product_of(self._ahead)
        built = time.perf_counter()
        result = self._search(product, self._options, bounds, objective)
        self.stats += replace(result.work, build_seconds=built - began, seconds=time.perf_counter() - began)
        goals, below = result.goals, result.complete_below
        if goals and objective is not None:
            place = names.index(objective)
            goals = (min(goals, key=lambda goal: (goal.objectives[place], *goal.objectives)),)
        return Front(
            OnDemand(len(goals), lambda k: goals[k].plan) if goals else (),
            reason=None if goals or result.ended else self._why_not(bounds),
            ended=result.ended,
            complete_below=None if below == math.inf else to_number(Fraction(below) * self.problem.cost_units[0]),
            known_points=[goal.point for goal in goals],
        )

    def _why_not(self, bounds: Mapping[str, Fraction]) -> Reason:
        """Return why a search found nothing; the limits also hold for the search for the least possible value."""
        if reason := infeasible(self._ahead):
            return reason
        *others, bounded = sorted(bounds, key=self.problem.objective_names.index)
        if self.problem.is_bi_objective or not others:
            with suppress(NoPlanError, UnfinishedError, PreferenceError):
                smallest = self.best(bounded, at_most={name: bounds[name] for name in others}).objectives[bounded]
                return Reason("bound", smallest=smallest)
        return Reason("bound")
