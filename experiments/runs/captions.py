"""Captions of a run's video: the current action, the costs so far and the satisfied tasks."""

import math
from dataclasses import replace

from experiments.runs.formula_words import goal_words
from experiments.runs.outcome import Outcome
from sim import Caption, TaskStatus

NEWS = {"replan": "planned again: ", "retry": "once more: "}
"""Words before the first action after an event."""

TO_START = "to the start"
"""Words while the hand moves to its location in the model's start state."""


def captions(outcome: Outcome) -> tuple[Caption, ...]:
    """Return a caption for every action, with the costs at its start, and one for the time before and after them.

    The first action of a new plan says so, and so does an action that is tried again.
    """
    run, plan, model = outcome.run, outcome.plan, outcome.scenario.model
    problem = outcome.ledger.problem
    display, wanted = problem.display, {task.name: goal_words(task, model) for task in problem.tasks}
    before = [-math.inf, *(step.start for step in run.steps)]
    shown = []
    for since, step in zip(before, run.steps, strict=False):
        news = [NEWS[event.kind] for event in run.events if event.kind in NEWS and since < event.time <= step.start]
        shown.append((step.start, "".join(news[-1:]) + display.action(step.action)))
    shown.append((run.sim_seconds, "done" if run.completed else "stopped"))
    told = tuple(
        Caption(
            start,
            action,
            float(entry.cost),
            float(plan.cost),
            tuple(
                TaskStatus(shown, words.removeprefix(f"{shown}: "), "satisfied" if task in entry.satisfied else "open")
                for task, words in wanted.items()
                for shown in [display.task(task)]
            ),
            float(entry.preference),
            float(plan.preference),
        )
        for (start, action), entry in zip(shown, outcome.ledger.entries, strict=True)
    )
    if told[0].start > 0:
        return replace(told[0], start=0.0, action=TO_START), *told
    return told
