"""Attempts: rehearsals with and without other movable objects, which show which of these are in the way."""

import itertools
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from prefplan.errors import ModelError
from sim.capability.place_check import Neighbours
from sim.capability.rehearsal import TAKEN, Rehearsal, culprits
from sim.errors import BlockedError, SimulationError
from sim.perception.sensors import ObjectPose
from sim.simulation.kinematic_cell import KinematicCell
from sim.skills.placing import lacking_room
from sim.skills.skill import Skill, SkillError
from sim.world.places import under
from sim.world.scene import Scene, initial_state
from sim.world.shapes import about_z

PLACED_M = 0.001
"""Usual error of an object's position at a location, m: an object that is too close by less than this may fit."""

MORE_ORIGINS = 2
"""Number of near locations tried as origins, of an object or of the hand, before an action counts as impossible.

An object that can be grasped at the location and put back there is brought from all others: some grasps fit.
"""


@dataclass(frozen=True)
class Attempt:
    """How a rehearsal went.

    Attributes:
        rehearsal: what was tried; without other movable objects if this second trial showed that it fails for good.
        done: how many of its actions succeeded.
        error: error of the next action; None if all succeeded.
        for_good: whether it fails whatever other objects are moved away.
        succeeds_alone: whether all its actions succeed with these objects moved away.
    """

    rehearsal: Rehearsal
    done: int
    error: SimulationError | None = None
    for_good: bool = False
    succeeds_alone: bool = False


class Attempts:
    """Attempts of the arm in a scene.

    Attributes:
        scene: the scene.
        cell: the workcell in which they are made.
        skills: skills by kind of action.
    """

    def __init__(self, scene: Scene, skills: Mapping[str, Skill]) -> None:
        """Take the scene and the skills."""
        self.scene, self.skills = scene, skills
        self.cell = KinematicCell(scene, initial_state(scene))
        self._movable = scene.model.movable

    def run(self, rehearsal: Rehearsal) -> tuple[int, SimulationError | None]:
        """See `Rehearsal.run`."""
        return rehearsal.run(self.cell, self.scene, self.skills)

    def attempt(self, rehearsal: Rehearsal) -> Attempt:
        """Run a rehearsal; if it fails, run it again without the movable objects that do not carry its own.

        If this fails, too, and not because of the carriers, it fails for good. The second run is left out if only fixed
        bodies leave no room for the fingers where the object is grasped. (Where it is put down, another grasp may fit.)
        """
        done, error = self.run(rehearsal)
        if error is None:
            return Attempt(rehearsal, done, succeeds_alone=True)
        if done < TAKEN and is_at_goal(error) and not self._depends_on_others(error, rehearsal.obj):
            return Attempt(rehearsal, done, error, for_good=True)
        alone, succeeds = rehearsal.alone(self.scene.model), False
        with suppress(ModelError):  # fixed objects may rest on movable ones
            went, left = (done, error) if alone == rehearsal else self.run(alone)
            if left is not None and not self._depends_on_others(left, rehearsal.obj):
                return Attempt(alone, went, left, for_good=True)
            succeeds = left is None
        return Attempt(rehearsal, done, error, succeeds_alone=succeeds)

    def _depends_on_others(self, error: SimulationError, obj: str) -> bool:
        """Return whether other movable objects are the cause of an error: one in the way, or those below an object."""
        if isinstance(error, BlockedError):
            return not self._movable.isdisjoint({*error.by} - {obj})
        return isinstance(error, SkillError)

    def hindering(self, attempt: Attempt) -> Neighbours:
        """Return the movable objects because of which an attempt fails, each with its location.

        They leave no room for the fingers, or the rehearsal succeeds without any one of them (`culprits`). Empty where
        a location has several slots: then it is not known in which of them the objects are.
        """
        error, places, obj = attempt.error, attempt.rehearsal.places, attempt.rehearsal.obj
        if attempt.for_good or error is None:
            return ()
        by = error.by if isinstance(error, BlockedError) and error.at_goal else ()
        found = [other for other in by if other in self._movable and other in places]
        if not found:
            failing = attempt.rehearsal if attempt.done >= TAKEN else attempt.rehearsal.beginning(TAKEN)
            found = culprits(failing, self.cell, self.scene, self.skills) or []
        stations = (attempt.rehearsal.location, *(places[other] for other in found))
        alone = all(self.scene.model.location(place).capacity == 1 for place in stations)
        return tuple((other, places[other]) for other in found if other != obj) if alone else ()

    def unsteady(self, attempt: Attempt) -> Neighbours:
        """Return the supports, each with its location, on which together the object of an attempt would not rest."""
        rehearsal, on = attempt.rehearsal, self.scene.model.location(attempt.rehearsal.location).on
        if attempt.done < TAKEN or not isinstance(attempt.error, SkillError):
            return ()
        return tuple(pair for pair in rehearsal.places.items() if pair[1] in on)

    def crowding(self, obj: str, location: str) -> Neighbours:
        """Return other objects, each with a location, beside which there is no room for an object at a location.

        Only locations of one slot that rest on no objects are compared: elsewhere, the objects' poses are not known.
        """
        places = [place.name for place in self.scene.model.locations if place.capacity == 1 and not place.on]
        if location not in places:
            return ()
        slot, shapes = self.scene.slots[location][0], self.scene.shapes
        centre, found = slot.position + [0.0, 0.0, shapes[obj].half[2]], []
        for other, place in itertools.product(sorted(self._movable - {obj}), places):
            there, shape = self.scene.slots[place][0], shapes[other]
            pose = ObjectPose(shape, there.position + [0.0, 0.0, shape.half[2]], about_z(there.yaw))
            if place != location and (lacking_room(shapes[obj], centre, slot.yaw, pose) or 0.0) > PLACED_M:
                found.append((other, place))
        return tuple(found)

    def beside(self, location: str, *tried: str) -> list[str]:
        """Return the other locations that rest on no objects, apart from those that were tried, the nearest first."""
        slots, model = self.scene.slots, self.scene.model
        taken = {location, *under(model, location), *tried}
        others = [place.name for place in model.locations if place.name not in taken and not place.on]
        here = slots[location][0].position
        return sorted(others, key=lambda other: float(np.linalg.norm(slots[other][0].position - here)))


def while_there(reason: str, unless: Neighbours) -> str:
    """Return a reason followed by the objects with their locations that it depends on and does not name itself."""
    others = [f"{obj} is at {place}" for obj, place in unless if obj not in reason.replace(",", " ").split()]
    return f"{reason} while {' and '.join(others)}" if others else reason


def is_at_goal(error: SimulationError | None) -> bool:
    """Return whether bodies block the fingers at their goal: the hand's way there and its next goal do not matter."""
    return isinstance(error, BlockedError) and error.at_goal
