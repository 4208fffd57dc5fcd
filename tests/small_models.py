"""Small models and problems."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import judge

from prefplan import Location, ManipulationModel, Object, Problem, Task, TransitionSystem
from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.models.manipulation.slots import hand_poses
from prefplan.preferences.kinds import Preference

COSTS = {"transit": 3, "grasp": 1, "transport": 5, "release": 1}

TOWER = ManipulationModel(
    start="home",
    costs=COSTS,
    locations=(Location("a", at=(0.5, 0.0)), Location("b", on=("a",)), Location("c", on=("b",))),
    objects=(Object("one", "a"), Object("two", "b"), Object("three", "c")),
)
"""Three cubes, one upon another."""


def model(
    *objects: Object, locations: list[Location] | None = None, start: str = "home", propositions: tuple[str, ...] = ()
) -> ManipulationModel:
    """Return a model with spots a, b, c unless other locations are given."""
    spots = locations or [Location(name, at=(0.4, 0.1 * k)) for k, name in enumerate("abc")]
    return ManipulationModel(start, COSTS, tuple(spots), objects, frozenset(propositions))


def spot(name: str, **options: Any) -> Location:
    return Location(name, at=(0.5, 0.0), **options)


def after(system: TransitionSystem, *actions: str) -> int:
    """Return the state that a plan leads to."""
    state = system.start
    for action in actions:
        state, _ = system.step(state, action)
    return state


def enabled(system: TransitionSystem, *actions: str) -> list[str]:
    """Return the actions enabled after a plan, in order."""
    return [system.action_names[system.actions[edge]] for edge in system.edges(after(system, *actions))]


def label(system: TransitionSystem, *actions: str) -> frozenset[str]:
    return system.label(after(system, *actions))


def judged(problem: Problem) -> judge.GraphProblem:
    """Return a problem as the judge sees it, state by state but for its preference; states are called by number."""
    system = problem.system.listed
    edges = [
        judge.Edge(
            f"{state}",
            system.action_names[system.actions[edge]],
            judge.exact(system.cost(edge)),
            f"{system.targets[edge]}",
        )
        for state in range(system.size)
        for edge in system.edges(state)
    ]
    labels = {f"{state}": system.label(state) for state in range(system.size)}
    tasks = []
    for task in problem.tasks:
        relax = (judge.Relaxation(entry.assume, judge.parse(entry.when), entry.cost) for entry in task.relax)
        tasks.append(judge.JudgedTask(task.name, judge.parse(task.formula), tuple(relax), task.skip))
    return judge.GraphProblem(f"{system.start}", tuple(edges), labels, tuple(tasks))


def measured(what: ManipulationModel) -> ManipulationModel:
    """Return a model whose costs are measured: slots are told apart, and each action costs what its number says."""
    hands = hand_poses({place.name: place.capacity for place in what.locations}, "home")
    pairs = [(kind, before, after) for kind in COSTS for before in hands for after in hands]
    return replace(what, costs=MeasuredCosts("time", {pair: number for number, pair in enumerate(pairs)}))


NAMES = ("phi1", "phi2", "phi3")


def build(preference: Preference, names: Sequence[str] = NAMES, **task: Any) -> Problem:
    """Return a problem of tasks that all ask for q, on s -1.25-> t -2-> u with p in t, q in u, and r nowhere."""
    edges = [("s", "go", "t", 1.25), ("t", "on", "u", 2)]
    system = TransitionSystem.from_transitions(
        edges, start="s", propositions=["p", "q", "r"], labels={"t": ["p"], "u": ["q"]}
    )
    return Problem(system, [Task(name, "F q", **task) for name in names], preference)
