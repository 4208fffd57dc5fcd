"""A planning problem: a robot's transition system, its tasks, and how they would best be done."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from prefplan.automaton import Automaton, automaton
from prefplan.errors import FormulaError, PrefplanError
from prefplan.formula import parse
from prefplan.preference import Measure, Preference
from prefplan.transition_system import TransitionSystem, check_names


@dataclass(frozen=True)
class Task:
    """A temporal task: a name and a co-safe formula (Definition 2)."""

    name: str
    formula: str


@dataclass(frozen=True, init=False)
class Problem:
    """The paper's Problem 1: minimise total cost and mu while satisfying all tasks.

    Attributes:
        system: the robot's model (Definition 1).
        tasks: phi_1 .. phi_N.
        preference: mu (Definition 5).

    Raises:
        PrefplanError: (on construction) for no tasks, clashing names, formulas that do not fit the system, or a
            preference that does not fit the tasks. The message starts with the key as in a scenario file.
    """

    system: TransitionSystem
    tasks: tuple[Task, ...]
    preference: Preference

    def __init__(self, system: TransitionSystem, tasks: Iterable[Task], preference: Preference) -> None:
        """Check that the parts fit together."""
        object.__setattr__(self, "system", system)
        object.__setattr__(self, "tasks", tuple(tasks))
        object.__setattr__(self, "preference", preference)
        if not self.tasks:
            raise PrefplanError("tasks: a problem needs at least one task")
        check_names(self.names, what="task")
        for i, task in enumerate(self.tasks):
            if task.name in ("min", "max", "abs"):
                raise PrefplanError(f"tasks[{i}].name: {task.name!r} is a reserved word (min max abs)")
            if task.name in self.names[:i]:
                raise PrefplanError(f"tasks[{i}].name: {task.name!r} is used twice")
            try:
                parse(task.formula, propositions=system.propositions)
            except FormulaError as error:
                raise FormulaError(f"tasks[{i}].formula: {error}") from None
        try:
            preference.check(self.names)
        except PrefplanError as error:
            raise type(error)(f"preference.{error}") from None

    @property
    def names(self) -> tuple[str, ...]:
        """The tasks' names."""
        return tuple(task.name for task in self.tasks)

    @cached_property
    def automata(self) -> tuple[Automaton, ...]:
        """The tasks' minimal DFAs (Definition 6)."""
        return tuple(automaton(task.formula) for task in self.tasks)

    @cached_property
    def decimals(self) -> int:
        """Exponent of the quantum in which all costs of this problem are integers."""
        return max(self.system.decimals, self.preference.cost_decimals)

    @cached_property
    def measure(self) -> Measure:
        """The preference function over costs in quanta."""
        return self.preference.bind(self.names, self.decimals)
