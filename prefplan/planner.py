"""From a problem to its plans: a single plan, within bounds if wanted, or the whole Pareto front."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from fractions import Fraction
from typing import Any, Unpack

from prefplan.anytime.guided import CheapestSearch, begun, draft, prepare_draft
from prefplan.anytime.narrowing import NarrowingSearch, proven_percent
from prefplan.assumptions import assumptions
from prefplan.errors import LimitError, PreferenceError, PrefplanError, choices
from prefplan.exact_costs import Number, admits, exact, to_number
from prefplan.front import Front, NoPlanError, Reason, Stats, UnfinishedError
from prefplan.heuristics.preprocessing import Options, Prepared, bytes_to_prepare
from prefplan.limits import EXACT, Limits, Percent, percent
from prefplan.plan import Plan
from prefplan.product.product_automaton import Product
from prefplan.product.reduction import Reduction
from prefplan.scenario.decode import ProblemLike, problem_of
from prefplan.search.bi_objective_search import BiObjectiveSearch
from prefplan.search.bounds import FrontLimits, PlanLimits, limits_of, require_bounds
from prefplan.search.driver import Found, Search, in_units
from prefplan.search.exact_search import ExactSearch, needs_exact_numbers
from prefplan.search.infeasibility import infeasible
from prefplan.search.objective_search import ObjectiveSearch
from prefplan.search.vector_search import VectorSearch

AnySearch = Search | ExactSearch | NarrowingSearch


def pareto_front(
    problem: ProblemLike, *, within: Number = 0, options: Options | None = None, **limits: Unpack[FrontLimits]
) -> Front:
    """Return the Pareto front of all costs and preferences; empty, with a reason, if there is no plan.

    If a limit of time or memory ends the search, the front has the points found so far, and `ended` names the limit.

    Args:
        problem: the problem, or a scenario, or its name or path; see `problem_of`.
        within: percentage; points may be left out if another plan's cost and mu exceed theirs by at most this. Ignored
            for several costs or preferences.
        options: how to search; the front does not depend on it.
        **limits: `max_cost`, `at_most`, `max_seconds` and `max_memory`, see `FrontLimits`.

    Raises:
        PreferenceError: if a cost bound is needed.
    """
    return Planner(problem, options=options).front(within=within, **limits)


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
        self._cheapest: CheapestSearch | None = None
        self._draft: list[Plan] = []
        self._begun: BiObjectiveSearch | None = None
        self._stopped: AnySearch | None = None

    @property
    def _product(self) -> Product:
        return self._reduction.product

    def front(self, *, within: Number = 0, keep_on_interrupt: bool = False, **wanted: Unpack[FrontLimits]) -> Front:
        """Return the Pareto front; see `pareto_front`.

        Args:
            within: as in `pareto_front`.
            keep_on_interrupt: return the points found so far on Ctrl-C, instead of raising KeyboardInterrupt.
            **wanted: see `FrontLimits`.
        """
        limits, bounds = limits_of(self.problem, **wanted)
        tolerance = percent(within)
        if not self.problem.is_bi_objective:
            # Approximation is not implemented for more objectives.
            tolerance = EXACT
        require_bounds(self.problem, bounds)
        plans: list[Plan] = []
        self._begun, self._stopped, self._draft = None, None, []
        reason: Reason | None = None
        with _stopped_by(limits, interrupts=keep_on_interrupt):
            for _, plan in self._search(limits, bounds, tolerance=tolerance):
                plans.append(plan)
            if not plans and not limits.ended:
                reason = self._why_not(limits, bounds)
        if limits.ended:
            plans += self._draft
        if tolerance.value or self._draft:
            plans = _undominated(plans)
        return Front(
            tuple(plans),
            reason,
            ended=limits.ended,
            complete_below=None if limits.ended is None or tolerance.value else self._below(limits),
            within=to_number(tolerance.value) if limits.ended is None else self._proven(plans),
            resolution=self.problem.resolution,
            claimed=any(o.measure.claimed for o in self.problem.objectives),
            assumptions=assumptions(self.problem),
            stats=self.stats,
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
        self._cheapest = None
        plan: Plan | None = None
        with _stopped_by(limits, interrupts=keep_on_interrupt):
            if self.problem.measure.contract == "general" and not is_bounded:
                reason = infeasible(self._reduction, limits)
                if reason is not None:
                    raise NoPlanError(reason)
            plan = next((plan for _, plan in self._search(limits, bounds, single=True)), None)
            if plan is None and not limits.ended:
                raise NoPlanError(self._why_not(limits, bounds))
        if plan is not None:
            return plan
        known = self._cheapest
        if known is None or known.incumbent is None:
            raise UnfinishedError(limits.ended or "", complete_below=self._below(limits))
        below = max(limits.complete_below, known.least_cost)
        gap = 100 * (known.incumbent.cost - below) / below if below else None
        raise UnfinishedError(
            limits.ended or "",
            complete_below=self._below(limits),
            best=self._checked(known.incumbent, self._product),
            within=None if gap is None else math.ceil(10 * max(gap, 0)) / 10,
        )

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
        tolerance: Percent = EXACT,
    ) -> Iterator[tuple[Found, Plan]]:
        """Yield the goals of the front with their plans, and update `stats`.

        Args:
            limits: of time and memory.
            bounds: inclusive, of objectives by name.
            first: of several objectives, the one whose least value is wanted; None for the front.
            single: yield the first goal only.
            tolerance: of a front of one cost and one preference.
        """
        product, began, yielded = self._product, time.perf_counter(), set[Any]()
        for exact_numbers in (not self._options.compiled or needs_exact_numbers(self.problem), True):
            try:
                search: AnySearch
                if exact_numbers:
                    search = ExactSearch(self._reduction.listed_product(self.problem), bounds=bounds)
                elif len(self.problem.cost_names) * bytes_to_prepare(product) > limits.bytes:
                    raise LimitError("memory")
                elif self.problem.is_bi_objective:
                    search = self._bi_objective_search(limits, bounds, single=single, tolerance=tolerance)
                else:
                    search = ObjectiveSearch(product, self._options, bounds=bounds, first=first, max_bytes=limits.bytes)
                self._stopped = search
                for found in search.goals(limits) if not limits.ended else ():
                    self._account(search, began)
                    worth = found.cost if self.problem.is_bi_objective else found.objectives
                    if tolerance.value or worth not in yielded:
                        yielded.add(worth)
                        yield found, self._checked(found, search.product)
                        if single:
                            return
                self._account(search, began)
                return
            except OverflowError:
                if exact_numbers:
                    raise
                # A number might not fit 64 bits: search again in Python's integers.
                limits.ended = None

    def _bi_objective_search(
        self, limits: Limits, bounds: Mapping[str, Fraction], *, single: bool, tolerance: Percent
    ) -> AnySearch:
        """Return the compiled search for one cost and one preference that suits the preference's terms.

        Raises:
            OverflowError: a number might not fit 64 bits.
        """
        measure, product, options = self.problem.measure, self._product, self._options
        cost, preference = self.problem.objective_names
        max_mu = bounds.get(preference)
        max_cost = math.floor(bounds[cost] / self.problem.units.cost) if cost in bounds else math.inf
        if single and max_mu is None and measure.bi_objective:
            self._cheapest = CheapestSearch(product, options, limits, max_cost)
            return self._cheapest.search()
        drafted = self._draft_front(limits, max_cost) if measure.bi_objective else []
        prepared = Prepared(product, options, single=single, max_bytes=limits.bytes)
        if not measure.bi_objective:
            return VectorSearch(prepared, max_mu=max_mu, max_cost=max_cost, tolerance=tolerance)
        if tolerance.value and max_mu is None:
            return NarrowingSearch(prepared, tolerance, max_cost=max_cost, drafted=drafted)
        return BiObjectiveSearch(prepared, max_mu=max_mu, max_cost=max_cost, first_only=single, drafted=drafted)

    def _draft_front(self, limits: Limits, max_cost: float) -> list[Found]:
        """Return plans close to the front, found early; none for few tasks, where the front itself is found early."""
        drafted = []
        if len(self.problem.tasks) >= self._options.drafted_tasks:
            light = prepare_draft(self._product, self._options, limits.bytes)
            self._begun = begun(light)
            for found in draft(light, max_cost):
                drafted.append(found)
                self._draft.append(self._checked(found, self._product))
        return drafted

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

    def _proven(self, plans: Sequence[Plan]) -> Number | None:
        """Return within what percentage of these plans the whole front is proven to be by a stopped search, or None."""
        points = [(exact(plan.cost), exact(plan.preference)) for plan in plans]
        proven = []
        if self._begun is not None:
            proven.append(proven_percent(self._begun, points))
        if isinstance(self._stopped, NarrowingSearch):
            proven.append(self._stopped.proven(points))
        elif isinstance(self._stopped, BiObjectiveSearch | VectorSearch):
            proven.append(proven_percent(self._stopped, points))
        least = min((percentage for percentage in proven if percentage is not None), default=None)
        return None if least is None else to_number(least)

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


def _undominated(plans: Sequence[Plan]) -> list[Plan]:
    """Return the plans that no other dominates in (cost, mu), in order of cost; of equal ones the first."""
    kept: list[Plan] = []
    for plan in sorted(plans, key=lambda plan: (plan.cost, plan.preference)):
        if not kept or plan.preference < kept[-1].preference:
            kept.append(plan)
    return kept
