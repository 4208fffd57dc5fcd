"""Checks of what the arm can do in a scenario's scene before anything runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

from experiments.cli.progress import Tell
from experiments.cli.start import loading
from prefplan.errors import LimitError
from prefplan.front import UnfinishedError
from prefplan.limits import Limits, check_limits, interruptible
from prefplan.models.manipulation.action import at
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.system import Barred, System
from prefplan.problem import Problem, Task
from prefplan.scenario.decode import Scenario

if TYPE_CHECKING:
    from sim.capability.feasibility import PlaceCheck

Achievable = Callable[[System, Task], bool]
"""Returns whether a task alone can be satisfied in a system, or else relaxed or skipped.

Raises `UnfinishedError` or `LimitError` if a limit was reached first.
"""


@dataclass(frozen=True)
class SceneCheck:
    """What the arm can do in a scene.

    Attributes:
        faults: why the arm cannot work there at all, each a sentence that begins with the key; None if unknown.
        warnings: likely mistakes, each a sentence that begins with the key.
        places: what the arm can do with each object at each location; None if that was not checked.
        complete: whether no limit ended the checks.
    """

    faults: tuple[str, ...] | None = None
    warnings: tuple[str, ...] = ()
    places: tuple[PlaceCheck, ...] | None = None
    complete: bool = True


def load_simulation(scenario: Scenario) -> None:
    """Load what `check_arm` needs, before any result is known: Ctrl-C during that second ends the process."""
    if _arm_model(scenario) is not None:
        with loading():
            import sim.capability.feasibility  # noqa: F401


def _arm_model(scenario: Scenario) -> ManipulationModel | None:
    """Return the model of a scenario if an arm can be simulated in it."""
    model = scenario.model
    return model if isinstance(model, ManipulationModel) and find_spec("mujoco") is not None else None


def check_arm(scenario: Scenario, limits: Limits, *, robot: str | None, quick: bool, tell: Tell) -> SceneCheck:
    """Check what the arm can do in a scenario's scene.

    Arguments are those of `checkup.check`; what is not known when a limit is reached stays unknown.

    Raises:
        RobotError: the robot is unknown or cannot be loaded.
    """
    model = _arm_model(scenario)
    if model is None:
        return SceneCheck()
    with loading():
        from sim.capability.arrangement import allowed_places
        from sim.capability.feasibility import Feasibility
        from sim.errors import SimulationError
        from sim.world.scene import build_scene

    try:
        with interruptible(limits):
            check_limits()
            scene = build_scene(model, robot=robot)
    except LimitError:
        return SceneCheck(complete=False)
    except SimulationError as error:
        return SceneCheck(tuple(f"model.{fault}" for fault in error.faults))
    warnings = tuple(f"model.{warning}" for warning in scene.warnings)
    places: list[PlaceCheck] | None = None
    try:
        with interruptible(limits):
            arm = Feasibility(scene)
            if (fault := arm.check_start()) is not None:
                return SceneCheck((fault,), warnings)
            if quick:
                return SceneCheck((), warnings)
            places, pairs = [], list(allowed_places(scene.model))
            for done, (obj, location) in enumerate(pairs):
                check_limits()
                tell("arm", done, len(pairs), f"{obj} at {location}")
                places.append(arm.check(obj, location))
    except LimitError:
        if places is None:
            return SceneCheck(None, warnings, complete=False)
        return SceneCheck((), warnings, tuple(places), complete=False)
    return SceneCheck((), warnings, tuple(places))


def tasks_out_of_reach(
    problem: Problem, wanted: Sequence[bool], places: Sequence[PlaceCheck], achievable: Achievable
) -> Iterator[str]:
    """Yield a fault, which begins with the key, for each task that is impossible because of what the arm cannot do.

    `wanted` says for each task whether it could be achieved by an arm that can do everything.
    """
    unusable = [found for found in places if not (found.take and found.put)]
    if not unusable:
        return
    for i, task in enumerate(problem.tasks):
        if not wanted[i] or _achievable_without(problem, task, unusable, achievable):
            continue
        needed: list[PlaceCheck] = []
        spared: list[PlaceCheck] = []
        for found in unusable:
            if _achievable_without(problem, task, [*spared, found], achievable):
                spared.append(found)
            else:
                needed.append(found)
        what = " and ".join(f"{found.obj} at {found.location} ({found.reason})" for found in needed)
        yield f"tasks[{i}].formula: task {task.name} needs what the arm cannot do: {what}"


def _achievable_without(problem: Problem, task: Task, unusable: Sequence[PlaceCheck], achievable: Achievable) -> bool:
    """Return whether a task can be achieved without the actions that the arm cannot do; True if a limit was reached."""
    barred: Barred = [
        entry
        for found in unusable
        for possible, entry in (
            (found.take, (frozenset({at(found.obj, found.location)}), f"grasp {found.obj}")),
            (found.put, (frozenset[str](), f"release {found.obj} {found.location}")),
        )
        if not possible
    ]
    try:
        return achievable(problem.system.without(barred), task)
    except (UnfinishedError, LimitError):
        return True
