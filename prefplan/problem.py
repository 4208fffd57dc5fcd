"""A planning problem: a robot's transition system, its tasks and rules, and preferences."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property

from prefplan.errors import PrefplanError, prefixed
from prefplan.exact_costs import common_unit, exact, to_number
from prefplan.logic.tasks import Rule, Task, checked_automata, named_formulas
from prefplan.logic.weighted_dfa import WeightedAutomaton
from prefplan.models.feasibility import Feasible
from prefplan.models.manipulation.system import ManipulationSystem
from prefplan.models.system import Past, System
from prefplan.models.transition_system import SystemLike, system_of
from prefplan.preferences.contracts import check_contract, check_never_falls
from prefplan.preferences.kinds import Preference, WeightedSum
from prefplan.preferences.objective import (
    TASK_LIMIT,
    Measure,
    NamedPreference,
    check_objective_names,
    preferences_of,
)
from prefplan.preferences.terms import checked_terms
from prefplan.text.layout import number
from prefplan.text.names import labels_of

UNWEIGHED = 'no term of the preference depends on this price; add a term with over = "violation"'

LARGEST_TRIED = 10**15
"""Largest cost, in units, for which a declared contract is tested."""


@dataclass(init=False)
class Problem:
    """The paper's Problem 1: minimise total cost and mu while satisfying all tasks.

    The search follows one automaton for each task and each rule.

    Attributes:
        system: the robot's model (Definition 1).
        tasks: phi_1 .. phi_N.
        preference: mu (Definition 5), the first of several; always 0 if there is none.
        rules: safety formulas that every plan keeps, or breaks at a price.
        past: the actions with which every plan begins, before the system's start; only their first cost is known.
        feasible: what the arm can do; plans need no more. None for abstract plans.
        abstract: whether plans may need what no arm can do.
        preferences: all preferences, with their names.
        automata: the tasks' minimal DFAs (Definition 6).
        monitors: DFAs of the rules' bad prefixes.
        display: the labels that are shown in place of names.
        assumptions: a sentence for every assumption under which a front is exact.
        resolution: the model's costs were rounded to multiples of this, in the user's units; None if they were not.
        names: the tasks' names.
        priced: the names of all that have violation costs: the tasks, then the rules that may be broken.
        cost_names: the names of the costs.
        objective_names: the names of what is minimised: every cost, then every preference.
        cost_units: for each cost, the unit in which it is whole, in the user's units.
        objectives: the preferences, bound to these tasks.
        measure: the first of `objectives`; always 0 if there is none.
        is_bi_objective: whether there is one cost and one preference.
        is_general: whether some preference has a general contract, so that a detour may lower mu.
        weighted_automata: the automata of the tasks, with relaxations.
        followers: the `weighted_automata`, then those of the rules, first of the rules that may be broken.

    Raises:
        PrefplanError: (on construction) for no tasks, clashing names, formulas that do not fit the system, or a
            preference that does not fit the tasks. The message starts with the key as in a scenario file.
    """

    system: System
    tasks: tuple[Task, ...]
    preference: Preference
    rules: tuple[Rule, ...]
    past: Past
    preferences: tuple[NamedPreference, ...] = field(repr=False)
    feasible: Feasible | None = field(repr=False)
    abstract: bool

    def __init__(
        self,
        system: SystemLike,
        tasks: Mapping[str, str] | Iterable[Task],
        preference: Preference | Sequence[NamedPreference] = (),
        *,
        start: Hashable | None = None,
        rules: Mapping[str, str] | Iterable[Rule] = (),
        past: Past | None = None,
        feasible: Feasible | None = None,
    ) -> None:
        """Check that the parts fit together.

        Arguments are the attributes; the system may be a model, or a networkx graph with its initial node as `start`,
        and tasks and rules may be formulas by name, such as `{"stock": "F shelf"}`.
        """
        self.preferences = named = preferences_of(preference)
        self.system = system = system_of(system, start=start)
        self.past, propositions = past or Past(), system.propositions
        self.feasible, self.abstract = feasible, feasible is None
        if feasible is not None and not isinstance(system, ManipulationSystem):
            raise PrefplanError("feasible: only plans of a manipulation model can be asked for")
        self.preference = named[0].preference if named else WeightedSum({})
        self.resolution = None if system.resolution is None else to_number(system.resolution)
        self.tasks = tuple(replace(task, propositions=propositions) for task in named_formulas(Task, tasks, "tasks"))
        self.rules = tuple(replace(rule, propositions=propositions) for rule in named_formulas(Rule, rules, "rules"))
        if not self.tasks:
            raise PrefplanError("tasks: a problem needs at least one task")
        if len(self.tasks) > TASK_LIMIT:
            raise PrefplanError(f"tasks: {len(self.tasks)} are more than the {TASK_LIMIT} that the search can take")
        self.names = tuple(task.name for task in self.tasks)
        self.automata = checked_automata(self.tasks, "tasks")
        self.monitors = checked_automata(self.rules, "rules", self.names)
        labels = labels_of("task", [(f"tasks[{i}]", task.name, task.label) for i, task in enumerate(self.tasks)])
        self.display = replace(system.display, tasks=labels)
        self.priced = (*self.names, *(rule.name for rule in self.rules if rule.skip is not None))
        self.cost_names = system.cost_names
        check_objective_names(named, self.cost_names)
        self.objective_names = (*self.cost_names, *(one.name for one in named))
        self.is_bi_objective = len(self.cost_names) == len(named) == 1
        self._bind_preferences()
        self._weigh_automata()
        self._check_claims()
        self._check_weighed()
        self.assumptions = self._assumed()

    def _bind_preferences(self) -> None:
        """Set the terms of all preferences, and the units."""
        prices = [exact(relaxation.cost) for task in self.tasks for relaxation in task.relax]
        skips = [*(task.skip for task in self.tasks), *(rule.skip for rule in self.rules)]
        prices += [exact(skip) for skip in skips if skip is not None]
        price, units = common_unit(prices), [table.unit for table in self.system.costs]
        if self.past.costs:
            units[0] = common_unit([units[0], *map(exact, self.past.costs)])
        rules, objectives = self.priced[len(self.tasks) :], list[Measure]()
        counts = len(self.tasks), len(rules)
        for named in self.preferences:
            with prefixed(f"{named.key}."):
                terms = checked_terms(named.preference.terms(self.names, *([rules] if rules else [])), sum(counts))
            cost = 0 if named.of is None else self.cost_names.index(named.of)
            objectives.append(Measure(terms, *counts, units[cost], price, name=named.name, cost=cost))
        self.cost_units, self.objectives = tuple(units), tuple(objectives)
        self.measure = objectives[0] if objectives else Measure((), *counts, units[0], price)
        self.is_general = any(objective.contract == "general" for objective in objectives)

    def _weigh_automata(self) -> None:
        """Set the automata of the tasks with relaxations, and of the rules, first of those that may be broken."""
        price, automata, priced, kept = self.measure.price_unit, [], [], []
        for task, dfa in zip(self.tasks, self.automata, strict=True):
            relaxations = tuple((r.assume, r.condition, int(exact(r.cost) / price)) for r in task.relax)
            skip = None if task.skip is None else int(exact(task.skip) / price)
            automata.append(WeightedAutomaton(dfa, relaxations, skip))
        for rule, dfa in zip(self.rules, self.monitors, strict=True):
            if rule.skip is None:
                kept.append(WeightedAutomaton(dfa, price=None))
            else:
                priced.append(WeightedAutomaton(dfa, price=int(exact(rule.skip) / price)))
        self.weighted_automata = tuple(automata)
        self.followers: tuple[WeightedAutomaton, ...] = (*automata, *priced, *kept)

    def _check_weighed(self) -> None:
        """Check that some preference depends on violation costs, if there may be any."""
        if any(objective.weighs_violation for objective in self.objectives):
            return
        for i, task in enumerate(self.tasks):
            if task.relax or task.skip is not None:
                raise PrefplanError(f"tasks[{i}].{'relax' if task.relax else 'skip'}: {UNWEIGHED}")
        for i, rule in enumerate(self.rules):
            if rule.skip is not None:
                raise PrefplanError(f"rules[{i}].skip: {UNWEIGHED}")

    def _check_claims(self) -> None:
        """Test contracts that the user declared on costs of the sizes that occur."""
        costs = self.system.costs
        for named, objective in zip(self.preferences, self.objectives, strict=True):
            for formula in objective.formulas:
                if formula.claimed:
                    # The greatest cost of a plan that visits no state twice.
                    largest, unit = costs[objective.cost].greatest * self.system.most_states, objective.cost_unit
                    span = unit, min(largest * len(self.tasks), unit * LARGEST_TRIED)
                    check_never_falls(formula, self.priced, named.key, span)
                    check_contract(formula, self.priced, named.key, span)

    def broken(self, labels: Sequence[frozenset[str]]) -> dict[str, int]:
        """Return, by name, after how many actions a trace breaks each rule that it breaks."""
        broken = {rule.name: dfa.first_accepted(labels) for rule, dfa in zip(self.rules, self.monitors, strict=True)}
        return {name: step for name, step in broken.items() if step is not None}

    @property
    def hard_rules(self) -> tuple[Rule, ...]:
        """The rules that may not be broken."""
        return tuple(rule for rule in self.rules if rule.skip is None)

    @cached_property
    def task_propositions(self) -> frozenset[str]:
        """The propositions on which the tasks, their relaxations and the rules depend."""
        return frozenset[str]().union(*(dfa.propositions for dfa in self.followers))

    @cached_property
    def stutter_invariant(self) -> bool:
        """Whether leaving out an action that changes no proposition of the tasks never makes a plan worse.

        That is so if no formula counts steps, no task can be relaxed, and no preference has a general contract.
        """
        if self.is_general or any(task.relax for task in self.tasks):
            return False
        return all(dfa.stutter_invariant for dfa in (*self.automata, *self.monitors))

    def over(self, system: System, tasks: Sequence[int] | None = None) -> Problem:
        """Return the problem over another system with the same propositions for the tasks, in the same units.

        If some tasks are given by number, only these are kept, without rules; the preference remains the same.
        """
        problem = copy(self)
        problem.system = system
        if tasks is not None:
            problem.tasks, problem.names = tuple(self.tasks[i] for i in tasks), tuple(self.names[i] for i in tasks)
            problem.automata = tuple(self.automata[i] for i in tasks)
            problem.weighted_automata = tuple(self.weighted_automata[i] for i in tasks)
            problem.followers = problem.weighted_automata
        return problem

    def _assumed(self) -> tuple[str, ...]:
        """Return a sentence for every assumption under which a front is exact."""
        notes = [self.system.left_out] if self.system.left_out else []
        if self.resolution is not None:
            notes.append(f"Costs are rounded to multiples of {number(self.resolution)}; the front is exact for those.")
        for objective in self.objectives:
            if objective.claimed:
                called = "the preference" if self.is_bi_objective else objective.name
                claim = f"That {called} is {objective.contract} is a claim of the scenario"
                notes.append(f"{claim}, tested on random costs only.")
        return tuple(notes)
