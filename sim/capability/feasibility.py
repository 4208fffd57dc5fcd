"""What the arm can do: each object at each location is tried out with the skills of a run, but without physics.

feasibility = Feasibility(build_scene(model))
answer = feasibility.check("blue", "bin")       # answer.reason: "out of reach by 5 cm", or None if all can be done
system.without(answer.barred)                   # the model without what the arm cannot do
"""

import itertools
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from prefplan.errors import ModelError
from sim.capability.arrangement import Places, arranged, vacated
from sim.capability.diagnosis import FailureDiagnosis
from sim.capability.place_check import Neighbours, PlaceCheck
from sim.capability.rehearsal import BROUGHT, TAKEN, Rehearsal, bringing, culprits, unable_to_begin
from sim.errors import BlockedError, SimulationError
from sim.perception.sensors import ObjectPose
from sim.simulation.kinematic_cell import KinematicCell
from sim.skills.catalogue import SKILLS
from sim.skills.grasp_choice import is_placeable
from sim.skills.placing import lacking_room
from sim.skills.skill import Skill, SkillError
from sim.world.places import under
from sim.world.scene import Scene, initial_state
from sim.world.shapes import about_z

PLACED_M = 0.001
"""Usual error of an object's position at a location, m: what is too close by less may fit."""

MORE_ORIGINS = 2
"""Number of near locations from which an object is brought, or the hand comes, before that is said to be impossible.

An object that can be put back where it is grasped is brought from all others: some grasps do.
"""


@dataclass(frozen=True)
class Attempt:
    """How a rehearsal went.

    Attributes:
        rehearsal: what was tried; if it fails for good, without the objects that could be in the way.
        done: how many of its actions succeeded.
        error: of the next one; None if all succeeded.
        for_good: whether it fails whatever other objects are moved away.
        succeeds_alone: whether all of it succeeds without these.
    """

    rehearsal: Rehearsal
    done: int
    error: SimulationError | None = None
    for_good: bool = False
    succeeds_alone: bool = False


