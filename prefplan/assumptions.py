"""What the front of a problem is exact for."""

from __future__ import annotations

from prefplan.problem import Problem
from prefplan.text import number


def assumptions(problem: Problem) -> tuple[str, ...]:
    """Return a sentence for every assumption under which a front is exact."""
    notes = []
    if problem.resolution is not None:
        notes.append(f"Costs are rounded to multiples of {number(problem.resolution)}; the front is exact for those.")
    for objective in problem.objectives:
        if objective.measure.claimed:
            called = "the preference" if problem.is_bi_objective else objective.name
            claim = f"That {called} is {objective.measure.contract} is a claim of the scenario"
            notes.append(f"{claim}, tested on random costs only.")
    return tuple(notes)
