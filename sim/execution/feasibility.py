"""What the arm can do before anything runs: each object at each location, tried out by the skills of a run."""

from __future__ import annotations

from dataclasses import dataclass

from prefplan.errors import ModelError
from sim.errors import BlockedError, SimulationError
from sim.execution.arrangement import arranged
from sim.execution.refusal import Remedies
from sim.execution.rehearsal import Rehearsal
from sim.simulation.kinematic_cell import KinematicCell
from sim.world.scene import Scene, initial_state


@dataclass(frozen=True)
class PlaceCheck:
    """Whether an object can be taken at a location and put there.

    Attributes:
        obj: name of the object.
        location: name of the location.
        reason: why it cannot, or why it cannot be brought there from where it starts; None if it can.
        usable: whether it can be taken and put there once it is there, or once others were moved away.
    """

    obj: str
    location: str
    reason: str | None
    usable: bool


class ArmCheck:
    """Tells what the arm can do in a scene, as it starts."""

    def __init__(self, scene: Scene) -> None:
        """Take a scene."""
        self._scene = scene
        self._cell = KinematicCell(scene, initial_state(scene))
        self._remedies = Remedies(scene, self._cell)

    def check(self, obj: str, location: str) -> PlaceCheck:
        """Return whether an object can be brought to a location, put there and taken again; the model must allow that.

        Others are where they start; what lies on it, or where it is to be, is left out.
        """
        places = arranged(self._scene.model, obj, location)
        assert places is not None
        start = self._scene.model.initial_state.place[obj]
        there = f"grasp {obj}", f"release {obj} {location}"
        refusal: SimulationError | None = None
        if start != location:
            bringing = f"transit {start}", there[0], f"transport {obj} {location}", there[1]
            try:
                Rehearsal((*bringing, *there), {**places, obj: start}, obj, location)(self._cell, self._scene)
                return PlaceCheck(obj, location, None, usable=True)
            except ModelError:
                pass  # what it lies on at the start is to carry it there
            except SimulationError as error:
                refusal = error
        staying = Rehearsal((f"transit {location}", *there), places, obj, location)
        try:
            staying(self._cell, self._scene)
        except SimulationError as error:
            return PlaceCheck(obj, location, self._remedies.reason(staying, error), usable=self._may_change(error))
        return PlaceCheck(obj, location, f"from {start}: {refusal}" if refusal else None, usable=True)

    def _may_change(self, error: SimulationError) -> bool:
        """Return whether an object is in the way that a plan may put elsewhere first."""
        movable = {other.name for other in self._scene.model.objects if not other.fixed}
        return isinstance(error, BlockedError) and not movable.isdisjoint(error.by)
