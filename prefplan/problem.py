"""A planning problem: a robot's transition system, its tasks, and how they would best be done."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

from prefplan.automaton import Automaton, automaton
from prefplan.errors import FormulaError, PrefplanError, choices
from prefplan.formula import is_temporal, parse
from prefplan.measure import TASK_LIMIT, Measure
from prefplan.preference import Preference
from prefplan.quanta import Number, decimals_of, exact, fraction_decimals, to_quanta
from prefplan.transition_system import TransitionSystem, check_names
from prefplan.weighted_automaton import WeightedAutomaton


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
        present: a proposition; a plan that drops tasks does not end before it holds. None for no such thing.
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

    @property
    def names(self) -> tuple[str, ...]:
        """The tasks' names."""
        return tuple(task.name for task in self.tasks)

    @cached_property
    def decimals(self) -> int:
        """Exponent of the quantum in which all costs of this problem are integers."""
        prices = [relaxation.cost for task in self.tasks for relaxation in task.relax]
        prices += [task.skip for task in self.tasks if task.skip is not None]
        places = [fraction_decimals(term.by) for term in self.measure.tardiness]
        return max(self.system.decimals, decimals_of(prices), *places, 0)

    @cached_property
    def weighted_automata(self) -> tuple[WeightedAutomaton, ...]:
        """The tasks' automata with their relaxations."""
        found = []
        for task, dfa in zip(self.tasks, self.automata, strict=True):
            prices, _ = to_quanta([relaxation.cost for relaxation in task.relax], self.decimals)
            bought = tuple((r.assume, parse(r.when), price) for r, price in zip(task.relax, prices, strict=True))
            skip = None if task.skip is None else to_quanta([task.skip], self.decimals)[0][0]
            found.append(WeightedAutomaton(dfa, bought, skip, self.present))
        return tuple(found)
