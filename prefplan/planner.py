"""From a problem to its plans: a single plan, within bounds if wanted, or the whole Pareto front."""

from __future__ import annotations

import math
import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from fractions import Fraction
from typing import Any, Unpack

from prefplan.errors import LimitError, PreferenceError, PrefplanError, choices
from prefplan.exact_costs import Number, admits, to_number
from prefplan.front import Front, NoPlanError, Reason, Stats, UnfinishedError
from prefplan.heuristics.preprocessing import Options, Prepared, bytes_to_prepare
from prefplan.limits import Limits
from prefplan.plan import Plan
from prefplan.product.product_automaton import Product
from prefplan.product.reduction import Reduction
from prefplan.scenario.decode import ProblemLike, problem_of
from prefplan.search.bi_objective_search import BiObjectiveSearch
from prefplan.search.bounds import FrontLimits, PlanLimits, limits_of, require_bounds
from prefplan.search.driver import Found, Search, in_units
from prefplan.search.incumbent import AnytimeSearch, CheapestSearch
from prefplan.search.infeasibility import infeasible
from prefplan.search.objective_search import ObjectiveSearch
from prefplan.search.reference import ReferenceSearch, needs_exact_numbers
from prefplan.search.vector_search import VectorSearch

AnySearch = Search | AnytimeSearch | CheapestSearch | ReferenceSearch


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
        UnfinishedError: if a limit ended the search first.
        PreferenceError: if a cost bound is needed.
    """
    return Planner(problem, options=options).cheapest(**limits)


def preferred_plan(problem: ProblemLike, *, options: Options | None = None, **limits: Unpack[PlanLimits]) -> Plan:
    """Return the plan of least mu, and of least total cost among those; arguments are those of `cheapest_plan`.

    Raises:
        NoPlanError: if there is none, or its mu exceeds the bound.
        UnfinishedError: if a limit ended the search first; its `best` is the plan of least mu known by then.
        PreferenceError: if a cost bound is needed.
    """
    return Planner(problem, options=options).preferred(**limits)


def best_plan(
    problem: ProblemLike, objective: str, *, options: Options | None = None, **limits: Unpack[PlanLimits]
) -> Plan:
    """Return the plan of least value of an objective, a cost or preference given by name.

    Ties go to the least values of the other objectives, in their order. Other arguments are those of `cheapest_plan`.

    Raises:
        NoPlanError: if there is none within the bounds.
        UnfinishedError: if a limit ended the search first; its `best` is the best plan known by then.
        PrefplanError: if there is no objective with this name.
        PreferenceError: if a cost bound is needed.
    """
    return Planner(problem, options=options).best(objective, **limits)


class Planner:
    """Plans for one problem; its product is built once for all searches.

    Attributes:
        problem: the problem.
        stats: work and time of the last search.
    """

    def __init__(self, problem: ProblemLike, *, options: Options | None = None) -> None:
        """Take the problem; its product is built at the first search, within the limits of that search."""
        self.problem = problem_of(problem)
        self.stats = Stats()
        self._options = options or Options()
        self._reduction = Reduction(self.problem, generated=self._options.generated)

    @property
    def _product(self) -> Product:
        return self._reduction.product

    def front(
        self, *, over: Collection[str] = (), keep_on_interrupt: bool = False, **wanted: Unpack[FrontLimits]
    ) -> Front:
        """Return the Pareto front; see `pareto_front`.

        Args:
            over: the names of the objectives that count; none for all.
            keep_on_interrupt: return the points found so far on Ctrl-C, instead of raising KeyboardInterrupt.
            **wanted: see `FrontLimits`.
        """
        if len(set(over)) == 1:
            return self._front_of_one(*set(over), keep_on_interrupt=keep_on_interrupt, **wanted)
        limits, bounds = limits_of(self.problem, **wanted)
        require_bounds(self.problem, bounds)
        plans: list[Plan] = []
        known: Plan | None = None
        reason: Reason | None = None
        with _stopped_by(limits, interrupts=keep_on_interrupt):
            for goal, plan in self._search(limits, bounds):
                if goal.least_cost is None:
                    plans.append(plan)
                else:
                    known = plan
            if not plans and not limits.ended:
                reason = self._why_not(limits, bounds)
        if known is not None and not plans:
            plans.append(known)
        below = None if limits.ended is None else self._below(limits)
        front = self._front_with(plans, reason=reason, ended=limits.ended, complete_below=below)
        return front.over(over) if over else front

    def _front_of_one(self, objective: str, **wanted: Any) -> Front:
        """Return the front of one objective: its best plan."""
        try:
            return self._front_with([self.best(objective, **wanted)])
        except NoPlanError as error:
            return self._front_with([], reason=error.reason)
        except UnfinishedError as error:
            return self._front_with([error.best] if error.best else [], ended=error.ended)

    def _front_with(self, plans: Sequence[Plan], **ending: Any) -> Front:
        return Front(
            tuple(plans),
            resolution=self.problem.resolution,
            claimed=any(o.measure.claimed for o in self.problem.objectives),
            assumptions=self.problem.assumptions,
            stats=self.stats,
            **ending,
        )

    def best(self, objective: str, *, keep_on_interrupt: bool = False, **wanted: Unpack[PlanLimits]) -> Plan:
        """Return the plan of least value of one objective; see `best_plan`.

        With `keep_on_interrupt`, Ctrl-C raises UnfinishedError in place of KeyboardInterrupt.
        """
        names = self.problem.objective_names
        if objective not in names:
            raise PrefplanError(f"unknown objective {objective!r} {choices(objective, names)}")
        if self.problem.is_bi_objective:
            choose = self.cheapest if objective == names[0] else self.preferred
            return choose(keep_on_interrupt=keep_on_interrupt, **wanted)
        limits, bounds = limits_of(self.problem, **wanted)
        require_bounds(self.problem, bounds)
        place, found = names.index(objective), list[tuple[tuple[Any, ...], Plan]]()
        with _stopped_by(limits, interrupts=keep_on_interrupt):
            for goal, plan in self._search(limits, bounds, first=objective):
                found.append((goal.objectives or (), plan))
            if not found and not limits.ended:
                raise NoPlanError(self._why_not(limits, bounds))
        best = min(found, key=lambda pair: (pair[0][place], *pair[0]))[1] if found else None
        if limits.ended or best is None:
            raise UnfinishedError(limits.ended or "", best=best)
        return best

    def cheapest(self, *, keep_on_interrupt: bool = False, **wanted: Unpack[PlanLimits]) -> Plan:
        """Return the plan of least total cost within a bound on mu; see `cheapest_plan` and `best`."""
        cost, *others = self.problem.objective_names
        if not self.problem.is_bi_objective:
            return self.best(cost, keep_on_interrupt=keep_on_interrupt, **wanted)
        limits, bounds = limits_of(self.problem, **wanted)
        is_bounded = others[0] in bounds
        if is_bounded:
            require_bounds(self.problem, bounds)
        known: tuple[Found, Plan] | None = None
        with _stopped_by(limits, interrupts=keep_on_interrupt):
            if self.problem.measure.contract == "general" and not is_bounded:
                reason = infeasible(self._reduction, limits)
                if reason is not None:
                    raise NoPlanError(reason)
            for goal, plan in self._search(limits, bounds, single=True):
                if goal.least_cost is None:
                    return plan
                known = goal, plan
            if not limits.ended:
                raise NoPlanError(self._why_not(limits, bounds))
        raise self._unfinished(limits, known)

    def _unfinished(self, limits: Limits, known: tuple[Found, Plan] | None) -> UnfinishedError:
        """Return the error of a search for a cheapest plan that was stopped, given the best plan known by then."""
        ended, below = limits.ended or "", self._below(limits)
        if known is None:
            return UnfinishedError(ended, complete_below=below)
        goal, plan = known
        proven = limits.complete_below if limits.complete_below < math.inf else 0
        least = max(proven, goal.least_cost or 0)
        gap = 100 * max(goal.cost - least, 0) / least if least else None
        within = None if gap is None else math.ceil(10 * gap) / 10
        return UnfinishedError(ended, complete_below=below, best=plan, within=within)

    def preferred(self, *, keep_on_interrupt: bool = False, **wanted: Unpack[PlanLimits]) -> Plan:
        """Return the plan of least mu; see `preferred_plan` and `best`."""
        if not self.problem.preferences:
            raise PrefplanError(f"there is no preference {choices('', self.problem.objective_names)}")
        if not self.problem.is_bi_objective:
            return self.best(self.problem.preferences[0].name, keep_on_interrupt=keep_on_interrupt, **wanted)
        _, bounds = limits_of(self.problem, **wanted)
        cost, preference = self.problem.objective_names
        front = self.front(
            keep_on_interrupt=keep_on_interrupt,
            max_cost=bounds.get(cost),
            max_seconds=wanted.get("max_seconds"),
            max_memory=wanted.get("max_memory"),
        )
        if front.reason:
            raise NoPlanError(front.reason)
        best: Plan | None = front[-1] if front else None
        smallest = None if best is None else best.preference
        if best and preference in bounds and not admits(bounds[preference], best.preference):
            best = None
        if front.ended:
            raise UnfinishedError(front.ended, complete_below=front.complete_below, best=best)
        if best is None:
            raise NoPlanError(Reason("bound", smallest=smallest))
        return best

    def _search(
        self,
        limits: Limits,
        bounds: Mapping[str, Fraction],
        *,
        first: str | None = None,
        single: bool = False,
    ) -> Iterator[tuple[Found, Plan]]:
        """Yield the goals of the front with their plans, and update `stats`.

        While there is none, plans that need not be on the front may be yielded (`Found.least_cost`).

        Args:
            limits: of time and memory.
            bounds: inclusive, of objectives by name.
            first: of several objectives, the one whose least value is wanted; None for the front.
            single: only the first goal is wanted.
        """
        product, began, yielded = self._product, time.perf_counter(), set[Any]()
        for exact_numbers in (not self._options.compiled or needs_exact_numbers(self.problem), True):
            try:
                search: AnySearch
                if exact_numbers:
                    search = ReferenceSearch(self._reduction.listed_product(self.problem), bounds=bounds)
                elif len(self.problem.cost_names) * bytes_to_prepare(product) > limits.bytes:
                    raise LimitError("memory")
                elif self.problem.is_bi_objective:
                    search = self._bi_objective_search(limits, bounds, single=single)
                else:
                    search = ObjectiveSearch(product, self._options, bounds=bounds, first=first, max_bytes=limits.bytes)
                for found in search.goals(limits):
                    self._account(search, began)
                    worth = found.least_cost, found.cost if self.problem.is_bi_objective else found.objectives
                    if worth not in yielded:
                        yielded.add(worth)
                        yield found, self._checked(found, search.product)
                self._account(search, began)
                return
            except OverflowError:
                if exact_numbers:
                    raise
                # A number might not fit 64 bits: search again in Python's integers.
                limits.ended = None

    def _bi_objective_search(self, limits: Limits, bounds: Mapping[str, Fraction], *, single: bool) -> AnySearch:
        """Return the compiled search for one cost and one preference that suits the preference's terms.

        Raises:
            OverflowError: a number might not fit 64 bits.
        """
        measure, (cost, preference) = self.problem.measure, self.problem.objective_names
        max_mu = bounds.get(preference)
        max_cost = math.floor(bounds[cost] / self.problem.units.cost) if cost in bounds else math.inf
        prepared = Prepared(self._product, self._options, single=single, max_bytes=limits.bytes)
        if not measure.bi_objective:
            return VectorSearch(prepared, max_mu=max_mu, max_cost=max_cost)
        if single and max_mu is None:
            return CheapestSearch(prepared, max_cost)
        search = BiObjectiveSearch(prepared, max_mu=max_mu, max_cost=max_cost, first_only=single)
        return search if single else AnytimeSearch(search)

    def _checked(self, found: Found, searched: Product) -> Plan:
        """Return the plan of a goal, asserting that its costs and preferences in the model are those of the search."""
        plan = self._reduction.lifted(found.plan, searched)
        if found.objectives is not None:
            worth = tuple(map(to_number, found.objectives))
            assert tuple(found.plan.objectives.values()) == worth, "the plan is worth something else in the model"
            return plan
        assert plan.cost == to_number(found.cost * self.problem.units.cost)
        assert found.label_mu in (None, in_units(self._product, found.mu))
        return plan

    def _account(self, search: AnySearch, began: float) -> None:
        seconds = time.perf_counter() - began
        self.stats = replace(search.work, build_seconds=self._reduction.build_seconds, seconds=seconds)

    def _below(self, limits: Limits) -> Number | None:
        """Return the cost below which a stopped search has found every point, in the user's units; None if it ended."""
        if limits.complete_below == math.inf:
            return None
        return to_number(Fraction(limits.complete_below) * self.problem.units.cost)

    def _why_not(self, limits: Limits, bounds: Mapping[str, Fraction]) -> Reason:
        """Return why a search found nothing; the least possible value is searched for within what its limits leave."""
        reason = infeasible(self._reduction, limits)
        if reason is not None:
            return reason
        left: FrontLimits = {"max_seconds": limits.seconds_left, "max_memory": limits.bytes}
        smallest: Number | None = None
        with suppress(UnfinishedError, PreferenceError):
            if not self.problem.is_bi_objective:
                if len(bounds) == 1:
                    [name] = bounds
                    smallest = self.best(name, **left).objectives[name]
            elif self.problem.objective_names[1] not in bounds:
                smallest = self.cheapest(**left).cost
            else:
                left["max_cost"] = bounds.get(self.problem.objective_names[0])
                front = self.front(**left)
                smallest = front[-1].preference if front and front.complete else None
        return Reason("bound", smallest=smallest)


@contextmanager
def _stopped_by(limits: Limits, *, interrupts: bool) -> Iterator[None]:
    """Work within limits: a limit that stops the work is noted in them, and so is Ctrl-C if wanted."""
    try:
        with limits:
            yield
    except LimitError as error:
        limits.ended = error.ended
    except KeyboardInterrupt:
        if not interrupts:
            raise
        limits.ended = "interrupt"
