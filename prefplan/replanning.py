"""Replanning during an execution: every plan begins with the actions and observations so far.

The past is a chain of states in front of the model, each with its observed label, connected by the actions taken, with
their costs. Every plan begins with the whole chain, so the planner optimises the (cost, mu) of past and future
together. Relaxations of past labels are chosen anew, since none has been paid for yet.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, reduce

import numpy as np

from prefplan.errors import ModelError
from prefplan.exact_costs import Number, common_unit, exact, multiples, to_number, whole_numbers
from prefplan.front import NoPlanError
from prefplan.ledger import Ledger
from prefplan.logic.tasks import Possible, Rule, Task
from prefplan.models.generated import GeneratedSystem, OnDemand
from prefplan.models.transition_system import Quotient, Trajectory, TransitionSystem
from prefplan.plan import Plan
from prefplan.planner import Planner
from prefplan.preferences.kinds import WeightedSum
from prefplan.problem import Problem


@dataclass(frozen=True)
class Past:
    """K actions that were taken, each with the observation before it.

    Attributes:
        actions: (K,) in order.
        costs: (K,) cost of each, whether or not it succeeded.
        states: (K,) state before each; the first is the initial state.
        labels: (K,) the propositions that held in these states.
    """

    actions: tuple[str, ...] = ()
    costs: tuple[Number, ...] = ()
    states: tuple[Hashable, ...] = ()
    labels: tuple[frozenset[str], ...] = ()

    @property
    def cost(self) -> Number:
        """The total cost so far."""
        return to_number(sum((exact(cost) for cost in self.costs), Fraction(0)))


def continued(problem: Problem, past: Past, system: TransitionSystem) -> Problem:
    """Return the problem in which every plan begins with the past; the start of `system` is the present."""
    known = problem.system.propositions | system.propositions
    if not past.actions:
        return Problem(system.knowing(known), problem.tasks, problem.preference, rules=problem.rules)
    present = "present"
    while present in known:
        present += "_"
    joined = _Continuation(past, system, present, known | {present})
    return Problem(joined, problem.tasks, problem.preference, rules=problem.rules, present=present)


def continue_cheaply(
    problem: Problem, past: Past, system: TransitionSystem, *, max_preference: Number | None = None
) -> Plan:
    """Return the plan of least total cost, and of least mu among those, that begins with the past.

    Raises:
        NoPlanError: there is none.
    """
    planner = Planner(continued(problem, past, system))
    plan = planner.cheapest(max_preference=max_preference)
    if len(plan.actions) < len(past.actions):
        # All plans that end within the past cost as much as the past; the best of them is the preferred one.
        plan = planner.preferred(max_cost=past.cost)
    return _reaching(past, plan, system)


def continue_as_preferred(problem: Problem, past: Past, system: TransitionSystem) -> Plan:
    """Return the plan of least mu that begins with the past, and of least total cost among those.

    Raises:
        NoPlanError: there is none.
    """
    return _reaching(past, Planner(continued(problem, past, system)).preferred(), system)


def damaged(problem: Problem, labels: Sequence[frozenset[str]]) -> tuple[str, ...]:
    """Return the names of the tasks that no continuation of a trace satisfies without relaxations."""
    automata = zip(problem.names, problem.automata, strict=True)
    return tuple(name for name, dfa in automata if reduce(dfa.step, labels, 0) == dfa.dead)


def violated(problem: Problem, labels: Sequence[frozenset[str]]) -> tuple[str, ...]:
    """Return the names of the tasks that may not be skipped and that nothing can satisfy after a trace, even relaxed.

    Empty if the trace breaks a rule that may not be broken.
    """
    rules_broken = problem.broken(labels)
    if any(rule.skip is None and rule.name in rules_broken for rule in problem.rules):
        return ()
    broken = []
    for task, dfa in zip(problem.tasks, problem.weighted_automata, strict=True):
        states = {0}
        for label in labels:
            states = {reading.state for state in states for reading in dfa.readings(state, label)}
        if states == {dfa.automaton.dead} and task.skip is None:
            broken.append(task.name)
    return tuple(broken)


def with_rules(problem: Problem, rules: Iterable[Rule], labels: Sequence[frozenset[str]]) -> Problem:
    """Return a problem with further rules, except those that a trace has already broken."""
    added = tuple(rules)
    if not added:
        return problem
    ruled = Problem(problem.system, problem.tasks, problem.preference, rules=(*problem.rules, *added))
    broken = ruled.broken(labels)
    kept = tuple(rule for rule in added if rule.name not in broken)
    return Problem(problem.system, problem.tasks, problem.preference, rules=(*problem.rules, *kept))


def sparing(problem: Problem, others: Iterable[Task], labels: Sequence[frozenset[str]]) -> Problem:
    """Return a problem whose plans keep other tasks satisfiable, except those that a trace has made unsatisfiable."""
    return with_rules(problem, [Possible(task.name, task.formula) for task in others], labels)


def achievable(
    problem: Problem, past: Past, system: TransitionSystem, *, spared: Collection[Task] | None = None
) -> tuple[Problem, Plan] | None:
    """Return a problem with tasks that can still be satisfied together, and a cheapest plan for them; None for none.

    Of tasks that conflict with each other the last one is left out first; of tasks that conflict with a rule, the last
    that does so by itself. The preference of the smaller problem is always 0.

    Args:
        problem: the problem with all tasks.
        past: the past, with which every plan begins.
        system: the system ahead; its start is the present.
        spared: other tasks that the plan must keep satisfiable, like the tasks left out; None to keep none so.
    """
    labels, tasks = [*past.labels, system.label(system.start)], problem.tasks
    while tasks:
        fewer = Problem(problem.system, tasks, WeightedSum({}, over="violation"), rules=problem.rules)
        left_out = [task for task in problem.tasks if task not in tasks]
        kept = fewer if spared is None else sparing(fewer, [*spared, *left_out], labels)
        try:
            return fewer, continue_cheaply(kept, past, system)
        except NoPlanError as error:
            name = _breaking(kept, past, system) if error.reason.kind == "rule" else error.reason.tasks[-1]
            tasks = tuple(task for task in tasks if task.name != name)
    return None


def _breaking(problem: Problem, past: Past, system: TransitionSystem) -> str:
    """Return the name of the last task that no plan satisfies by itself within the rules, or else of the last task."""
    for task in reversed(problem.tasks):
        try:
            continue_cheaply(Problem(problem.system, (task,), problem.preference, rules=problem.rules), past, system)
        except NoPlanError:
            return task.name
    return problem.names[-1]


def valued(problem: Problem, past: Past, plan: Plan, system: TransitionSystem) -> Plan:
    """Return a plan for some of the tasks, which begins with the past, with the costs and mu it has for all tasks."""
    labels, costs = _ahead(past, plan, system)
    worth = Ledger.of(problem, plan.actions, (*past.costs, *costs), labels, plan.relaxations).final
    return replace(
        plan,
        preference=worth.preference,
        preferences=dict.fromkeys(plan.preferences, worth.preference),
        task_costs=worth.task_costs,
        violation_costs=worth.violation_costs,
    )


def spoiled(problem: Problem, past: Past, plan: Plan, system: TransitionSystem) -> tuple[str, ...]:
    """Return the names of the tasks that a plan, which begins with the past, makes unsatisfiable."""
    labels, _ = _ahead(past, plan, system)
    before = damaged(problem, labels[: len(past.labels) + 1])
    return tuple(name for name in damaged(problem, labels) if name not in before)


def _ahead(past: Past, plan: Plan, system: TransitionSystem) -> tuple[list[frozenset[str]], list[Number]]:
    """Return the labels before and after each action of a plan that begins with the past, and the costs ahead."""
    state, costs = system.start, list[Number]()
    labels = [*past.labels, system.label(state)]
    for action in plan.actions[len(past.actions) :]:
        state, cost = system.step(state, action)
        labels.append(system.label(state))
        costs.append(cost)
    return labels, costs


def _reaching(past: Past, plan: Plan, system: TransitionSystem) -> Plan:
    """Return a plan that reaches the present at least, as the cost of actions after the last task is spent already."""
    if len(plan.actions) >= len(past.actions):
        return plan
    states = (*past.states, system.states[system.start])
    return replace(plan, cost=past.cost, actions=past.actions, states=states, action_costs=past.costs)


class _Continuation(GeneratedSystem):
    """The past as a chain that leads to the start of a system, in which `present` holds.

    States 0 .. K-1 are those of the past; then come those of the system.
    """

    def __init__(self, past: Past, ahead: TransitionSystem, present: str, known: frozenset[str]) -> None:
        spent = [exact(cost) for cost in past.costs]
        super().__init__(
            start=0,
            unit=common_unit([ahead.unit, *spent]),
            propositions=known,
            resolution=ahead.resolution,
            display=ahead.display,
            past=past,
            ahead=ahead,
            present=present,
            spent=spent,
        )

    @cached_property
    def listed(self) -> TransitionSystem:
        """All states."""
        past, ahead, length = self.past, self.ahead, len(self.past.actions)
        ahead_costs = ahead.costs.astype(object) * int(ahead.unit / self.unit)
        names = tuple(dict.fromkeys((*ahead.action_names, *past.actions)))
        chain = np.arange(1, length + 1, dtype=np.int32)
        chain[-1] += ahead.start
        own = dict.fromkeys(past.labels)
        return TransitionSystem(
            states=OnDemand(lambda: length + ahead.size, self.state),
            start=0,
            offsets=np.concatenate([np.arange(length), ahead.offsets + length]).astype(np.int64),
            targets=np.concatenate([chain, ahead.targets + np.int32(length)]),
            actions=np.concatenate([np.array([names.index(a) for a in past.actions], dtype=np.int32), ahead.actions]),
            costs=whole_numbers([*multiples(self.spent, self.unit).tolist(), *ahead_costs.tolist()]),
            unit=self.unit,
            labels=np.concatenate(
                [np.array([list(own).index(label) for label in past.labels], dtype=np.int32), ahead.labels + len(own)]
            ).astype(np.int32),
            action_names=names,
            label_sets=(*own, *(label | {self.present} for label in ahead.label_sets)),
            propositions=self.propositions,
            resolution=self.resolution,
        )

    @property
    def shared_units(self) -> tuple[Fraction, ...]:
        """See `TransitionSystem.shared_units`."""
        return (common_unit([self.ahead.shared_units[0], *self.spent]),)

    def state(self, number: int) -> Hashable:
        """Return the name of a state."""
        length = len(self.past.states)
        return self.past.states[number] if number < length else self.ahead.states[number - length]

    def label(self, state: int) -> frozenset[str]:
        """See `TransitionSystem.label`."""
        length = len(self.past.labels)
        return self.past.labels[state] if state < length else self.ahead.label(state - length) | {self.present}

    def steps(self, state: int, action: str) -> tuple[int, tuple[Fraction, ...]]:
        """See `TransitionSystem.steps`; there is one cost."""
        past, length = self.past, len(self.past.actions)
        if state >= length:
            target, costs = self.ahead.steps(state - length, action)
            return target + length, costs[:1]
        if action != past.actions[state]:
            raise ModelError(f"action {action!r} is not what was done in state {past.states[state]!r}")
        return state + 1 + (self.ahead.start if state + 1 == length else 0), (self.spent[state],)

    def quotient(self, names: Collection[str], *, may_hurry: bool) -> Quotient:
        """See `TransitionSystem.quotient`; the past is not changed."""
        smaller, length = self.ahead.quotient(names, may_hurry=may_hurry), len(self.past.actions)

        def lift(trajectory: Trajectory) -> Trajectory:
            actions, states = trajectory
            rest = (actions[length:], states[length:])
            ahead = smaller.lift(rest) if len(actions) >= length else rest
            return (*actions[:length], *ahead[0]), (*states[:length], *ahead[1])

        return Quotient(_Continuation(self.past, smaller.system, self.present, self.propositions).listed, lift)
