"""The ledger of a plan or run: the cost and violation cost of each task, and the preference, after every action.

Plans, runs, the viewer, captions and the report all take their numbers from here. Only the certificate of a run
(`sim.evidence`) computes them by itself, to check these.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import accumulate
from typing import Any

from prefplan.exact_costs import Number, exact, to_number
from prefplan.logic.good_prefix import Label
from prefplan.plan import Plan, Purchase
from prefplan.problem import Problem
from prefplan.scenario.decode import ProblemLike, problem_of


@dataclass(frozen=True)
class Entry:
    """The costs after some actions, in the user's units.

    Attributes:
        cost: total cost so far (equation 1).
        task_costs: c_i by task name (equation 2); for a task that is not satisfied, the total cost so far.
        violation_costs: v_i, the price so far, by name of each task and each rule that may be broken.
        satisfied: names of the tasks that are satisfied.
        preference: mu of these costs (Definition 5), the first of several; it never falls from one entry to the next.
    """

    cost: Number
    task_costs: dict[str, Number]
    violation_costs: dict[str, Number]
    satisfied: frozenset[str]
    preference: Number


@dataclass(frozen=True)
class Ledger:
    """The costs and preferences of K actions, for a problem's tasks.

    Attributes:
        problem: the tasks and the preference.
        actions: (K,) in order.
        costs: (K,) first cost of each action, in the user's units.
        labels: (K + 1,) the propositions that hold at the start and after each action.
        states: by task name, (K + 1,) states of its automaton, one after each label; None for a skipped task.
        relaxations: the relaxations used.
        more_costs: the further costs of the actions, (K,) each, by name.
    """

    problem: Problem = field(repr=False)
    actions: tuple[str, ...]
    costs: tuple[Fraction, ...]
    labels: tuple[Label, ...] = field(repr=False)
    states: Mapping[str, tuple[int, ...] | None] = field(repr=False)
    relaxations: tuple[Purchase, ...] = ()
    more_costs: Mapping[str, tuple[Fraction, ...]] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        problem: Problem,
        actions: Sequence[str],
        costs: Sequence[Number],
        labels: Sequence[Label],
        relaxations: Sequence[Purchase] = (),
        more_costs: Mapping[str, tuple[Fraction, ...]] | None = None,
    ) -> Ledger:
        """Return the ledger of some actions; each task's automaton reads the labels with its relaxations.

        Arguments are the attributes.
        """
        states: dict[str, tuple[int, ...] | None] = {}
        for task, automaton in zip(problem.tasks, problem.automata, strict=True):
            purchases = [purchase for purchase in relaxations if purchase.task == task.name]
            if any(purchase.assume is None for purchase in purchases):
                states[task.name] = None
                continue
            read = list(labels)
            for purchase in purchases:
                if purchase.assume is not None and purchase.step < len(read):
                    read[purchase.step] |= {purchase.assume}
            states[task.name] = automaton.run(read)
        return cls(
            problem,
            tuple(actions),
            tuple(map(exact, costs)),
            tuple(labels),
            states,
            tuple(relaxations),
            more_costs or {},
        )

    @classmethod
    def of_plan(cls, problem: ProblemLike, plan: Plan) -> Ledger:
        """Return the ledger of a plan's actions, with labels and costs of the problem's transition system.

        Raises:
            ModelError: an action is not applicable in its state.
        """
        problem = problem_of(problem)
        _, _, labels, costs = problem.past.along(problem.system, plan.actions)
        more = dict(zip(problem.cost_names[1:], costs[1:], strict=True))
        return cls.of(problem, plan.actions, costs[0], labels, plan.relaxations, more)

    @cached_property
    def spent(self) -> tuple[Fraction, ...]:
        """(K + 1,) total cost before the first action and after each."""
        return self._totals[0]

    @cached_property
    def _totals(self) -> list[tuple[Fraction, ...]]:
        """(K + 1,) for each cost, the total before the first action and after each."""
        return [tuple(accumulate(each, initial=Fraction(0))) for each in (self.costs, *self.more_costs.values())]

    @cached_property
    def satisfied(self) -> dict[str, int | None]:
        """After how many actions each task is satisfied, by name; None if it is not."""
        steps: dict[str, int | None] = {}
        for (name, states), dfa in zip(self.states.items(), self.problem.automata, strict=True):
            steps[name] = states.index(dfa.accepting) if states and dfa.accepting in states else None
        return steps

    @property
    def order(self) -> tuple[str, ...]:
        """The satisfied tasks in the order in which they are satisfied; ties in the problem's order."""
        done = {name: step for name, step in self.satisfied.items() if step is not None}
        return tuple(sorted(done, key=done.__getitem__))

    @property
    def entries(self) -> tuple[Entry, ...]:
        """(K + 1,) the costs before the first action and after each."""
        return tuple(self.entry(k) for k in range(len(self.costs) + 1))

    @property
    def final(self) -> Entry:
        """The costs after the last action."""
        return self.entry(len(self.costs))

    def entry(self, step: int) -> Entry:
        """Return the costs after a number of actions, 0 <= step <= K."""
        costs, violations = self._costs(step)
        first = self.problem.objectives[0].cost if self.problem.objectives else 0
        names = self.problem.names
        return Entry(
            cost=to_number(self.spent[step]),
            task_costs=dict(zip(names, map(to_number, costs), strict=False)),
            violation_costs=dict(zip(self.problem.priced, map(to_number, violations), strict=True)),
            satisfied=frozenset(name for name, at in self.satisfied.items() if at is not None and at <= step),
            preference=to_number(self.problem.measure.value(*self._costs(step, first))),
        )

    def exact_objectives(self) -> tuple[Any, ...]:
        """Return every total cost and every mu of all the actions; a mu is a float where a function is used."""
        last = len(self.costs)
        values = [o.value(*self._costs(last, o.cost)) for o in self.problem.objectives]
        return (*(total[last] for total in self._totals), *values)

    def advances(self, task: str) -> tuple[int, ...]:
        """Return the numbers, from 1, of the actions after which a task's automaton changes its state."""
        states = self.states[task] or ()
        return tuple(k for k in range(1, len(states)) if states[k] != states[k - 1])

    def task_costs(self, cost: int = 0) -> dict[str, Number]:
        """Return each task's cost after all actions, measured in the cost with this index."""
        return dict(zip(self.problem.names, map(to_number, self._costs(len(self.costs), cost)[0]), strict=False))

    def _costs(self, step: int, cost: int = 0) -> tuple[list[Fraction], list[Fraction]]:
        """Return costs, in the cost with this index, and violation costs of all `priced` after a number of actions."""
        done = [step if at is None else min(at, step) for at in self.satisfied.values()]
        done += [0] * (len(self.problem.priced) - len(done))
        violations = dict.fromkeys(self.problem.priced, Fraction(0))
        for purchase in self.relaxations:
            if purchase.step <= step:
                violations[purchase.task] += exact(purchase.cost)
        return [self._totals[cost][k] for k in done], list(violations.values())
