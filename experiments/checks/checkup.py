"""Checks of a scenario before planning: its size, its tasks one at a time, and likely mistakes."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING

from experiments.checks.propositions import size_of, uncarried
from experiments.cli.progress import Tell
from experiments.cli.start import has_simulation
from prefplan.errors import LimitError
from prefplan.exact_costs import Number
from prefplan.front import NoPlanError, UnfinishedError
from prefplan.limits import MEMORY_SHARE, Limits, available_memory, interruptible
from prefplan.logic.mtbdd import same
from prefplan.logic.syntax import split
from prefplan.models.graph_file import GraphFileModel
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.system import System
from prefplan.planner import Planner
from prefplan.preferences.kinds import WeightedSum
from prefplan.preferences.objective import NamedPreference
from prefplan.problem import Problem, Task
from prefplan.scenario.decode import Scenario
from prefplan.text.names import NAME

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

USUAL = ("additive", "convex")
"""Contracts that ask nothing of the user, who is not told of them."""


@dataclass(frozen=True)
class TaskCheck:
    """One task alone, without the other tasks.

    Attributes:
        name: of the task.
        formula: of the task.
        automaton_states: number of states of its minimal automaton.
        cost: least first cost of satisfying it without relaxations; None if that is impossible or unknown.
        costs: the same for each cost, by name; None as above.
        achievable: whether it can be satisfied, or else relaxed or skipped; None if a limit was reached first.
        relaxations: number of its `relax` entries.
        skip: price of dropping it, or None.
    """

    name: str
    formula: str
    automaton_states: int
    cost: Number | None
    costs: dict[str, Number] | None
    achievable: bool | None
    relaxations: int
    skip: Number | None


@dataclass(frozen=True)
class PreferenceCheck:
    """Name and contract of a preference, and the cost in which it counts task costs."""

    name: str
    contract: str
    of: str


@dataclass(frozen=True)
class Checkup:
    """Result of the checks.

    Attributes:
        kind: of the model.
        interrupted: whether Ctrl-C ended the checks.
        complete: whether nothing ended the checks; then the sizes below are known.
        states: of the transition system.
        reachable: number of reachable states.
        edges: number of actions in all states.
        dropped: number of edges of a file left out because another edge between the same states dominates them.
        propositions: for each, how many reachable states carry it.
        tasks: in the order of the file.
        contract: of the first preference.
        preferences: in the order of the file.
        costs: the names of the costs.
        scene: whether the arm can work in the scene; None if the model is no manipulation model, MuJoCo is not
            installed or a limit was reached first.
        faults: why the arm cannot work there, or which task needs what it cannot do; each begins with the key.
        warnings: likely mistakes, each a sentence that begins with the key.
        places: what the arm can do with each object at each location; None if that was not checked.
    """

    kind: str
    interrupted: bool
    complete: bool
    states: int | None
    reachable: int | None
    edges: int | None
    dropped: int
    propositions: dict[str, int | None]
    tasks: tuple[TaskCheck, ...]
    contract: str
    preferences: tuple[PreferenceCheck, ...]
    costs: tuple[str, ...]
    scene: bool | None
    faults: tuple[str, ...]
    warnings: tuple[str, ...]
    places: tuple[PlaceCheck, ...] | None = None

    @property
    def impossible(self) -> tuple[str, ...]:
        """The tasks that cannot be satisfied even alone."""
        return tuple(task.name for task in self.tasks if task.achievable is False)


def check(
    scenario: Scenario,
    *,
    robot: str | None = None,
    quick: bool = False,
    kept: bool = True,
    max_seconds: float = math.inf,
    max_memory: float = math.inf,
    tell: Tell = lambda stage, done, total, what: None,
) -> Checkup:
    """Check a scenario without planning its tasks together; after Ctrl-C, return what is known by then.

    Args:
        scenario: what to check.
        robot: one of `sim.robots.catalogue.ROBOTS`; None for the scenario's.
        quick: whether to leave out what the arm can do with each object at each location.
        kept: whether to read and write what the arm can do on disk.
        max_seconds: time limit; what is not known then stays unknown.
        max_memory: limit of memory, bytes.
        tell: called with the progress.

    Raises:
        ScenarioError: the scenario has a mistake.
        LimitError: a limit was reached before the scenario's problem was built.
        RobotError: the robot is unknown or cannot be loaded.
    """
    limits = Limits(max_seconds, min(max_memory, MEMORY_SHARE * available_memory()))
    with limits:
        problem = scenario.problem()
    model = _arm_model(scenario)
    tasks = tuple(_check_task(problem, i, limits) for i in range(len(problem.tasks)))
    arm: SceneCheck | None = None
    needs: list[str] = []
    if model is not None and not limits.out_of_time:
        from sim.capability.scene_check import check_scene, tasks_out_of_reach

        arm = check_scene(model, limits, robot=robot, quick=quick, kept=kept, tell=tell)
        wanted = [task.achievable is True for task in tasks]
        needs += tasks_out_of_reach(problem, wanted, arm.places or (), partial(is_achievable, limits=limits))
    size = size_of(problem.system, limits)
    finished = size["states"] is not None and all(task.achievable is not None for task in tasks)
    return Checkup(
        kind=scenario.model.kind,
        interrupted=limits.interrupted,
        complete=finished and (arm is None or arm.complete),
        dropped=scenario.model.network.dropped if isinstance(scenario.model, GraphFileModel) else 0,
        tasks=tasks,
        contract=problem.measure.contract,
        preferences=tuple(
            PreferenceCheck(one.name, one.measure.contract, problem.cost_names[one.cost]) for one in problem.objectives
        ),
        costs=problem.cost_names,
        scene=None if arm is None or arm.faults is None else not arm.faults,
        faults=(*((arm.faults if arm else None) or ()), *needs),
        warnings=(*(arm.warnings if arm else ()), *_warnings(problem, size["propositions"], tasks)),
        places=arm.places if arm else None,
        **size,
    )


def _arm_model(scenario: Scenario) -> ManipulationModel | None:
    """Return the model of a scenario if an arm can be simulated in it, and load what that takes.

    That is done before any result is known: Ctrl-C during that second ends the process.
    """
    model = scenario.model
    if not isinstance(model, ManipulationModel) or not has_simulation():
        return None
    import sim.capability.scene_check  # noqa: F401

    return model


def _check_task(problem: Problem, i: int, limits: Limits) -> TaskCheck:
    task = problem.tasks[i]
    costs, achievable = None, None
    with suppress(UnfinishedError, LimitError):
        costs = _least_costs(problem.system, replace(task, relax=(), skip=None), limits, problem.cost_names)
        achievable = costs is not None or is_achievable(problem.system, task, limits)
    return TaskCheck(
        name=task.name,
        formula=task.formula,
        automaton_states=problem.automata[i].size,
        cost=None if costs is None else costs[problem.cost_names[0]],
        costs=costs,
        achievable=achievable,
        relaxations=len(task.relax),
        skip=task.skip,
    )


def is_achievable(system: System, task: Task, limits: Limits) -> bool:
    """Return whether a task alone can be satisfied, or else relaxed or skipped.

    Raises:
        UnfinishedError, LimitError: a limit was reached, or Ctrl-C pressed, first.
    """
    return _least_costs(system, task, limits, system.cost_names[:1]) is not None


def _least_costs(system: System, task: Task, limits: Limits, names: Sequence[str]) -> dict[str, Number] | None:
    """Return the least value of each named cost for a task alone, relaxed if need be; None if it is impossible.

    Raises:
        UnfinishedError, LimitError: a limit was reached, or Ctrl-C pressed, before that is known.
    """
    # A name that differs from those of all costs.
    name = f"unmet_{'_'.join(system.cost_names)}"
    unmet = NamedPreference(name, WeightedSum({task.name: 1}, over="violation"))
    planner = Planner(Problem(system, [task], [unmet]))
    try:
        with interruptible(limits):
            return {name: planner.best(name).costs[name] for name in names}
    except NoPlanError:
        return None


def _warnings(problem: Problem, carried: dict[str, int | None], tasks: tuple[TaskCheck, ...]) -> Iterator[str]:
    start = problem.system.label(problem.system.start)
    yield from _ambiguities(problem)
    for i, (task, dfa, found) in enumerate(zip(problem.tasks, problem.automata, tasks, strict=True)):
        yield from uncarried(i, task, carried)
        if dfa.step(0, start) == dfa.accepting:
            yield f"tasks[{i}].formula: task {task.name} is satisfied at the start, before any action"
        if found.cost is None and found.achievable is not None:
            result = "it can only be relaxed or skipped" if found.achievable else "so that no plan exists"
            yield f"tasks[{i}].formula: task {task.name} cannot be satisfied, not even alone; {result}"
    for (i, one), (k, other) in combinations(enumerate(problem.automata), 2):
        alike = one.size == other.size and one.accepting == other.accepting
        if alike and all(map(same, one.transitions, other.transitions)):
            names = problem.names
            yield f"tasks[{k}].formula: task {names[k]} asks for the same as task {names[i]}"


def _ambiguities(problem: Problem) -> Iterator[str]:
    """Yield every name that could also be read as operators and a name."""
    for i, task in enumerate(problem.tasks):
        for word in re.findall(NAME, task.formula):
            operators, rest = split(word, None) or ("", "")
            if word in problem.system.propositions and rest in problem.system.propositions:
                other = " ".join([*operators, rest])
                yield f"tasks[{i}].formula: {word!r} is read as the proposition; for the operator write {other!r}"