class Feasibility:
    """Finds what the arm can do in a scene with the objects at their starts."""

    def __init__(self, scene: Scene, skills: Mapping[str, Skill] = SKILLS) -> None:
        """Check the arm in a scene, with skills by kind of action."""
        self._immovable: dict[str, Attempt] = {}  # how bringing an object went that cannot be grasped at its start
        self._movable = scene.model.movable
        self._scene, self._skills = scene, skills
        self._cell = KinematicCell(scene, initial_state(scene))
        self._diagnosis = FailureDiagnosis(scene, self._cell, skills)

    def check_start(self) -> str | None:
        """Return why the hand cannot reach its start location; None if it can, or does not start at a location."""
        start, model = self._scene.model.start, self._scene.model
        if start not in self._scene.slots:
            return None
        _, error = self._run(Rehearsal((f"transit {start}",), dict(model.initial_state.place), "", start))
        return None if error is None else unable_to_begin(self._scene, error)

    def check(self, obj: str, location: str) -> PlaceCheck:
        """Return whether an object can be brought to a location, put down and grasped again; the model must allow it.

        Other objects are at their starts, those on it or in its place left out; wherever they are, `crowded_by` tells
        beside which of them there is no room.
        """
        found = self._check(obj, location)
        return replace(found, crowded_by=self._crowding(obj, location)) if found.put else found

    def brings(self, obj: str, source: str, location: str) -> bool:
        """Return whether an object can be brought from one location to another, without the others."""
        model = self._scene.model
        with suppress(ModelError):  # the model does not allow it anyway
            if (places := arranged(model, obj, location)) is not None:
                rehearsal = bringing(obj, source, location, vacated(model, places, source)).beginning(BROUGHT)
                return self._run(rehearsal.alone(model))[1] is None
        return True

    def _check(self, obj: str, location: str) -> PlaceCheck:
        """Return what `check` does, without what other objects crowd."""
        places = arranged(self._scene.model, obj, location)
        assert places is not None
        start = self._scene.model.initial_state.place[obj]
        actions = f"transit {location}", f"grasp {obj}", f"release {obj} {location}"
        staying = Rehearsal(actions, places, obj, location)
        placeable = start == location or self._is_placeable(staying)
        brought = self._brought(obj, location, places) if placeable else None
        if brought is not None and brought.error is None:
            return PlaceCheck(obj, location)
        stayed = self._stayed(staying)
        if not placeable and stayed.error is None:  # from elsewhere, the hand fits there after all
            placeable, brought = True, self._brought(obj, location, places)
        arrives = brought is not None and brought.done >= BROUGHT
        if stayed.done >= TAKEN and (arrives or (brought is None and stayed.error is None)):
            return PlaceCheck(obj, location)
        first = stayed if start == location else brought
        settled = arrives or not placeable
        origins = self._beside(location, start)[: None if stayed.error is None else MORE_ORIGINS]
        put, put_unless = (arrives, ()) if settled else self._bringable(obj, location, places, first, origins)
        indirect = put and not settled and brought is not None and brought.for_good and brought.done >= TAKEN
        place = partial(PlaceCheck, obj, location, not_from=start if indirect else "")
        if stayed.error is None:
            assert brought is not None
            reason = _while(f"from {start}: {brought.error}", put_unless)
            return place(reason, put=put, put_unless=put_unless)
        take = not stayed.for_good or (brought is not None and brought.succeeds_alone)
        unless = self._neighbours(stayed)
        if stayed.done >= TAKEN:
            reason = f"to put it there: {self._diagnosis.reason(stayed.rehearsal, stayed.error)}"
            return place(_while(reason, unless), put=put or take, put_unless=unless)
        reason = _while(self._diagnosis.reason(stayed.rehearsal.beginning(TAKEN), stayed.error), unless)
        return place(reason, take=take, put=put or take, take_unless=unless, put_unless=put_unless)

    def _brought(self, obj: str, location: str, places: Places) -> Attempt | None:
        """Attempt to bring an object from its start to a location; None if it starts there, or cannot be tried."""
        start = self._scene.model.initial_state.place[obj]
        if start == location:
            return None
        if obj not in self._immovable:
            with suppress(ModelError):  # its supports at the start may have to be its supports at the location
                brought = self._attempt(bringing(obj, start, location, places))
                if not brought.for_good or brought.done >= TAKEN:
                    return brought
                self._immovable[obj] = brought
        return self._immovable.get(obj)

    def _crowding(self, obj: str, location: str) -> Neighbours:
        """Return other objects, each with a location, beside which there is no room for an object at a location.

        Only locations of one slot that rest on no objects are compared: where else objects are is not known.
        """
        places = [place.name for place in self._scene.model.locations if place.capacity == 1 and not place.on]
        if location not in places:
            return ()
        slot, shapes = self._scene.slots[location][0], self._scene.shapes
        centre, found = slot.position + [0.0, 0.0, shapes[obj].half[2]], []
        for other, place in itertools.product(sorted(self._movable - {obj}), places):
            there, shape = self._scene.slots[place][0], shapes[other]
            pose = ObjectPose(shape, there.position + [0.0, 0.0, shape.half[2]], about_z(there.yaw))
            if place != location and (lacking_room(shapes[obj], centre, slot.yaw, pose) or 0.0) > PLACED_M:
                found.append((other, place))
        return tuple(found)

    def _is_placeable(self, staying: Rehearsal) -> bool:
        """Return whether the hand fits in some grasp where an object is put down, without those that do not carry it.

        A rehearsal takes far longer to find that out, and only for the grasps that are possible where it begins.
        """
        try:
            staying.alone(self._scene.model).arrange(self._cell, self._scene)
        except ModelError:  # fixed objects may rest on movable ones
            return True
        return is_placeable(self._cell, staying.obj, staying.location)

    def _stayed(self, staying: Rehearsal) -> Attempt:
        """Attempt to grasp an object where it is and to put it back; if the way there is blocked, from elsewhere, too.

        A grasp in which it cannot be put back counts as well.
        """
        stayed = self._attempt(staying)
        if not stayed.for_good:
            return stayed
        for via in self._beside(staying.location)[:MORE_ORIGINS] if isinstance(stayed.error, BlockedError) else ():
            if stayed.done:
                break
            other = self._attempt(replace(stayed.rehearsal, via=via))
            stayed = other if other.done or not other.for_good else stayed
        without_release = stayed.rehearsal.beginning(TAKEN)
        if stayed.done < TAKEN and not _is_at_goal(stayed.error) and self._run(without_release)[1] is None:
            return replace(stayed, done=TAKEN)
        return stayed

    def _bringable(
        self, obj: str, location: str, places: Places, first: Attempt | None, origins: Iterable[str]
    ) -> tuple[bool, Neighbours]:
        """Return whether an object may be brought to a location, and the objects that have to be moved away first.

        It may also be put down at one of several locations in between, without the objects there: where it starts,
        walls may leave only grasps that do not fit at the location. `first` is how it went from its start, if tried.
        """
        start = self._scene.model.initial_state.place[obj]
        if first is not None and first.done < TAKEN:
            return start != location, ()  # what cannot be grasped at its start is never brought anywhere
        may_change, model = first is not None and not first.for_good, self._scene.model
        for origin in origins:
            with suppress(ModelError):  # fixed objects may stand there
                rehearsal = bringing(obj, origin, location, vacated(model, places, origin))
                other = self._attempt(rehearsal if may_change else rehearsal.alone(model))
                if other.done >= BROUGHT or not (may_change or other.for_good):
                    return True, ()
        return may_change, self._neighbours(first) if first is not None else ()

    def _beside(self, location: str, *tried: str) -> list[str]:
        """Return the other locations that rest on no objects, apart from those that were tried, the nearest first."""
        slots, model = self._scene.slots, self._scene.model
        taken = {location, *under(model, location), *tried}
        others = [place.name for place in model.locations if place.name not in taken and not place.on]
        here = slots[location][0].position
        return sorted(others, key=lambda other: float(np.linalg.norm(slots[other][0].position - here)))

    def _neighbours(self, attempt: Attempt) -> Neighbours:
        """Return the movable objects because of which an attempt fails, each with its location.

        They leave no room for the fingers, or a rehearsal without any one of them does not fail. None where a location
        has several slots: then it is not known which of them the objects are in.
        """
        error, places, obj = attempt.error, attempt.rehearsal.places, attempt.rehearsal.obj
        if attempt.for_good or error is None:
            return ()
        by = error.by if isinstance(error, BlockedError) and error.at_goal else ()
        found = [other for other in by if other in self._movable and other in places]
        if not found:
            failing = attempt.rehearsal if attempt.done >= TAKEN else attempt.rehearsal.beginning(TAKEN)
            found = culprits(failing, self._cell, self._scene, self._skills) or []
        stations = (attempt.rehearsal.location, *(places[other] for other in found))
        alone = all(self._scene.model.location(place).capacity == 1 for place in stations)
        return tuple((other, places[other]) for other in found if other != obj) if alone else ()

    def _attempt(self, rehearsal: Rehearsal) -> Attempt:
        """Run a rehearsal; if it fails, then also without the movable objects that do not carry its own.

        If it fails there, too, and not because of what carries it, it fails for good; so it does without a trial if
        only what is fixed leaves no room for the fingers at the object. (Where it is put down, another grasp may do.)
        """
        done, error = self._run(rehearsal)
        if error is None:
            return Attempt(rehearsal, done, succeeds_alone=True)
        if done < TAKEN and _is_at_goal(error) and not self._depends_on_others(error, rehearsal.obj):
            return Attempt(rehearsal, done, error, for_good=True)
        alone, succeeds = rehearsal.alone(self._scene.model), False
        with suppress(ModelError):  # fixed objects may rest on movable ones
            went, left = (done, error) if alone == rehearsal else self._run(alone)
            if left is not None and not self._depends_on_others(left, rehearsal.obj):
                return Attempt(alone, went, left, for_good=True)
            succeeds = left is None
        return Attempt(rehearsal, done, error, succeeds_alone=succeeds)

    def _depends_on_others(self, error: SimulationError, obj: str) -> bool:
        """Return whether other movable objects are the cause of an error: one in the way, or those below an object."""
        if isinstance(error, BlockedError):
            return not self._movable.isdisjoint({*error.by} - {obj})
        return isinstance(error, SkillError)

    def _run(self, rehearsal: Rehearsal) -> tuple[int, SimulationError | None]:
        return rehearsal.run(self._cell, self._scene, self._skills)


def _while(reason: str, unless: Neighbours) -> str:
    """Return a reason with the objects that have to stand where they do, as far as it does not name them."""
    others = [f"{obj} is at {place}" for obj, place in unless if obj not in reason.replace(",", " ").split()]
    return f"{reason} while {' and '.join(others)}" if others else reason


def _is_at_goal(error: SimulationError | None) -> bool:
    """Return whether an error is about the fingers at their goal, wherever the hand comes from and goes next."""
    return isinstance(error, BlockedError) and error.at_goal
