"""A planning problem: a robot's transition system, its tasks, and how they would best be done."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from prefplan.errors import FormulaError, PrefplanError, choices
from prefplan.exact_costs import Number, Units, common_unit, exact, to_number
from prefplan.logic.dfa import Automaton, automaton
from prefplan.logic.formula import is_temporal, parse, propositions_of
from prefplan.logic.weighted_dfa import WeightedAutomaton
from prefplan.models.transition_system import TransitionSystem, check_names
from prefplan.preferences.contracts import Span, check_claim
from prefplan.preferences.kinds import Preference
from prefplan.preferences.objective import TASK_LIMIT, Measure

LARGEST_TRIED = 10**15
"""Units of cost up to which a declared contract is tried, where plans may cost as much."""


@dataclass(frozen=True)
class Relaxation:
    """A reading that may be bought: `assume` counts as true wherever `when` holds and it is false, for `cost`.

    Attributes:
        assume: a proposition.
        when: a formula without temporal operators.
        cost: price of each such reading; it counts towards the task's violation cost, not the total cost.
    """

    assume: str
    when: str
    cost: Number


@dataclass(frozen=True)
class Task:
    """A temporal task: a co-safe formula (Definition 2), and how it may be relaxed (Remarks 1 to 6).

    Attributes:
        name: what costs and preferences call it.
        formula: the task.
        relax: readings that may be bought.
        skip: price of dropping the task before the first action; None if it may not be dropped.
    """

    name: str
    formula: str
    relax: tuple[Relaxation, ...] = ()
    skip: Number | None = None


@dataclass(frozen=True, init=False)
class Problem:
    """The paper's Problem 1: minimise total cost and mu while satisfying all tasks.

    Attributes:
        system: the robot's model (Definition 1).
        tasks: phi_1 .. phi_N.
        preference: mu (Definition 5).
        present: a proposition; a plan that drops tasks does not end before it holds. None if they may end at once.
        measure: the preference's terms for these tasks.
        automata: the tasks' minimal DFAs (Definition 6).

    Raises:
        PrefplanError: (on construction) for no tasks, clashing names, formulas that do not fit the system, or a
            preference that does not fit the tasks. The message starts with the key as in a scenario file.
    """

    system: TransitionSystem
    tasks: tuple[Task, ...]
    preference: Preference
    present: str | None
    measure: Measure = field(repr=False, compare=False)
    automata: tuple[Automaton, ...] = field(repr=False, compare=False)

    def __init__(
        self, system: TransitionSystem, tasks: Iterable[Task], preference: Preference, *, present: str | None = None
    ) -> None:
        """Check that the parts fit together."""
        object.__setattr__(self, "system", system)
        object.__setattr__(self, "tasks", tuple(tasks))
        object.__setattr__(self, "preference", preference)
        object.__setattr__(self, "present", present)
        if not self.tasks:
            raise PrefplanError("tasks: a problem needs at least one task")
        if len(self.tasks) > TASK_LIMIT:
            raise PrefplanError(f"tasks: {len(self.tasks)} are more than the {TASK_LIMIT} that the search can take")
        automata: list[Automaton] = []
        for i, task in enumerate(self.tasks):
            check_names([task.name], where=f"tasks[{i}].name")
            if task.name in ("min", "max", "abs"):
                raise PrefplanError(f"tasks[{i}].name: {task.name!r} is a reserved word (min max abs)")
            if task.name in self.names[:i]:
                raise PrefplanError(f"tasks[{i}].name: {task.name!r} is used twice")
            try:
                parse(task.formula, propositions=system.propositions)
                automata.append(automaton(task.formula))
            except FormulaError as error:
                raise FormulaError(f"tasks[{i}].formula: {error}") from None
            self._check_relaxations(i, task)
        object.__setattr__(self, "automata", tuple(automata))
        try:
            measure = Measure.of(preference.terms(self.names), len(self.tasks))
        except PrefplanError as error:
            raise type(error)(f"preference.{error}") from None
        object.__setattr__(self, "measure", measure)
        self._check_claims()
        if not self.measure.weighs_violation:
            for i, task in enumerate(self.tasks):
                if task.relax or task.skip is not None:
                    key = "relax" if task.relax else "skip"
                    raise PrefplanError(
                        f"tasks[{i}].{key}: nothing in the preference weighs what it costs; "
                        'give a term of the preference over = "violation"'
                    )

    def _check_relaxations(self, i: int, task: Task) -> None:
        for k, relaxation in enumerate(task.relax):
            where = f"tasks[{i}].relax[{k}]"
            known = sorted(self.system.propositions)
            if relaxation.assume not in self.system.propositions:
                wrong = relaxation.assume
                raise PrefplanError(f"{where}.assume: unknown proposition {wrong!r} {choices(wrong, known)}")
            try:
                condition = parse(relaxation.when, propositions=known)
            except FormulaError as error:
                raise FormulaError(f"{where}.when: {error}") from None
            if is_temporal(condition):
                raise FormulaError(f"{where}.when: '{relaxation.when}' has a temporal operator")
            if exact(relaxation.cost, f"{where}.cost") < 0:
                raise PrefplanError(f"{where}.cost: negative cost {relaxation.cost}")
        if task.skip is not None and exact(task.skip, f"tasks[{i}].skip") < 0:
            raise PrefplanError(f"tasks[{i}].skip: negative cost {task.skip}")

    def _check_claims(self) -> None:
        """Try contracts that the user declared on costs of the sizes that occur."""
        largest = self.system.unit * int(max(self.system.costs.tolist(), default=0)) * self.system.size
        units = self.units
        for formula in self.measure.formulas:
            if formula.claimed:
                span = Span(units.cost, min(largest * len(self.tasks), units.cost * LARGEST_TRIED))
                check_claim(formula, self.names, "preference", span)

    @property
    def names(self) -> tuple[str, ...]:
        """The tasks' names."""
        return tuple(task.name for task in self.tasks)

    @cached_property
    def task_propositions(self) -> frozenset[str]:
        """The propositions on which the tasks and their relaxations depend."""
        found = frozenset(name for dfa in self.automata for name in dfa.propositions)
        for relaxation in (relaxation for task in self.tasks for relaxation in task.relax):
            found |= {relaxation.assume} | propositions_of(parse(relaxation.when))
        return found

    @property
    def resolution(self) -> Number | None:
        """Of what the model's costs were rounded to a multiple, in the user's units; None if they were not."""
        return None if self.system.resolution is None else to_number(self.system.resolution)

    @cached_property
    def units(self) -> Units:
        """Units in which all that the search adds up is whole."""
        shared = int(np.gcd.reduce(self.system.costs)) if len(self.system.costs) else 0
        cost = self.system.unit * (shared or 1)
        prices = [exact(relaxation.cost) for task in self.tasks for relaxation in task.relax]
        prices += [exact(task.skip) for task in self.tasks if task.skip is not None]
        price = common_unit(prices)
        return Units(cost, price, self.measure.unit(cost, price))

    @cached_property
    def weighted_automata(self) -> tuple[WeightedAutomaton, ...]:
        """The tasks' automata with their relaxations."""

        def count(price: Number) -> int:
            return int(exact(price) / self.units.price)

        found = []
        for task, dfa in zip(self.tasks, self.automata, strict=True):
            bought = tuple((r.assume, parse(r.when), count(r.cost)) for r in task.relax)
            skip = None if task.skip is None else count(task.skip)
            found.append(WeightedAutomaton(dfa, bought, skip, self.present))
        return tuple(found)
