"""Checks of a scenario before planning: its size, its tasks one at a time, and likely mistakes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

from experiments.checks.propositions import size_of, uncarried
from experiments.cli.progress import Tell
from experiments.cli.start import has_simulation
from prefplan.errors import LimitError
from prefplan.exact_costs import Number, exact, to_number
from prefplan.front import NoPlanError, Reason, UnfinishedError
from prefplan.limits import Limits, interruptible
from prefplan.logic.mtbdd import same
from prefplan.models.feasibility import Feasible
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.planner import Planner
from prefplan.preferences.kinds import WeightedSum
from prefplan.preferences.objective import NamedPreference
from prefplan.problem import Problem, Task
from prefplan.scenario.decode import Scenario
from prefplan.search.infeasibility import infeasible

if TYPE_CHECKING:
    from sim.capability.place_check import PlaceCheck
    from sim.capability.scene_check import SceneCheck

SEARCHES = {
    "additive": "plans are compared by cost and penalty alone; no --max-cost is needed",
    "convex": "plans are compared by cost and penalty alone; no --max-cost is needed",
    "componentwise": "plans are compared task by task, which takes longer; no --max-cost is needed",
    "general": "only equal plans can be compared: `front` and the preferred plan need --max-cost",
}
"""What a contract means for planning."""


def check(
    scenario: Scenario,
    *,
    robot: str | None = None,
    quick: bool = False,
    limits: Limits | None = None,
    tell: Tell = lambda stage, done, total, what: None,
) -> dict[str, Any]:
    """Check a scenario without planning its tasks together, and return the documented JSON object.

    What is not found before a limit or Ctrl-C stays unknown. If `quick`, it is not checked what the arm can do with
    each object at each location.

    Raises:
        ScenarioError: the scenario has a mistake.
        LimitError: a limit was reached before the scenario's problem was built.
        RobotError: the robot is unknown or cannot be loaded.
    """
    limits = limits or Limits()
    with limits:
        problem = scenario.problem()
    model, contract = scenario.model, problem.measure.contract
    tasks = [_check_task(problem, i, limits)[0] for i in range(len(problem.tasks))]
    arm: SceneCheck | None = None
    faults: list[str] = []
    if isinstance(model, ManipulationModel) and has_simulation() and not limits.out_of_time:
        from sim.capability.answers import Capability
        from sim.capability.scene_check import check_scene

        capability = Capability(model, robot=robot)
        arm = check_scene(capability, limits, quick=quick, tell=tell)
        faults += arm.faults or ()
        asked = [i for i, task in enumerate(tasks) if task["achievable"]] if arm.places and arm.complete else []
        for i in asked:
            tell("tasks", i, len(tasks), problem.names[i])
            tasks[i], missing = _check_task(problem, i, limits, capability)
            if missing:
                what = f"task {problem.names[i]} needs what the arm cannot do: {missing}"
                faults.append(f"tasks[{i}].formula: {what}")
    size, names = size_of(problem.system, limits), problem.cost_names
    finished = size["states"] is not None and all(task["achievable"] is not None for task in tasks)
    return {
        "scenario": scenario.name,
        "path": str(scenario.path),
        "kind": model.kind,
        "interrupted": limits.interrupted,
        "complete": finished and (arm is None or arm.complete),
        **size,
        "tasks": tasks,
        "contract": contract,
        "meaning": SEARCHES[contract],
        "preferences": [
            {"name": one.name, "contract": one.contract, "of": names[one.cost]} for one in problem.objectives
        ],
        "costs": list(names),
        "scene": None if arm is None or arm.faults is None else not arm.faults,
        "places": None if arm is None or arm.places is None else [_place_json(one) for one in arm.places],
        "faults": faults,
        "warnings": [*(arm.warnings if arm else ()), *_warnings(problem, size["propositions"], tasks, faults)],
    }


def impossible(found: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the tasks that, as `check` found, cannot be satisfied even alone."""
    return tuple(task["name"] for task in found["tasks"] if task["achievable"] is False)


