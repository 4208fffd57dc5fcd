"""Answers to what the arm can do, cached on disk and shared by plans, checks, runs and replanning.

    problem = Problem(model, tasks, preference, feasible=Capability(model))

The key is a digest of all that an answer depends on: robot, places, objects, fixtures, and the sources that decide.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, replace
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from prefplan.models.feasibility import Transfer
from prefplan.models.manipulation.model import ManipulationModel
from sim.cache import add_line, cache_folder
from sim.capability.place_check import PlaceCheck
from sim.capability.sources import digest_of_sources

if TYPE_CHECKING:
    from sim.capability.feasibility import Feasibility
    from sim.world.scene import Scene

LIBRARIES = ("daqp", "mink", "mujoco", "numpy", "ompl", "scipy", "trimesh")
"""Libraries on which the answers depend."""


class Capability:
    """What a robot can do in the scene of a model; implements `prefplan.models.feasibility.Feasible`.

    The scene is built, and the modules for it are imported, only when an answer is needed that is not cached.
    """

    def __init__(self, model: ManipulationModel, *, robot: str | None = None, scene: Scene | None = None) -> None:
        """Take a scene.

        Args:
            model: the manipulation model.
            robot: one of `sim.robots.catalogue.ROBOTS`; None for the model's.
            scene: its scene with this robot; None to build it.
        """
        self._model, self._robot = model, robot
        if scene is not None:
            self.__dict__["scene"] = scene

    def __getstate__(self) -> dict[str, object]:
        """Return what is pickled: not the scene and the answers, which can be found again."""
        return {"_model": self._model, "_robot": self._robot}

    def check_start(self) -> str | None:
        """See `Feasibility.check_start`.

        Raises:
            SimulationError: the scene cannot be built.
        """
        return self._kept("start", lambda: PlaceCheck("", self._model.start, self._feasibility.check_start())).reason

    def check(self, obj: str, location: str) -> PlaceCheck:
        """Return what the arm can do with an object at a location; everything if the model does not allow it there.

        Raises:
            SimulationError: the scene cannot be built.
        """

        def answer() -> PlaceCheck:
            from sim.capability.arrangement import arranged

            allowed = self._knows(obj, location) and arranged(self._model, obj, location) is not None
            return self._feasibility.check(obj, location) if allowed else PlaceCheck(obj, location)

        return self._kept(f"{obj} at {location}", answer)

    def rehearse(self, transfer: Transfer) -> PlaceCheck | None:
        """Return what the arm cannot do of a transfer; None if it can, or an object is at no location of the scene.

        Raises:
            SimulationError: the scene cannot be built.
        """
        if not all(self._knows(*pair) for pair in ((transfer.obj, transfer.source), *transfer.others)):
            return None  # something was observed off every location

        done = PlaceCheck(transfer.obj, transfer.target)

        def answer() -> PlaceCheck:
            return self._feasibility.rehearse(transfer) or done

        words = [f"{obj} at {place}" for obj, place in transfer.others]
        found = self._kept(
            " ".join([f"{transfer.obj} from {transfer.source} to {transfer.target} beside", *words]), answer
        )
        if found == done:
            return None
        if found.take_unless or found.put_unless or found.crowded_by:
            return found
        # It fails whatever else stands around: perhaps every transfer there fails.
        grasped = found.location != transfer.source
        if (always := self.check(transfer.obj, found.location).among(transfer.others, grasped=grasped)) is not None:
            return always
        # It can be grasped, but not for this target.
        directly = PlaceCheck(transfer.obj, transfer.target, found.reason, not_from=transfer.source)
        return found if grasped or not transfer.target else directly

    def _knows(self, obj: str, location: str) -> bool:
        """Return whether an object and a location are in the scene."""
        return obj in self._model.initial_state.place and any(place.name == location for place in self._model.locations)

    def _kept(self, name: str, answer: Callable[[], PlaceCheck]) -> PlaceCheck:
        """Return the answer of a name; if it is not known yet, find it and cache it."""
        if name not in self._answers:
            self._answers[name] = answer()
            add_line(self._path, json.dumps([name, asdict(self._answers[name])]))
        return self._answers[name]

    @cached_property
    def scene(self) -> Scene:
        """The scene, built when it is first needed.

        Raises:
            SimulationError: it cannot be built.
        """
        from sim.world.scene import build_scene

        return build_scene(self._model, robot=self._robot)

    @cached_property
    def _feasibility(self) -> Feasibility:
        from sim.capability.feasibility import Feasibility

        return Feasibility(self.scene)

    @cached_property
    def _answers(self) -> dict[str, PlaceCheck]:
        lines, found = list[bytes](), dict[str, PlaceCheck]()
        with suppress(OSError):
            lines = self._path.read_bytes().splitlines()
        for line in lines:
            with suppress(ValueError, TypeError, KeyError):  # it was cut off
                name, each = json.loads(line)
                found[name] = _decoded(each)
        return found

    @cached_property
    def _path(self) -> Path:
        return cache_folder("capability") / f"{self._key}.jsonl"

    @cached_property
    def _key(self) -> str:
        """Digest of all that the answers depend on."""
        model, setup = self._model, self._model.robot_setup
        parts: list[object] = [
            *(self._robot, model.start, model.begin, model.fixtures, replace(setup, folder=Path())),
            *(replace(place, label=None) for place in model.locations),
            *(replace(obj, label=None, rgba=None) for obj in model.objects),
            *(f"{name} {version(name)}" for name in LIBRARIES),
            digest_of_sources(),
        ]
        if model.files:
            parts.append(self.scene.sha256)  # files may refer to others
        return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


def _decoded(each: dict[str, Any]) -> PlaceCheck:
    """Return the answer decoded from JSON."""
    unless = {key: tuple(map(tuple, each[key])) for key in ("take_unless", "put_unless", "crowded_by")}
    return PlaceCheck(**each | unless)
