"""How a plan's execution stands between two actions: what is done, what was spent, which tasks are satisfied."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from experiments.runs.tally import tally
from prefplan.exact_costs import Number, exact, to_number
from prefplan.front import Plan
from prefplan.problem import Problem
from sim.execution.closed_loop import ClosedLoop

NEWS = {"fault": "fault", "replan": "planned again", "retry": "tried again", "ended": "given up"}
"""Events that a spectator is told of, and how."""


@dataclass(frozen=True)
class Progress:
    """How a task stands.

    Attributes:
        name: the task's name.
        formula: what it asks for.
        cost: what was spent until it was satisfied; None while it is not.
    """

    name: str
    formula: str
    cost: Number | None


@dataclass(frozen=True)
class Standing:
    """How an execution stands after some of its actions.

    Attributes:
        time: simulated time from which on it stands so, s.
        plan: the plan followed now; what is done is its beginning.
        done: how many actions are done.
        cost: spent so far.
        preference: mu of what was spent so far, which never falls as more is.
        tasks: in the order of the file.
        news: what went wrong and what was done about it so far, a line each.
        ended: `completed`, or why the execution ended before; None while it goes on.
    """

    time: float
    plan: Plan
    done: int
    cost: Number
    preference: Number
    tasks: tuple[Progress, ...]
    news: tuple[str, ...] = ()
    ended: str | None = None


def standing(problem: Problem, loop: ClosedLoop, *, ended: str | None = None) -> Standing:
    """Return how the pursuit of a plan stands now, between two actions."""
    run, plan = loop.run, loop.plan
    books = tally(problem, plan, run.steps)
    satisfied = books.satisfied[-1]
    tasks = tuple(
        Progress(task.name, task.formula, books.task_cost(task.name) if task.name in satisfied else None)
        for task in problem.tasks
    )
    return Standing(
        float(run.cell.data.time),
        plan,
        len(run.steps),
        books.cost,
        _preference(problem, plan, [books.task_cost(name) for name in problem.names], len(run.steps)),
        tasks,
        tuple(_news(event.time, event.kind, event.detail) for event in run.cell.events if event.kind in NEWS),
        ended,
    )


def _preference(problem: Problem, plan: Plan, costs: list[Number], done: int) -> Number:
    """Return mu of what the tasks cost so far, and of what was paid so far to relax them."""
    paid = [
        sum((exact(b.cost) for b in plan.relaxations if b.task == name and b.step <= done), Fraction(0))
        for name in problem.names
    ]
    return to_number(problem.measure.value([exact(cost) for cost in costs], paid))


def _news(time: float, kind: str, detail: dict[str, object]) -> str:
    about = detail["fault"] if kind == "fault" else detail["reason"]
    return f"{time:.1f} s: {NEWS[kind]}: {about}"
