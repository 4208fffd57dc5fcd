"""The answer of `prefplan check` to a scene, found without trying out every object at every location where possible."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from functools import partial

from experiments.checks.checkup import check, is_achievable
from prefplan.errors import PrefplanError
from prefplan.limits import Limits
from prefplan.models.manipulation.action import at
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.plan import Plan
from prefplan.planner import Planner
from prefplan.scenario.decode import Scenario
from prefplan.text.names import NAME
from sim.capability.arrangement import allowed_places
from sim.capability.feasibility import Feasibility
from sim.capability.scene_check import tasks_out_of_reach
from sim.world.scene import Scene, build_scene

MAX_BYTES = 3e9
"""Memory for finding out whether a task can be achieved; beyond that it counts as achievable."""


def answer(scenario: Scenario, model: ManipulationModel) -> tuple[Scene | None, list[str]]:
    """Return a scenario's scene, None if the check refuses its layout, and why `prefplan check` refuses it, if it does.

    Raises:
        PrefplanError: the scenario has a mistake.
    """
    scene = None
    with suppress(PrefplanError):
        scene = build_scene(model)
        faults = _faults_of_plan(scenario, scene, Planner(scenario.problem()).cheapest())
        if faults is not None:
            return scene, faults
    found = check(scenario)
    return scene, [*found.faults, *(f"task {name} cannot be satisfied" for name in found.impossible)]


def _faults_of_plan(scenario: Scenario, scene: Scene, plan: Plan) -> list[str] | None:
    """Return the faults that the check finds, given a plan for all tasks; None if it takes a whole check to tell.

    If the arm can do what the plan needs, every task can be achieved. If not, what it cannot do of that, or with the
    objects that tasks name, may suffice to refuse one: what else it cannot do cannot help.
    """
    problem, model, arm = scenario.problem(), scene.model, Feasibility(scene)
    if arm.check_start() is not None:
        return None
    achievable = partial(is_achievable, limits=Limits(bytes=MAX_BYTES))
    lacking = [
        (obj, location) for kind, obj, location in _uses(model, plan) if arm.unavailable_because(kind, obj, location)
    ]
    if not lacking:
        return []
    words = {word for task in problem.tasks for word in re.findall(NAME, task.formula)}
    named = {obj.name for obj in model.objects if any(at(obj.name, place.name) in words for place in model.locations)}
    wanted = [True] * len(problem.tasks)
    for pairs in (lacking, [(obj, location) for obj, location in allowed_places(model) if obj in named]):
        places = [arm.check(obj, location) for obj, location in dict.fromkeys(pairs)]
        if faults := list(tasks_out_of_reach(problem, wanted, places, achievable)):
            return faults
    return None


def _uses(model: ManipulationModel, plan: Plan) -> Iterator[tuple[str, str, str]]:
    """Yield the kind, the object and the location of each grasp and release of a plan."""
    places = dict(model.initial_state.place)
    for kind, obj, *location in (text.split() for text in plan.actions if text.split()[0] in ("grasp", "release")):
        if kind == "grasp":
            yield kind, obj, places[obj]
        else:
            places[obj] = location[0]
            yield kind, obj, location[0]
