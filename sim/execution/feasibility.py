"""What the arm can do before anything runs: each object at each location, tried out by the skills of a run."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace

from prefplan.errors import ModelError
from sim.errors import BlockedError, SimulationError
from sim.execution.arrangement import arranged
from sim.execution.refusal import Remedies
from sim.execution.rehearsal import Rehearsal, unable_to_begin
from sim.simulation.kinematic_cell import KinematicCell
from sim.skills.skill import SkillError
from sim.world.places import under
from sim.world.scene import Scene, initial_state

TAKEN, BROUGHT = 2, 4
"""Number of actions after which an object has been taken where it is, and after which it has been put elsewhere."""


@dataclass(frozen=True)
class PlaceCheck:
    """Whether an object can be taken at a location and put there.

    Attributes:
        obj: name of the object.
        location: name of the location.
        reason: why one of both cannot be done, or why it cannot be brought there from where it starts; None if all can.
        take: whether it can be taken there, perhaps after others were moved away.
        put: whether it can be put there, likewise.
    """

    obj: str
    location: str
    reason: str | None = None
    take: bool = True
    put: bool = True


class ArmCheck:
    """Tells what the arm can do in a scene, as it starts."""

    def __init__(self, scene: Scene) -> None:
        """Take a scene."""
        self._scene = scene
        self._cell = KinematicCell(scene, initial_state(scene))
        self._remedies = Remedies(scene, self._cell)

    def check_start(self) -> str | None:
        """Return why the hand cannot be over the location where it starts; None if it can, or starts elsewhere."""
        start, model = self._scene.model.start, self._scene.model
        if start not in self._scene.slots:
            return None
        _, error = self._run(Rehearsal((f"transit {start}",), dict(model.initial_state.place), "", start))
        return None if error is None else unable_to_begin(self._scene, error)

    def check(self, obj: str, location: str) -> PlaceCheck:
        """Return whether an object can be brought to a location, put there and taken again; the model must allow that.

        Others are where they start; what lies on it, or where it is to be, is left out.
        """
        places = arranged(self._scene.model, obj, location)
        assert places is not None
        start = self._scene.model.initial_state.place[obj]
        take, put = f"grasp {obj}", f"release {obj} {location}"
        brought, refused = 0, None
        if start != location:
            actions = f"transit {start}", take, f"transport {obj} {location}", put, take
            with suppress(ModelError):  # what it lies on at the start may be what carries it there
                brought, refused = self._run(Rehearsal(actions, {**places, obj: start}, obj, location))
                if refused is None:
                    return PlaceCheck(obj, location)
        staying = Rehearsal((f"transit {location}", take, put), places, obj, location)
        done, error = self._run(staying)
        if isinstance(error, BlockedError) and self._may_change(error):
            staying, done, error = self._if_moved_away(staying, done, error)
        if error is None:
            unbrought = f"from {start}: {refused}" if refused is not None and brought < BROUGHT else None
            return PlaceCheck(obj, location, unbrought)
        may_change = self._may_change(error)
        if done >= TAKEN:
            if brought >= BROUGHT:
                return PlaceCheck(obj, location)
            return PlaceCheck(obj, location, f"to put it there: {error}", put=may_change)
        reason = self._remedies.reason(replace(staying, actions=staying.actions[:TAKEN]), error)
        return PlaceCheck(obj, location, reason, take=may_change, put=may_change or brought >= BROUGHT)

    def _run(self, rehearsal: Rehearsal) -> tuple[int, SimulationError | None]:
        return rehearsal.run(self._cell, self._scene)

    def _if_moved_away(
        self, staying: Rehearsal, done: int, error: SimulationError
    ) -> tuple[Rehearsal, int, SimulationError]:
        """Return a refused rehearsal, how far it gets and what is in its way once no object is that may be elsewhere.

        What carries its object stays. Where nothing is left that keeps it from being done, it is the given one.
        """
        model = self._scene.model
        carriers = under(model, staying.location)
        kept = {other.name for other in model.objects if other.fixed} | {staying.obj}
        places = {other: place for other, place in staying.places.items() if other in kept or place in carriers}
        alone = replace(staying, places=places)
        with suppress(ModelError):  # what is fixed may lie on what can be moved
            went, left = self._run(alone)
            if left is not None and not self._may_change(left):
                return alone, went, left
        return staying, done, error

    def _may_change(self, error: SimulationError) -> bool:
        """Return whether an object is in the way that a plan may put elsewhere first."""
        movable = {other.name for other in self._scene.model.objects if not other.fixed}
        # What else keeps a skill from its effect here is that there is no room, or that supports do not suit.
        return isinstance(error, SkillError) or (isinstance(error, BlockedError) and not movable.isdisjoint(error.by))
