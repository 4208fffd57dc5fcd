"""What an execution came to: costs and tasks, read off the states that were observed, not off the plan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import cast

from prefplan.exact_costs import Number, exact, to_number
from prefplan.front import Plan
from prefplan.models.manipulation.model import ManipulationState
from prefplan.problem import Problem
from sim.simulation.rollout import Step


@dataclass(frozen=True)
class Tally:
    """The books of an execution of K actions; row k is the state of affairs after k of them.

    Attributes:
        costs: (K + 1,) spent so far.
        satisfied: (K + 1,) names of the tasks satisfied so far.
        preferences: (K + 1,) mu if every task were satisfied no later than now, which mu cannot fall below any more.
    """

    costs: tuple[Number, ...]
    satisfied: tuple[frozenset[str], ...]
    preferences: tuple[Number, ...]

    @property
    def cost(self) -> Number:
        """Total cost of what was carried out."""
        return self.costs[-1]

    def task_cost(self, task: str) -> Number:
        """Return c_i (equation 2): what was spent until a task was satisfied, in all if it never was."""
        return next((c for c, names in zip(self.costs, self.satisfied, strict=True) if task in names), self.cost)


def tally(problem: Problem, plan: Plan, steps: Sequence[Step]) -> Tally:
    """Return the books of an execution, each task's automaton reading what was observed after every action.

    Args:
        problem: the tasks, over the model's transition system.
        plan: what was carried out, from the state that was observed first; its relaxations are granted to what was
            observed.
        steps: the actions that were carried out.
    """
    start = cast(ManipulationState, plan.states[0])
    readings = [start.label, *(step.observed.label for step in steps)]
    satisfied: list[set[str]] = [set() for _ in readings]
    for task, automaton in zip(problem.tasks, problem.automata, strict=True):
        if any(bought.task == task.name and bought.assume is None for bought in plan.relaxations):
            continue
        state = 0
        for k, label in enumerate(readings):
            state = automaton.step(state, label | _assumed(plan, task.name, k))
            if state == automaton.accepting:
                satisfied[k].add(task.name)
    spent = [Fraction(0)]
    for step in steps:
        spent.append(spent[-1] + exact(step.cost))
    preferences = []
    for k in range(len(readings)):
        costs = [
            next((spent[i] for i in range(k + 1) if task.name in satisfied[i]), spent[k]) for task in problem.tasks
        ]
        violations = [_paid(plan, task.name, k) for task in problem.tasks]
        preferences.append(_number(problem.measure.value(costs, violations)))
    return Tally(tuple(map(to_number, spent)), tuple(map(frozenset, satisfied)), tuple(preferences))


def _paid(plan: Plan, task: str, step: int) -> Fraction:
    """Return what a plan has paid by some step to relax a task."""
    return sum(
        (exact(bought.cost) for bought in plan.relaxations if bought.task == task and bought.step <= step),
        Fraction(0),
    )


def _number(value: Fraction | float) -> Number:
    return to_number(value) if isinstance(value, Fraction) else value


def _assumed(plan: Plan, task: str, step: int) -> set[str]:
    """Return the propositions that a plan pays for to count as true in one reading of a task."""
    return {
        bought.assume for bought in plan.relaxations if (bought.task, bought.step) == (task, step) and bought.assume
    }
