"""What the arm can do in a scene, within limits of time and memory, and the tasks that need what it cannot do."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from prefplan.errors import LimitError
from prefplan.front import UnfinishedError
from prefplan.limits import Limits, check_limits, interruptible
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.symbolic import at
from prefplan.models.manipulation.system import ManipulationSystem
from prefplan.models.system import System
from prefplan.problem import Problem, Task
from sim.capability.answers import Capability
from sim.capability.arrangement import allowed_places
from sim.capability.place_check import PlaceCheck
from sim.errors import SimulationError
from sim.world.scene import build_scene

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


def check_scene(
    model: ManipulationModel,
    limits: Limits,
    *,
    robot: str | None = None,
    quick: bool = False,
    tell: Callable[[str, int, int, str], None] = lambda stage, done, total, what: None,
) -> SceneCheck:
    """Check what the arm can do in a model's scene; what is not known when a limit is reached stays unknown.

    Args:
        model: the manipulation model.
        limits: of time and memory; Ctrl-C ends them, too.
        robot: one of `sim.robots.catalogue.ROBOTS`; None for the model's.
        quick: whether to leave out what the arm can do with each object at each location.
        tell: called with the progress.

    Raises:
        RobotError: the robot is unknown or cannot be loaded.
    """
    scene = None
    warnings: tuple[str, ...] = ()
    places: tuple[PlaceCheck, ...] | None = None
    try:
        with interruptible(limits):
            check_limits()
            scene = build_scene(model, robot=robot)
            warnings = tuple(f"model.{warning}" for warning in scene.warnings)
            capability = Capability(model, robot=robot, scene=scene)
            if (fault := capability.check_start()) is not None:
                return SceneCheck((fault,), warnings)
            if quick:
                return SceneCheck((), warnings)
            places, pairs = (), list(allowed_places(scene.model))
            for done, (obj, location) in enumerate(pairs):
                check_limits()
                tell("arm", done, len(pairs), f"{obj} at {location}")
                places = (*places, capability.check(obj, location))
    except LimitError:
        return SceneCheck(None if places is None else (), warnings, places, complete=False)
    except SimulationError as error:
        if scene is not None:
            raise
        return SceneCheck(tuple(f"model.{fault}" for fault in error.faults))
    return SceneCheck((), warnings, places)


def tasks_out_of_reach(
    problem: Problem, wanted: Sequence[bool], places: Sequence[PlaceCheck], achievable: Achievable
) -> Iterator[str]:
    """Yield a fault, which begins with the key, for each task that is impossible because of what the arm cannot do.

    `wanted` says for each task whether it could be achieved by an arm that can do everything.
    """
    unusable = [found for found in places if found.barred]
    # What fails only while other objects stand somewhere tells all of them apart, which makes searches long.
    never = [found for found in unusable if not (found.take and found.put) or found.not_from]
    for i, task in enumerate(problem.tasks):
        if not unusable or not wanted[i]:
            continue
        groups = (group for group in (never, unusable) if not _achievable_without(problem, task, group, achievable))
        blamed = next(groups, None)
        if blamed is None:
            continue
        needed: list[PlaceCheck] = []
        spared: list[PlaceCheck] = []
        names = problem.weighted_automata[i].propositions
        # Of several that would do, what the task names is told.
        for found in sorted(blamed, key=lambda found: at(found.obj, found.location) in names):
            needs = not _achievable_without(problem, task, [*spared, found], achievable)
            (needed if needs else spared).append(found)
        what = " and ".join(f"{found.obj} at {found.location} ({found.words})" for found in needed)
        yield f"tasks[{i}].formula: task {task.name} needs what the arm cannot do: {what}"


def _achievable_without(problem: Problem, task: Task, unusable: Sequence[PlaceCheck], achievable: Achievable) -> bool:
    """Return whether a task can be achieved without the actions that the arm cannot do; True if a limit was reached."""
    barred = [entry for found in unusable for entry in found.barred]
    assert isinstance(problem.system, ManipulationSystem)
    try:
        return achievable(problem.system.without(barred), task)
    except (UnfinishedError, LimitError):
        return True