def reason(problem: Problem, impossible: Sequence[str]) -> Reason:
    """Return why some tasks are impossible: they can never be satisfied, or the rules forbid it.

    Raises:
        LimitError: a limit was reached before that is known.
    """
    if not problem.hard_rules:
        return Reason("task", tuple(impossible))
    tasks = [task for task in problem.tasks if task.name in impossible]
    found = infeasible(Problem(problem.system, tasks, WeightedSum({}, over="violation"), rules=problem.hard_rules))
    assert found is not None
    return found


def _place_json(one: PlaceCheck) -> dict[str, Any]:
    found: dict[str, Any] = {"object": one.obj, "location": one.location, "take": one.take, "put": one.put}
    found["reason"] = one.reason
    for key in ("take_unless", "put_unless", "crowded_by"):
        found[key] = [{"object": obj, "location": location} for obj, location in getattr(one, key)]
    return found


def _check_task(
    problem: Problem, i: int, limits: Limits, feasible: Feasible | None = None
) -> tuple[dict[str, Any], str]:
    """Return what is found of one task alone: its least costs without relaxations, and whether it is achievable.

    With what an arm can do, this is about plans that it can keep; then also what it cannot do is returned, if it makes
    the task impossible.
    """
    task, missing = problem.tasks[i], ""
    costs, achievable = None, None
    with suppress(UnfinishedError, LimitError):
        costs, missing = _least_costs(problem, replace(task, relax=(), skip=None), limits, feasible)
        if costs is None and (task.relax or task.skip is not None):
            relaxed, missing = _least_costs(problem, task, limits, feasible)
            achievable = relaxed is not None
        else:
            achievable = costs is not None
    found = {
        "name": task.name,
        "formula": task.formula,
        "automaton_states": problem.automata[i].size,
        "cost": costs and costs[problem.cost_names[0]],
        "costs": costs,
        "achievable": achievable,
        "relaxations": len(task.relax),
        "skip": None if task.skip is None else to_number(exact(task.skip)),
    }
    return found, missing


def _least_costs(
    problem: Problem, task: Task, limits: Limits, feasible: Feasible | None
) -> tuple[dict[str, Number] | None, str]:
    """Return the least value of each cost of a problem for a task alone, relaxed if need be.

    If it is impossible, None and what the arm cannot do of it.

    Raises:
        UnfinishedError, LimitError: a limit was reached, or Ctrl-C pressed, before that is known.
    """
    # The name of a preference must differ from those of all costs.
    name = f"unmet_{'_'.join(problem.cost_names)}"
    unmet = NamedPreference(name, WeightedSum({task.name: 1}, over="violation"))
    planner = Planner(Problem(problem.system, [task], [unmet], rules=problem.hard_rules, feasible=feasible))
    try:
        with interruptible(limits):
            return {name: planner.best(name).costs[name] for name in problem.cost_names}, ""
    except NoPlanError:
        return None, planner.geometry.words if planner.geometry is not None else ""


def _warnings(
    problem: Problem, carried: Mapping[str, int | None], tasks: Sequence[Mapping[str, Any]], faults: Sequence[str]
) -> Iterator[str]:
    start = problem.system.label(problem.system.start)
    for i, (task, dfa, found) in enumerate(zip(problem.tasks, problem.automata, tasks, strict=True)):
        yield from uncarried(i, task, carried)
        if dfa.step(0, start) == dfa.accepting:
            yield f"tasks[{i}].formula: task {task.name} is satisfied at the start, before any action"
        is_fault = any(fault.startswith(f"tasks[{i}].") for fault in faults)
        if found["costs"] is None and found["achievable"] is not None and not is_fault:
            result = "it can only be relaxed or skipped" if found["achievable"] else "so that no plan exists"
            within = " within the rules" if problem.hard_rules else ""
            yield f"tasks[{i}].formula: task {task.name} cannot be satisfied{within}, not even alone; {result}"
    for (i, one), (k, other) in combinations(enumerate(problem.automata), 2):
        alike = one.size == other.size and one.accepting == other.accepting
        if alike and all(map(same, one.transitions, other.transitions)):
            names = problem.names
            yield f"tasks[{k}].formula: task {names[k]} asks for the same as task {names[i]}"
