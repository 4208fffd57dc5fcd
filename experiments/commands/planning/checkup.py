"""Checks of a scenario before planning: its size, its tasks one at a time, and likely mistakes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib.util import find_spec
from itertools import combinations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order

from experiments.cli.overview import kind_of
from experiments.cli.start import loading
from prefplan.exact_costs import Number
from prefplan.front import NoPlanError
from prefplan.logic.formula import parse, propositions_of
from prefplan.logic.mtbdd import same
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.transition_system import TransitionSystem
from prefplan.planner import Planner
from prefplan.preferences.kinds import WeightedSum
from prefplan.problem import Problem, Task
from prefplan.scenario.decode import Scenario

SEARCHES = {
    "additive": "plans are compared by cost and preference penalty alone; no --max-cost is needed",
    "convex": "plans are compared by cost and preference penalty alone; no --max-cost is needed",
    "componentwise": "plans are compared task by task, which takes longer; no --max-cost is needed",
    "general": "only equal plans can be compared: `front` and the preferred plan need --max-cost",
}
"""What a contract means for planning."""


@dataclass(frozen=True)
class TaskCheck:
    """One task alone, without the other tasks.

    Attributes:
        name: the task's.
        formula: the task.
        automaton_states: states of its minimal automaton.
        cost: least cost of satisfying it without relaxations; None if that cannot be done.
        achievable: whether it can be satisfied, or else relaxed or skipped.
        relaxations: number of its `relax` entries.
        skip: price of dropping it, or None.
    """

    name: str
    formula: str
    automaton_states: int
    cost: Number | None
    achievable: bool
    relaxations: int
    skip: Number | None


@dataclass(frozen=True)
class Checkup:
    """Result of the checks.

    Attributes:
        kind: of the model.
        states: of the transition system.
        reachable: how many of them can be reached.
        edges: actions in all states.
        propositions: for each, how many reachable states carry it.
        tasks: in the order of the file.
        contract: of the preference.
        scene: whether the arm can work in the scene; None for other models than manipulation and without a simulator.
        faults: why it cannot, each a sentence that begins with the key.
        warnings: likely mistakes, each a sentence that begins with the key.
    """

    kind: str
    states: int
    reachable: int
    edges: int
    propositions: dict[str, int]
    tasks: tuple[TaskCheck, ...]
    contract: str
    scene: bool | None
    faults: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def impossible(self) -> tuple[str, ...]:
        """The tasks that cannot be satisfied even alone."""
        return tuple(task.name for task in self.tasks if not task.achievable)


def check(scenario: Scenario) -> Checkup:
    """Check a scenario without planning its tasks together.

    Raises:
        ScenarioError: it has a mistake.
    """
    problem = scenario.problem()
    system = problem.system
    reached = reachable(system)
    carried = carriers(system, reached)
    tasks = tuple(_check_task(problem, i) for i in range(len(problem.tasks)))
    faults = scene_faults(scenario)
    return Checkup(
        kind=kind_of(scenario.model),
        states=system.size,
        reachable=len(reached),
        edges=len(system.targets),
        propositions=carried,
        tasks=tasks,
        contract=problem.measure.contract,
        scene=None if faults is None else not faults,
        faults=faults or (),
        warnings=tuple(_warnings(problem, carried, tasks)),
    )


def reachable(system: TransitionSystem) -> np.ndarray:
    """Return the indices of the states that can be reached, the start's first."""
    steps = (np.ones(len(system.targets), dtype=np.int8), system.targets, system.offsets)
    graph = csr_array(steps, shape=(system.size, system.size))
    return breadth_first_order(graph, system.start, return_predecessors=False)


def carriers(system: TransitionSystem, states: np.ndarray) -> dict[str, int]:
    """Return for each proposition, sorted, how many of the states carry it."""
    counts = np.bincount(system.labels[states], minlength=len(system.label_sets)).tolist()
    return {
        name: sum(count for count, label in zip(counts, system.label_sets, strict=True) if name in label)
        for name in sorted(system.propositions)
    }


def scene_faults(scenario: Scenario) -> tuple[str, ...] | None:
    """Return why the arm cannot work in the scene of a manipulation model; None where that cannot be told."""
    if not isinstance(scenario.model, ManipulationModel) or find_spec("mujoco") is None:
        return None
    with loading():
        from sim.errors import SimulationError
        from sim.world.scene import build_scene

    try:
        build_scene(scenario.model)
    except SimulationError as error:
        return tuple(f"model.{fault}" for fault in error.faults)
    return ()


def _check_task(problem: Problem, i: int) -> TaskCheck:
    task = problem.tasks[i]
    cost = _least_cost(problem.system, replace(task, relax=(), skip=None))
    return TaskCheck(
        name=task.name,
        formula=task.formula,
        automaton_states=problem.automata[i].size,
        cost=cost,
        achievable=cost is not None or _least_cost(problem.system, task) is not None,
        relaxations=len(task.relax),
        skip=task.skip,
    )


def _least_cost(system: TransitionSystem, task: Task) -> Number | None:
    """Return the least cost of a task alone, however it is relaxed; None if it is impossible."""
    alone = Problem(system, [task], WeightedSum({task.name: 1}, over="violation"))
    try:
        return Planner(alone).cheapest().cost
    except NoPlanError:
        return None


def _warnings(problem: Problem, carried: dict[str, int], tasks: tuple[TaskCheck, ...]) -> Iterator[str]:
    start = problem.system.label(problem.system.start)
    for i, (task, dfa, found) in enumerate(zip(problem.tasks, problem.automata, tasks, strict=True)):
        for key, name in _mentions(i, task):
            if not carried[name]:
                yield f"{key}: no state that can be reached carries {name!r}"
        if dfa.step(0, start) == dfa.accepting:
            yield f"tasks[{i}].formula: task {task.name} is satisfied at the start, before any action"
        if found.cost is None:
            result = "it can only be relaxed or skipped" if found.achievable else "so that no plan exists"
            yield f"tasks[{i}].formula: task {task.name} cannot be satisfied, not even alone; {result}"
    for (i, one), (k, other) in combinations(enumerate(problem.automata), 2):
        alike = one.size == other.size and one.accepting == other.accepting
        if alike and all(map(same, one.transitions, other.transitions)):
            names = problem.names
            yield f"tasks[{k}].formula: task {names[k]} asks for the same as task {names[i]}"


def _mentions(i: int, task: Task) -> Iterator[tuple[str, str]]:
    """Yield every proposition that a task mentions, sorted, with the key of the mention."""
    for name in sorted(propositions_of(parse(task.formula))):
        yield f"tasks[{i}].formula", name
    for k, relaxation in enumerate(task.relax):
        for name in sorted(propositions_of(parse(relaxation.when))):
            yield f"tasks[{i}].relax[{k}].when", name
