"""How one plan differs from another: what it does more and less, what it puts aside, and which way it goes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from experiments.report.timeline import Timeline
from prefplan.logic.formula import parse, propositions_of
from prefplan.models.manipulation.action import Action, at
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.problem import Problem
from prefplan.scenario.decode import Model


@dataclass(frozen=True)
class Parking:
    """An object put down somewhere for a while only, where no task asks for it."""

    thing: str
    place: str


@dataclass(frozen=True)
class Differences:
    """What sets a plan apart from another one.

    Attributes:
        part: how many actions both begin with alike.
        more: actions it takes oftener, and how much oftener.
        fewer: actions it takes less often.
        parked: what it puts aside although the other does not.
        spared: what only the other puts aside.
        last: the last landmark both come by before their ways part, or None.
        here: the landmark it comes by next, or None.
        there: the landmark that the other comes by next, or None.
    """

    part: int
    more: Counter[str]
    fewer: Counter[str]
    parked: tuple[Parking, ...]
    spared: tuple[Parking, ...]
    last: str | None
    here: str | None
    there: str | None


def differences(model: Model, problem: Problem, plan: Timeline, other: Timeline) -> Differences:
    """Return what sets a plan apart from another plan for the same problem."""
    here, there = Counter(plan.actions), Counter(other.actions)
    mine, others = Counter(parkings(model, problem, plan)), Counter(parkings(model, problem, other))
    ways = landmarks(problem, plan), landmarks(problem, other)
    alike = common(*ways)
    return Differences(
        part=common(plan.actions, other.actions),
        more=here - there,
        fewer=there - here,
        parked=tuple((mine - others).elements()),
        spared=tuple((others - mine).elements()),
        last=ways[0][alike - 1] if alike else None,
        here=ways[0][alike] if alike < len(ways[0]) else None,
        there=ways[1][alike] if alike < len(ways[1]) else None,
    )


def common(one: Sequence[str], other: Sequence[str]) -> int:
    """Return how many entries two sequences begin with alike."""
    return next((k for k, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))


def parkings(model: Model, problem: Problem, plan: Timeline) -> tuple[Parking, ...]:
    """Return what is put down and taken up again without any task having come of it.

    Nothing has come of it if no task's automaton moved on, and no mark was left that a formula mentions.
    """
    if not isinstance(model, ManipulationModel):
        return ()
    mentioned = frozenset[str]().union(*(propositions_of(parse(task.formula)) for task in problem.tasks))
    rests = {at(thing.name, place.name) for thing in model.objects for place in model.locations}
    found = []
    for k, action in enumerate(plan.actions, 1):
        done = model.action(action)
        again = str(Action("grasp", done.obj)) in plan.actions[k:]
        if done.kind != "release" or not again:
            continue
        gained = (plan.labels[k] - plan.labels[k - 1]) & mentioned - rests
        if not gained and not any(k in track.advances for track in plan.tracks.values()):
            found.append(Parking(done.obj, done.location))
    return tuple(found)


def landmarks(problem: Problem, plan: Timeline) -> tuple[str, ...]:
    """Return what holds of the formulas' propositions wherever a task moves on, in order, repetitions left out."""
    mentioned = frozenset[str]().union(*(propositions_of(parse(task.formula)) for task in problem.tasks))
    found = []
    for k, label in enumerate(plan.labels):
        new = label & mentioned - (plan.labels[k - 1] if k else frozenset())
        if new and any(k in track.advances for track in plan.tracks.values()):
            found.append(" and ".join(sorted(new)))
    return tuple(name for name, _ in groupby(found))
