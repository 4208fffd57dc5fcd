"""Differences between plans: the objects that they put aside, and the landmarks on their paths."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby, takewhile

from experiments.runs.formula_words import at_words
from prefplan import Action, Ledger, ManipulationModel
from prefplan.logic.formula import propositions_of
from prefplan.models.manipulation.symbolic import at
from prefplan.scenario.decode import Model


@dataclass(frozen=True)
class Parking:
    """An object that is put down for a while, not for a task, and where, such as `on desk`; both as they are shown."""

    obj: str
    where: str


def set_aside(model: Model, plan: Ledger, other: Ledger) -> list[Parking]:
    """Return what a plan puts aside and the other one does not."""
    return list((Counter(parkings(model, plan)) - Counter(parkings(model, other))).elements())


def common(one: Sequence[str], other: Sequence[str]) -> int:
    """Return the length of the common prefix of two sequences."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(one, other, strict=False)))


def parkings(model: Model, plan: Ledger) -> tuple[Parking, ...]:
    """Return the objects that are put down and later grasped again, without use for a task.

    A release is without use if it changes no automaton's state and adds no mark that a formula mentions.
    """
    if not isinstance(model, ManipulationModel):
        return ()
    resting = {at(obj.name, place.name) for obj in model.objects for place in model.locations}
    marks, advancing, found = _mentioned(plan) - resting, _advancing(plan), []
    for k, text in enumerate(plan.actions, 1):
        action = model.action(text)
        if action.kind == "release" and str(Action("grasp", action.obj)) in plan.actions[k:]:
            gained = (plan.labels[k] - plan.labels[k - 1]) & marks
            if not gained and k not in advancing:
                found.append(Parking(model.display.obj(action.obj), at_words(action.location, model)))
    return tuple(found)


def landmarks(plan: Ledger) -> tuple[str, ...]:
    """Return the formulas' propositions that hold where a task advances, in order, without repetitions."""
    mentioned, advancing = _mentioned(plan), _advancing(plan)
    found, before = [], frozenset[str]()
    for k, label in enumerate(plan.labels):
        new = label & mentioned - before
        if new and k in advancing:
            found.append(" and ".join(sorted(new)))
        before = label
    return tuple(name for name, _ in groupby(found))


def _mentioned(plan: Ledger) -> frozenset[str]:
    return frozenset[str]().union(*(propositions_of(task.tree) for task in plan.problem.tasks))


def _advancing(plan: Ledger) -> set[int]:
    """Return the numbers of the actions, from 1, that change the state of a task's automaton."""
    return {step for task in plan.problem.names for step in plan.advances(task)}
