"""A plan checked against what its problem means, sharing nothing with the automata and the search that made it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from experiments.cli.output import number
from experiments.report.timeline import Timeline
from prefplan.exact_costs import Number, exact, to_number
from prefplan.front import Plan
from prefplan.logic.formula import holds, parse
from prefplan.logic.good_prefix import satisfied_at
from prefplan.problem import Problem


@dataclass(frozen=True)
class PlanCheck:
    """One thing that was checked.

    Attributes:
        name: what.
        holds: the verdict.
        words: what was found.
    """

    name: str
    holds: bool
    words: str


def check_plan(problem: Problem, plan: Plan, timeline: Timeline) -> tuple[PlanCheck, ...]:
    """Check a plan's costs, its tasks, its relaxations and its preference by their definitions.

    Args:
        problem: what was planned.
        plan: what the search says.
        timeline: the plan as the transition system carries it out; its automata are not looked at.
    """
    return tuple(_checks(problem, plan, timeline))


def _checks(problem: Problem, plan: Plan, timeline: Timeline) -> Iterator[PlanCheck]:
    spent = timeline.spent
    yield PlanCheck("actions", True, f"each of the {len(plan.actions)} exists where it is taken")
    yield _same("total cost", plan.cost, spent[-1])
    costs, violations = [], []
    for task in problem.tasks:
        mine = [bought for bought in plan.relaxations if bought.task == task.name]
        paid = sum((exact(bought.cost) for bought in mine), Fraction(0))
        violations.append(paid)
        if mine:
            offered = all(
                task.skip is not None and exact(task.skip) == exact(bought.cost) and bought.step == 0
                if bought.assume is None
                else any(
                    offer.assume == bought.assume
                    and exact(offer.cost) == exact(bought.cost)
                    and holds(parse(offer.when), timeline.labels[bought.step])
                    for offer in task.relax
                )
                for bought in mine
            )
            words = "as the scenario offers it" if offered else "not as the scenario offers it"
            yield PlanCheck(f"{task.name} relaxed for {number(to_number(paid))}", offered, words)
        skipped = any(bought.assume is None for bought in mine)
        end = None
        if not skipped:
            read = [
                label | {bought.assume for bought in mine if bought.assume and bought.step == k}
                for k, label in enumerate(timeline.labels)
            ]
            end = satisfied_at(parse(task.formula), read)
            after = (
                "never satisfied" if end is None else f"satisfied after action {end}" if end else "satisfied at once"
            )
            yield PlanCheck(f"{task.name}", end is not None, after)
        cost = spent[-1] if end is None else spent[end]
        costs.append(exact(cost))
        yield _same(f"cost of {task.name}", plan.task_costs[task.name], cost)
    yield _same("preference", plan.preference, to_number(problem.measure.value(costs, violations)))


def _same(name: str, said: Number, found: Number) -> PlanCheck:
    same = abs(float(said) - float(found)) <= 1e-9 * max(1.0, abs(float(found)))
    words = number(to_number(exact(said)))
    return PlanCheck(name, same, words if same else f"{words} is said, {number(found)} is right")
