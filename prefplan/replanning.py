"""Replanning during an execution: every plan begins with the actions and observations so far.

The automata read the observed labels of the past, and the search goes on from there: the planner optimises the
(cost, mu) of past and future together. Relaxations of past labels are chosen with those of future ones, since none has
been paid for yet.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from typing import Any

from prefplan.exact_costs import Number
from prefplan.front import NoPlanError
from prefplan.ledger import Ledger
from prefplan.logic.tasks import Possible, Task
from prefplan.models.system import Past, System
from prefplan.plan import Plan
from prefplan.planner import Planner
from prefplan.preferences.kinds import WeightedSum
from prefplan.problem import Problem
from prefplan.product.product_automaton import histories


def continued(problem: Problem, past: Past, system: System) -> Problem:
    """Return the problem in which every plan begins with the past; the start of `system` is the present."""
    names = problem.system.propositions | system.propositions
    ahead = replace(system.after(past.states), costs=system.costs[:1], propositions=names)
    return _changed(problem, system=ahead, past=past)


def _changed(problem: Problem, **parts: Any) -> Problem:
    """Return a problem with other parts, without the past."""
    names = ("system", "tasks", "preference", "rules", "feasible")
    return Problem(**{name: getattr(problem, name) for name in names} | parts)


def continue_cheaply(problem: Problem, past: Past, system: System, *, max_preference: Number | None = None) -> Plan:
    """Return the plan of least total cost, and of least mu among those, that begins with the past.

    Raises:
        NoPlanError: there is none.
    """
    return Planner(continued(problem, past, system)).cheapest(max_preference=max_preference)


def continue_as_preferred(problem: Problem, past: Past, system: System) -> Plan:
    """Return the plan of least mu that begins with the past, and of least total cost among those; or NoPlanError."""
    return Planner(continued(problem, past, system)).preferred()


def damaged(problem: Problem, labels: Sequence[frozenset[str]]) -> tuple[str, ...]:
    """Return the names of the tasks that no continuation of a trace satisfies without relaxations."""
    automata = zip(problem.names, problem.automata, strict=True)
    return tuple(name for name, dfa in automata if dfa.dead in dfa.run(labels))


def violated(problem: Problem, labels: Sequence[frozenset[str]]) -> tuple[str, ...]:
    """Return the names of the tasks that may not be skipped and that nothing can satisfy after a trace, even relaxed.

    Empty if the trace breaks a rule that may not be broken.
    """
    if not all(histories(dfa, labels) for dfa in problem.followers[len(problem.tasks) :]):
        return ()
    automata = zip(problem.names, problem.weighted_automata, strict=True)
    return tuple(name for name, dfa in automata if {h.state for h in histories(dfa, labels)} == {dfa.automaton.dead})


def keeping_satisfiable(problem: Problem, others: Iterable[Task], labels: Sequence[frozenset[str]]) -> Problem:
    """Return a problem whose plans keep other tasks satisfiable, except those that a trace has made unsatisfiable.

    The result is meant for `continued`: if rules were added, it has neither the past nor further preferences.
    """
    names = problem.system.propositions
    rules = [Possible(task.name, task.formula, propositions=names) for task in others]
    kept = [rule for rule in rules if rule.automaton.first_accepted(labels) is None]
    return _changed(problem, rules=(*problem.rules, *kept)) if kept else problem


def achievable(
    problem: Problem, past: Past, system: System, *, others: Collection[Task] | None = None
) -> tuple[Problem, Plan] | None:
    """Return a problem with tasks that can still be satisfied together, and a cheapest plan for them; None for none.

    While there is no plan, one more task is left out: the last of those that conflict with each other, or one that by
    itself conflicts with a rule. The preference of the smaller problem is always 0.

    Args:
        problem: the problem with all tasks.
        past: the past, with which every plan begins.
        system: the system ahead; its start is the present.
        others: other tasks that the plan must keep satisfiable, as well as the tasks left out; None to keep neither.
    """
    labels, tasks = [*past.labels, system.label(system.start)], problem.tasks
    while tasks:
        fewer = _changed(problem, tasks=tasks, preference=WeightedSum({}, over="violation"))
        left_out = [task for task in problem.tasks if task not in tasks]
        kept = fewer if others is None else keeping_satisfiable(fewer, [*others, *left_out], labels)
        try:
            return fewer, continue_cheaply(kept, past, system)
        except NoPlanError as error:
            name = _breaking(kept, past, system) if error.reason.kind == "rule" else error.reason.tasks[-1]
            tasks = tuple(task for task in tasks if task.name != name)
    return None


def _breaking(problem: Problem, past: Past, system: System) -> str:
    """Return the name of a task that no plan satisfies by itself within the rules, or else of the last task."""
    for task in problem.tasks:
        try:
            continue_cheaply(_changed(problem, tasks=(task,)), past, system)
        except NoPlanError:
            return task.name
    return problem.names[-1]


def valued(problem: Problem, past: Past, plan: Plan, system: System) -> Plan:
    """Return a plan for some of the tasks, which begins with the past, with the costs and mu it has for all tasks."""
    _, _, labels, costs = past.along(system, plan.actions)
    entry = Ledger.of(problem, plan.actions, costs[0], labels, plan.relaxations).final
    return replace(
        plan,
        preference=entry.preference,
        preferences=dict.fromkeys(plan.preferences, entry.preference),
        task_costs=entry.task_costs,
        violation_costs=entry.violation_costs,
    )


def tasks_lost_by(problem: Problem, past: Past, plan: Plan, system: System) -> tuple[str, ...]:
    """Return the names of the tasks that a plan, which begins with the past, makes unsatisfiable."""
    _, _, labels, _ = past.along(system, plan.actions)
    before = damaged(problem, labels[: len(past.labels) + 1])
    return tuple(name for name in damaged(problem, labels) if name not in before)
