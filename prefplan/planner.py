"""From a problem to its plans: one plan, one under a bound, or the whole Pareto front."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from itertools import combinations
from typing import Any, Unpack, cast

import numpy as np

from prefplan.errors import LimitError, PreferenceError, PrefplanError, choices
from prefplan.exact_costs import Number, admits, exact, inclusive, to_number
from prefplan.front import Front, NoPlanError, Plan, Reason, Stats, UnfinishedError
from prefplan.heuristics.preprocessing import Options, Prepared, bytes_to_prepare
from prefplan.ledger import Ledger
from prefplan.limits import EXACT, Limits, Percent, available_memory, percent
from prefplan.models.manipulation.quotient import ReducedModel
from prefplan.models.manipulation.system import ManipulationSystem
from prefplan.models.transition_system import Quotient
from prefplan.preferences.kinds import WeightedSum
from prefplan.problem import Problem, Rule, Task
from prefplan.product.generated_product import GeneratedProduct
from prefplan.product.product_automaton import Product
from prefplan.search.bounds import FrontLimits, PlanLimits, bounded, require_bounds
from prefplan.search.driver import BiObjectiveSearch, Found, Search, in_units
from prefplan.search.exact_search import ExactSearch
from prefplan.search.guided import DRAFTED_TASKS, CheapestSearch, begun, draft, prepare_draft
from prefplan.search.narrowing import NarrowingSearch, proven_percent
from prefplan.search.objective_search import points
from prefplan.search.vector_search import VectorSearch

AnySearch = Search | ExactSearch | NarrowingSearch

MEMORY_SHARE = 0.8
"""Part of the free memory that a search may take unless told otherwise."""


def pareto_front(
    problem: Problem, *, within: Number = 0, options: Options | None = None, **limits: Unpack[FrontLimits]
) -> Front:
    """Return the Pareto front of all costs and preferences; empty, with a reason, if there is no plan.

    A limit of time or memory leaves the points found so far; `ended` says which it was.

    Args:
        problem: what to plan.
        within: leave out what a plan of the front is good enough for: each point of the exact front has one whose cost
            and mu are at most so many percent larger.
        options: how to search; the front does not depend on it.
        **limits: `max_cost`, `at_most`, `max_seconds` and `max_memory`, see `FrontLimits`.

    Raises:
        PreferenceError: if a cost bound is needed.
    """
    return Planner(problem, options=options).front(within=within, **limits)


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
    """Return the plan of least mu, and of least total cost among those; arguments are those of `cheapest_plan`.

    Raises:
        NoPlanError: if there is none, or its mu exceeds the bound.
        UnfinishedError: if a limit ended the search first; its `best` is the plan of least mu known by then.
        PreferenceError: if a cost bound is needed.
    """
    return Planner(problem, options=options).preferred(**limits)


def best_plan(
    problem: Problem, objective: str, *, options: Options | None = None, **limits: Unpack[PlanLimits]
) -> Plan:
    """Return the plan of the least value of one cost or preference; of several, that of the least other values in turn.

    The objective is named; the other arguments are those of `cheapest_plan`.

    Raises:
        NoPlanError: if there is none within the bounds.
        UnfinishedError: if a limit ended the search first; its `best` is the best plan known by then.
        PrefplanError: if there is no such objective.
        PreferenceError: if a cost bound is needed.
    """
    return Planner(problem, options=options).best(objective, **limits)


class Planner:
    """A problem made ready to be searched.

    Attributes:
        problem: what is planned.
        stats: work and time of the last search.
    """

    def __init__(self, problem: Problem, *, options: Options | None = None) -> None:
        """Take the problem; what is searched is built at the first search, within its limits."""
        self.problem = problem
        self._options = options or Options()
        self.stats = Stats()
        self._cheapest: CheapestSearch | None = None
        self._draft: list[Plan] = []
        self._begun: Search | None = None
        self._stopped: AnySearch | None = None

    @cached_property
    def _quotient(self) -> Quotient:
        """What is searched in place of the problem's system."""
        return self.problem.system.quotient(self.problem.task_propositions, may_hurry=self.problem.may_hurry)

    @cached_property
    def _product(self) -> Product:
        """The tables of what is searched."""
        began = time.perf_counter()
        product = self._product_of(self.problem)
        self._build_seconds = time.perf_counter() - began
        return product

    def _product_of(self, problem: Problem) -> Product:
        """Return the tables of a problem over this one's model: state by state, or else of its quotient."""
        if self._model is not None and GeneratedProduct.suits(problem, self._model):
            return GeneratedProduct(problem, self._model)
        return Product(problem.over(self._quotient.system))

    def _listed_product(self) -> Product:
        """Return the tables of the problem's quotient."""
        return Product(self.problem.over(self._quotient.system))

    @cached_property
    def _model(self) -> ReducedModel | None:
        """What is searched, unless its states are listed."""
        system = self.problem.system
        if not isinstance(system, ManipulationSystem) or not self._options.generated:
            return None
        return system.reduced(self.problem.task_propositions, may_hurry=self.problem.may_hurry)

    def front(self, *, within: Number = 0, keep_on_interrupt: bool = False, **wanted: Unpack[FrontLimits]) -> Front:
        """Return the Pareto front; see `pareto_front`.

        Args:
            within: as there.
            keep_on_interrupt: return the points found so far on Ctrl-C, instead of raising KeyboardInterrupt.
            **wanted: see `FrontLimits`.
        """
        limits, tolerance = _limits(**wanted), percent(within)
        if not self.problem.is_bi_objective:
            # Nothing is left out of a front of more.
            tolerance = EXACT
        limited = bounded(self.problem, **wanted)
        require_bounds(self.problem, **limited)
        plans: list[Plan] = []
        self._begun, self._stopped, self._draft = None, None, []
        reason: Reason | None = None
        with _stopped_by(limits, interrupts=keep_on_interrupt):
            for plan in self._search(limits, tolerance=tolerance, **limited):
                plans.append(plan)
            if not plans and not limits.ended:
                reason = self._why_not(limits, **limited)
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
            stats=self.stats,
        )

    def best(self, objective: str, *, keep_on_interrupt: bool = False, **wanted: Unpack[PlanLimits]) -> Plan:
        """Return the plan of least value of one objective; see `best_plan`, and `front` for `keep_on_interrupt`."""
        names = self.problem.objective_names
        if objective not in names:
            raise PrefplanError(f"unknown objective {objective!r} {choices(objective, names)}")
        if self.problem.is_bi_objective:
            choose = self.cheapest if objective == names[0] else self.preferred
            return choose(keep_on_interrupt=keep_on_interrupt, **wanted)
        limits = _limits(**wanted)
        limited = bounded(self.problem, **wanted)
        require_bounds(self.problem, **limited)
        place, found, reason = names.index(objective), list[tuple[tuple[Any, ...], Plan]](), None
        with _stopped_by(limits, interrupts=keep_on_interrupt):
            for point in self._points(limits, objective, **limited):
                found.append(point)
            if not found and not limits.ended:
                reason = self._why_not(limits, **limited)
        if reason is not None:
            raise NoPlanError(reason)
        best = min(found, key=lambda pair: (pair[0][place], *pair[0]))[1] if found else None
        if limits.ended or best is None:
            raise UnfinishedError(limits.ended or "", best=best)
        return best

    def _proven(self, plans: Sequence[Plan]) -> Number | None:
        """Return within how many percent of these plans each best trade-off is, as far as a stopped search proves."""
        points = [(exact(plan.cost), exact(plan.preference)) for plan in plans]
        proven = []
        if self._begun is not None:
            proven.append(proven_percent(self._begun, points))
        if isinstance(self._stopped, NarrowingSearch):
            proven.append(self._stopped.proven(points))
        elif isinstance(self._stopped, Search):
            proven.append(proven_percent(self._stopped, points))
        least = min((percentage for percentage in proven if percentage is not None), default=None)
        return None if least is None else to_number(least)

    def cheapest(self, *, keep_on_interrupt: bool = False, **wanted: Unpack[PlanLimits]) -> Plan:
        """Return the plan of least total cost within a bound on mu; see `cheapest_plan`, and `front`."""
        if not self.problem.is_bi_objective:
            return self.best(self.problem.cost_names[0], keep_on_interrupt=keep_on_interrupt, **wanted)
        wanted = bounded(self.problem, **wanted)
        if wanted.get("max_preference") is not None:
            require_bounds(self.problem, **wanted)
        limits = _limits(**wanted)
        self._cheapest = None
        plan: Plan | None = None
        with _stopped_by(limits, interrupts=keep_on_interrupt):
            if self.problem.measure.contract == "general" and wanted.get("max_preference") is None:
                reason = self._infeasible(limits)
                if reason is not None:
                    raise NoPlanError(reason)
            plan = next(self._search(limits, single=True, **wanted), None)
            if plan is None and not limits.ended:
                raise NoPlanError(self._why_not(limits, **wanted))
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
        """Return the plan of least mu; see `preferred_plan`, and `front`."""
        if not self.problem.preferences:
            raise PrefplanError(f"there is no preference {choices('', self.problem.objective_names)}")
        if not self.problem.is_bi_objective:
            return self.best(self.problem.preferences[0].name, keep_on_interrupt=keep_on_interrupt, **wanted)
        wanted = bounded(self.problem, **wanted)
        max_preference = wanted.pop("max_preference", None)
        kept = ("max_cost", "max_seconds", "max_memory")
        bounds = cast(FrontLimits, {name: wanted.get(name) for name in kept})
        front = self.front(keep_on_interrupt=keep_on_interrupt, **bounds)
        if front.reason:
            raise NoPlanError(front.reason)
        best: Plan | None = front[-1] if front else None
        smallest = None if best is None else best.preference
        if best and max_preference is not None and not admits(max_preference, best.preference):
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

    def _search(
        self, limits: Limits, *, single: bool = False, tolerance: Percent = EXACT, **wanted: Unpack[PlanLimits]
    ) -> Iterator[Plan]:
        """Yield the plans of the front, or its first one only, accounting for the work as it is done."""
        if not self.problem.is_bi_objective:
            yield from (plan for _, plan in self._points(limits, None, **wanted))
            return
        _, began = self._product, time.perf_counter()
        mu, cost = wanted.get("max_preference"), wanted.get("max_cost")
        max_mu = None if mu is None else inclusive(mu, "max_preference")
        max_cost = math.inf if cost is None else math.floor(inclusive(cost, "max_cost") / self.problem.units.cost)
        yielded = -1
        for exact_numbers in (False, True):
            try:
                search = self._prepared_search(
                    max_mu, max_cost, limits, single=single, exact_numbers=exact_numbers, tolerance=tolerance
                )
                if search is None:
                    return
                self._stopped = search
                for found in search.goals(limits) if not limits.ended else ():
                    self._account(search, began)
                    if found.cost > yielded or tolerance.value:
                        yielded = found.cost
                        yield self._checked(found, search.product)
                        if single:
                            return
                self._account(search, began)
                return
            except OverflowError:
                if exact_numbers:
                    raise
                # What 64 bits may not hold is searched again in Python's integers.
                limits.ended = None

    def _draft_front(self, limits: Limits, max_cost: float) -> list[Found]:
        """Return plans that are close to the front, to have some soon, unless it is found soon itself."""
        drafted = []
        if len(self.problem.tasks) >= DRAFTED_TASKS:
            light = prepare_draft(self._product, self._options, limits.bytes)
            self._begun = begun(light)
            for found in draft(light, max_cost):
                drafted.append(found)
                self._draft.append(self._checked(found, self._product))
        return drafted

    def _points(
        self, limits: Limits, first: str | None, **wanted: Unpack[PlanLimits]
    ) -> Iterator[tuple[tuple[Any, ...], Plan]]:
        """Yield points of the front of several costs and preferences, each with its plan; see `objective_search`."""
        product, began = self._product, time.perf_counter()
        bounds = {name: inclusive(bound, name) for name, bound in (wanted.get("at_most") or {}).items()}
        for search, found in points(product, self._listed_product, self._options, bounds, limits, first):
            self._account(search, began)
            if found is not None:
                worth = tuple(map(to_number, found.objectives or ()))
                assert tuple(found.plan.objectives.values()) == worth, "the plan is worth something else in the model"
                yield found.objectives or (), self._lifted(found.plan, search.product)

    def _prepared_search(
        self,
        max_mu: Fraction | None,
        max_cost: float,
        limits: Limits,
        *,
        single: bool,
        exact_numbers: bool,
        tolerance: Percent,
    ) -> AnySearch | None:
        """Return the search that fits the measure; None if memory does not suffice for it.

        Raises:
            OverflowError: 64 bits may not hold its numbers.
        """
        measure, options = self.problem.measure, self._options
        if exact_numbers or measure.rounds or not options.compiled:
            listed = self._listed_product()
            most = None if max_cost == math.inf else int(max_cost) * self.problem.units.cost
            bounds = zip(self.problem.objective_names, (most, max_mu), strict=True)
            return ExactSearch(listed, bounds={name: bound for name, bound in bounds if bound is not None})
        if bytes_to_prepare(self._product) > limits.bytes:
            limits.ended = "memory"
            return None
        if single and max_mu is None and measure.bi_objective:
            self._cheapest = CheapestSearch(self._product, options, limits, max_cost)
            return self._cheapest.search()
        drafted = self._draft_front(limits, max_cost) if measure.bi_objective else []
        prepared = Prepared(self._product, options, single=single, max_bytes=limits.bytes)
        if not measure.bi_objective:
            return VectorSearch(prepared, max_mu=max_mu, max_cost=max_cost, tolerance=tolerance)
        if tolerance.value and max_mu is None:
            return NarrowingSearch(prepared, tolerance, max_cost=max_cost, drafted=drafted)
        return BiObjectiveSearch(prepared, max_mu=max_mu, max_cost=max_cost, first_only=single, drafted=drafted)

    def _checked(self, found: Found, searched: Product) -> Plan:
        """Return the plan of a goal, which is asserted to be worth in the model what the search counted."""
        plan = self._lifted(found.plan, searched)
        assert plan.cost == to_number(found.cost * self.problem.units.cost)
        counted, paid = found.label_mu, in_units(self._product, found.mu)
        # A label that is not the best of its kind may have paid for a rule that its plan keeps.
        may_overpay = len(self.problem.priced) > len(self.problem.tasks)
        assert counted is None or counted == paid or (counted > paid and may_overpay)
        return plan

    def _lifted(self, found: Plan, searched: Product) -> Plan:
        """Return the plan of the model for one of what was searched, which is asserted to be worth the same there."""
        plan = found
        if not isinstance(searched, GeneratedProduct):
            actions, states = self._quotient.lift((plan.actions, plan.states))
            plan = replace(plan, actions=actions, states=states)
        if plan.states is not found.states or isinstance(searched, GeneratedProduct):
            ledger = Ledger.of_plan(self.problem, plan)
            worth = (*ledger.exact_objectives(), *ledger.final.task_costs.values())
            found_worth = (*plan.objectives.values(), *plan.task_costs.values())
            assert all(map(math.isclose, worth, found_worth)), "the plan is worth something else in the whole model"
        return plan

    def _account(self, search: AnySearch, began: float) -> None:
        seconds = time.perf_counter() - began
        self.stats = replace(search.work, build_seconds=self._build_seconds, seconds=seconds)

    def _why_not(self, limits: Limits, **wanted: Unpack[PlanLimits]) -> Reason:
        """Return why a search found nothing; what else was possible is looked for within what its limits leave."""
        reason = self._infeasible(limits)
        if reason is not None:
            return reason
        if not self.problem.is_bi_objective:
            return self._out_of_bounds(limits, wanted.get("at_most") or {})
        if wanted.get("max_preference") is None:
            assert wanted.get("max_cost") is not None
            try:
                cheapest = self.cheapest(max_seconds=limits.seconds_left, max_memory=limits.bytes)
            except UnfinishedError:
                return Reason("bound")
            return Reason("bound", smallest=cheapest.cost)
        front = self.front(max_cost=wanted.get("max_cost"), max_seconds=limits.seconds_left, max_memory=limits.bytes)
        return Reason("bound", smallest=front[-1].preference if front and front.complete else None)

    def _out_of_bounds(self, limits: Limits, bounds: Mapping[str, Number]) -> Reason:
        """Return that bounds leave no plan, and of a single one what it would have to be at least."""
        smallest = None
        if len(bounds) == 1:
            [name] = bounds
            with suppress(UnfinishedError, PreferenceError):
                best = self.best(name, max_seconds=limits.seconds_left, max_memory=limits.bytes)
                smallest = best.objectives[name]
        return Reason("bound", smallest=smallest)

    def _infeasible(self, limits: Limits) -> Reason | None:
        """Return which tasks cannot be satisfied together, or None if all of them can."""
        problem = self.problem
        if self._is_satisfiable(problem.tasks, limits):
            return None
        if problem.rules and self._is_satisfiable(problem.tasks, limits, ()):
            laws = (rules for size in range(1, len(problem.rules) + 1) for rules in combinations(problem.rules, size))
            broken = next(rules for rules in laws if not self._is_satisfiable(problem.tasks, limits, rules))
            return Reason("rule", tuple(rule.name for rule in broken))
        sizes = range(1, len(problem.tasks) + 1)
        sets = (tasks for size in sizes for tasks in combinations(problem.tasks, size))
        blame = tuple(task.name for task in next(t for t in sets if not self._is_satisfiable(t, limits, ())))
        return Reason("task" if len(blame) == 1 else "conflict", blame)

    def _is_satisfiable(self, tasks: tuple[Task, ...], limits: Limits, rules: tuple[Rule, ...] | None = None) -> bool:
        """Return whether some plan satisfies some of the tasks, as relaxed as they may be, and keeps rules.

        Without `rules`, all of the problem's are kept.

        Raises:
            LimitError: a limit was reached before that is known.
        """
        nothing = WeightedSum({task.name: 0 for task in tasks}, over="violation")
        free = tuple(
            replace(task, relax=tuple(replace(r, cost=0) for r in task.relax), skip=None if task.skip is None else 0)
            for task in tasks
        )
        kept = tuple(rule for rule in (self.problem.rules if rules is None else rules) if rule.skip is None)
        if isinstance(self._product, GeneratedProduct):
            product = self._product_of(Problem(self.problem.system, free, nothing, rules=kept))
        else:
            # What anything costs does not matter.
            system = self._quotient.system
            system = replace(system, costs=np.zeros(len(system.costs), dtype=np.int64), more_costs=())
            product = Product(Problem(system, free, nothing, rules=kept))
        search = BiObjectiveSearch(Prepared(product, Options(heuristic=1), single=True), cost_only=True)
        left = replace(limits, complete_below=0)
        found = next(search.goals(left), None) is not None
        if left.ended:
            raise LimitError(left.ended)
        return found


@contextmanager
def _stopped_by(limits: Limits, *, interrupts: bool) -> Iterator[None]:
    """Work within limits: what stops it is noted in them, and so is Ctrl-C if wanted."""
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
    """Return the plans that no other is as good as in cost and mu, in order of cost; of equal ones the first."""
    kept: list[Plan] = []
    for plan in sorted(plans, key=lambda plan: (plan.cost, plan.preference)):
        if not kept or plan.preference < kept[-1].preference:
            kept.append(plan)
    return kept


def _limits(
    *,
    max_seconds: float | None = None,
    max_memory: float | None = None,
    max_cost: Number | None = None,
    max_preference: Number | None = None,
    at_most: Mapping[str, Number] | None = None,
) -> Limits:
    """Return the limits of time and memory; the search itself keeps the bounds of cost and mu."""
    memory = MEMORY_SHARE * available_memory() if max_memory is None else max_memory
    return Limits(math.inf if max_seconds is None else max_seconds, memory)
