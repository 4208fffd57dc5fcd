"""Rehearsals: actions tried out as in a run, but without physics and with objects arranged for them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

from prefplan.errors import ModelError
from prefplan.models.manipulation.model import ManipulationModel
from sim.capability.arrangement import Places, positions, staged
from sim.errors import BlockedError, SimulationError
from sim.simulation.kinematic_cell import KinematicCell
from sim.skills.catalogue import perform
from sim.skills.skill import Skill
from sim.world.places import under
from sim.world.scene import Scene

TAKEN = 2
"""Number of actions after which an object has been grasped where it is."""

BROUGHT = 4
"""Number of actions after which an object has been put down elsewhere."""


@dataclass(frozen=True)
class Rehearsal:
    """A sequence of actions with one object, from the arm's home pose.

    Attributes:
        actions: as in plans, such as `transport blue san`.
        places: locations of the objects; others are left out.
        obj: the object to grasp.
        location: where it is put down.
        via: location over which the hand is brought first; none if empty.
    """

    actions: tuple[str, ...]
    places: Places
    obj: str
    location: str
    via: str = ""

    def beginning(self, count: int) -> Rehearsal:
        """Return the rehearsal of the first actions alone."""
        return replace(self, actions=self.actions[:count])

    def alone(self, model: ManipulationModel) -> Rehearsal:
        """Return the rehearsal without the movable objects that carry its own neither at first nor at the end."""
        others = dispensable(self, model)
        return replace(self, places={name: place for name, place in self.places.items() if name not in others})

    def arrange(self, cell: KinematicCell, scene: Scene) -> None:
        """Put the objects in a cell of a scene where they are before the first action.

        Raises:
            ModelError: the model does not allow these places.
        """
        arrangement = staged(scene, self.places)
        cell.begin(arrangement, positions(scene, arrangement))

    def run(self, cell: KinematicCell, scene: Scene, skills: Mapping[str, Skill]) -> tuple[int, SimulationError | None]:
        """Return how many actions succeed in a cell of a scene, and the error of the next one, or None.

        Raises:
            ModelError: the model does not allow these places.
        """
        self.arrange(cell, scene)
        for done, action in enumerate(self.actions):
            try:
                if self.via and not done:
                    perform(cell, f"transit {self.via}", skills)
                perform(cell, action, skills, ahead=self.actions[done + 1 :])
            except SimulationError as error:
                return done, error
        return len(self.actions), None


def putting_back(obj: str, location: str, places: Places) -> Rehearsal:
    """Return the rehearsal that grasps an object at a location and puts it back there."""
    return Rehearsal((f"transit {location}", f"grasp {obj}", f"release {obj} {location}"), places, obj, location)


def bringing(obj: str, origin: str, location: str, places: Places) -> Rehearsal:
    """Return the rehearsal that brings an object from one location to another and grasps it again there."""
    take = f"grasp {obj}"
    actions = f"transit {origin}", take, f"transport {obj} {location}", f"release {obj} {location}", take
    return Rehearsal(actions, {**places, obj: origin}, obj, location)


def dispensable(rehearsal: Rehearsal, model: ManipulationModel) -> list[str]:
    """Return the movable objects in a rehearsal other than its own and those that carry it."""
    carriers = {*under(model, rehearsal.location), *under(model, rehearsal.places[rehearsal.obj])}
    others = model.movable - {rehearsal.obj}
    return [other for other, place in rehearsal.places.items() if other in others and place not in carriers]


def culprits(failing: Rehearsal, cell: KinematicCell, scene: Scene, skills: Mapping[str, Skill]) -> list[str] | None:
    """Return movable objects because of which a rehearsal fails, while without any one of them it would succeed.

    The list is empty if it fails even without all of them; None if it succeeds.

    They are found by a deletion filter (J. W. Chinneck and E. W. Dravnieks, "Locating minimal infeasible constraint
    sets in linear programs", 1991).
    """
    error = failing.run(cell, scene, skills)[1]
    if error is None:
        return None

    def fails(left_out: Collection[str]) -> bool | None:
        """Return whether it fails without some objects, and leave them out if it does; None if others rest on them."""
        nonlocal failing
        places = {name: place for name, place in failing.places.items() if name not in left_out}
        fewer = replace(failing, places=places)
        with suppress(ModelError):  # others rest on them
            found = fewer.run(cell, scene, skills)[1] is not None
            failing = fewer if found else failing
            return found
        return None

    others = dispensable(failing, scene.model)
    suspects = [other for other in others if isinstance(error, BlockedError) and other in error.by]
    # Most often, no other object is a culprit.
    if suspects and fails({*others} - {*suspects}):
        others = suspects
    return [other for other in others if fails([other]) is False]


def unable_to_begin(scene: Scene, error: SimulationError) -> str:
    """Return the message that the hand cannot reach its start location, and why."""
    return f"model.start: the hand cannot begin over {scene.model.start!r}: {error}"
