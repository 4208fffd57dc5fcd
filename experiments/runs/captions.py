"""Captions of an execution: for every action what runs, what has been spent and how the tasks stand."""

from __future__ import annotations

import math
from collections.abc import Sequence

from experiments.runs.tally import Tally
from prefplan.front import Plan
from prefplan.problem import Task
from sim.rendering.overlay import Caption, TaskStatus
from sim.simulation.rollout import Rollout

FINISHED, STOPPED = "done", "stopped"
"""What the last picture says instead of an action."""

NEWS = {"replan": "planned again: ", "retry": "once more: "}
"""What is said before the first action that follows an event."""


def captions(tasks: Sequence[Task], rollout: Rollout, books: Tally, *, plan: Plan) -> tuple[Caption, ...]:
    """Return a caption for every action, with the books as they stood when it began, and one for the end.

    An action that begins another plan says so, and so does one that is tried again.

    Args:
        tasks: the problem's tasks, in the order to show.
        rollout: what happened.
        books: its tally.
        plan: what was meant to happen.
    """
    last = FINISHED if rollout.completed else STOPPED
    before = [-math.inf, *(step.start for step in rollout.steps)]
    times = [
        (step.start, step.end, _news(rollout, since, step.start) + step.action)
        for since, step in zip(before, rollout.steps, strict=False)
    ]
    times.append((rollout.sim_seconds, rollout.sim_seconds, last))
    return tuple(
        Caption(
            start,
            end,
            action,
            float(cost),
            float(plan.cost),
            _statuses(tasks, satisfied),
            float(preference),
            float(plan.preference),
        )
        for (start, end, action), cost, satisfied, preference in zip(
            times, books.costs, books.satisfied, books.preferences, strict=True
        )
    )


def _news(rollout: Rollout, since: float, until: float) -> str:
    """Return what to say before an action: whether the plan is new, or the action is one tried again."""
    news = [NEWS[event.kind] for event in rollout.events if event.kind in NEWS and since < event.time <= until]
    return news[-1] if news else ""


def _statuses(tasks: Sequence[Task], satisfied: frozenset[str]) -> tuple[TaskStatus, ...]:
    return tuple(
        TaskStatus(task.name, task.formula, "satisfied" if task.name in satisfied else "open") for task in tasks
    )
