"""What the arm can do in a scene, within limits of time and memory."""

from collections.abc import Callable
from dataclasses import dataclass

from prefplan.errors import LimitError
from prefplan.limits import Limits, check_limits, interruptible
from sim.capability.answers import Capability
from sim.capability.arrangement import allowed_places
from sim.capability.place_check import PlaceCheck
from sim.errors import SimulationError
from sim.world.scene import Scene


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
    capability: Capability,
    limits: Limits,
    *,
    quick: bool = False,
    tell: Callable[[str, int, int, str], None] = lambda stage, done, total, what: None,
) -> SceneCheck:
    """Check what the arm can do in its scene; what is not known when a limit is reached stays unknown.

    Args:
        capability: the arm in its scene, which is built if it was not.
        limits: of time and memory; Ctrl-C ends the check, too.
        quick: whether to leave out what the arm can do with each object at each location.
        tell: called with the progress.

    Raises:
        RobotError: the robot is unknown or cannot be loaded.
    """
    scene: Scene | None = None
    warnings: tuple[str, ...] = ()
    places: tuple[PlaceCheck, ...] | None = None
    try:
        with interruptible(limits):
            check_limits()
            scene = capability.scene
            warnings = tuple(f"model.{warning}" for warning in scene.warnings)
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
