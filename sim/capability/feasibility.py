"""What the arm can do: each object at each location is tried out with the skills of a run, but without physics.

feasibility = Feasibility(build_scene(model))
feasibility.unavailable_because("grasp", "blue", "bin")        # "out of reach by 5 cm", or None if it can be done
system.without(feasibility.barred([("blue", "bin")]))          # the model without what the arm cannot do
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace

from prefplan.errors import ModelError
from prefplan.models.system import Barred
from sim.capability.arrangement import Places, arranged
from sim.capability.diagnosis import FailureDiagnosis
from sim.capability.place_check import Neighbours, PlaceCheck
from sim.capability.rehearsal import Rehearsal, unable_to_begin
from sim.errors import BlockedError, SimulationError
from sim.simulation.kinematic_cell import KinematicCell
from sim.skills.catalogue import SKILLS
from sim.skills.skill import Skill, SkillError
from sim.world.places import under
from sim.world.scene import Scene, initial_state

TAKEN, BROUGHT = 2, 4
"""Number of actions after which an object has been grasped where it is, and after which it has been put elsewhere."""

MORE_ORIGINS = 2
"""Number of free locations from which an object is brought to one before it is said to be impossible."""


class Feasibility:
    """Finds what the arm can do in a scene with the objects at their starts; each answer is found once."""

    def __init__(self, scene: Scene, skills: Mapping[str, Skill] = SKILLS) -> None:
        """Check the arm in a scene, with skills by kind of action."""
        self._known: dict[tuple[str, str], PlaceCheck] = {}
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

    def unavailable_because(self, kind: str, obj: str, location: str) -> str | None:
        """Return why the arm cannot do an action in any state in which the model allows it; None if it may do it.

        Args:
            kind: `grasp` or `release`; other kinds depend on where they begin, and are never said to be impossible.
            obj: a movable object.
            location: where it is grasped or released; the model must allow it there (`allowed_places`).
        """
        if kind not in ("grasp", "release"):
            return None
        found = self.check(obj, location)
        return None if (found.take if kind == "grasp" else found.put) else found.reason

    def barred(self, pairs: Iterable[tuple[str, str]]) -> Barred:
        """Return what the arm cannot do with pairs of an object and a location, as `System.without` takes it."""
        return [entry for obj, location in pairs for entry in self.check(obj, location).barred]

    def check(self, obj: str, location: str) -> PlaceCheck:
        """Return whether an object can be brought to a location, put down and grasped again; the model must allow it.

        Other objects are at their starts; those on it or in its place are left out.
        """
        if (obj, location) not in self._known:
            self._known[obj, location] = self._check(obj, location)
        return self._known[obj, location]

    def _check(self, obj: str, location: str) -> PlaceCheck:
        places = arranged(self._scene.model, obj, location)
        assert places is not None
        start = self._scene.model.initial_state.place[obj]
        bringing, brought, refused = _bringing(obj, start, location, places), 0, None
        if start != location:
            with suppress(ModelError):  # its supports at the start may have to be its supports at the location
                brought, refused = self._run(bringing)
                if refused is None:
                    return PlaceCheck(obj, location)
        staying = Rehearsal((f"transit {location}", f"grasp {obj}", f"release {obj} {location}"), places, obj, location)
        done, error = self._run(staying)
        if error is not None:
            staying, done, error = self._if_moved_away(staying, done, error)
        if brought >= BROUGHT and done >= TAKEN or error is None and refused is None:
            return PlaceCheck(obj, location)
        put, put_unless = (True, ()) if brought >= BROUGHT else self._bringable(bringing, brought, refused)
        if error is None:
            return PlaceCheck(obj, location, f"from {start}: {refused}", put=put, put_unless=put_unless)
        may_change, unless = self._may_change(error, obj), self._neighbours(staying, error)
        if done >= TAKEN:
            reason = f"to put it there: {self._diagnosis.reason(staying, error)}"
            return PlaceCheck(obj, location, reason, put=put or may_change, put_unless=unless)
        reason = self._diagnosis.reason(replace(staying, actions=staying.actions[:TAKEN]), error)
        exceptions = {"take_unless": unless, "put_unless": put_unless}
        return PlaceCheck(obj, location, reason, take=may_change, put=put or may_change, **exceptions)

    def _bringable(self, bringing: Rehearsal, done: int, error: SimulationError | None) -> tuple[bool, Neighbours]:
        """Return whether an object may be brought to a location other than in a rehearsal that began at its start.

        Other objects may be moved away first. Or it is put down at one of the first free locations in between: where
        it starts, walls may leave only grasps that do not fit at the location.

        Args:
            bringing: the rehearsal.
            done: how many of its actions succeeded.
            error: of the next one; None if it was not tried.

        Returns:
            Whether it may, and the objects that have to be moved away first.
        """
        obj, location, start = bringing.obj, bringing.location, bringing.places[bringing.obj]
        if error is not None:
            _, done, left = self._if_moved_away(bringing, done, error)
            if done < TAKEN or self._may_change(left, obj):
                return self._may_change(left, obj), self._neighbours(bringing, left) if done >= TAKEN else ()
        elif start == location:
            return False, ()
        taken = {location, start, *bringing.places.values()}
        free = [place.name for place in self._scene.model.locations if place.name not in taken and not place.on]
        for origin in free[:MORE_ORIGINS]:
            other = _bringing(obj, origin, location, bringing.places)
            done, error = self._run(other)
            if error is not None:
                _, done, error = self._if_moved_away(other, done, error)
            if error is None or done >= BROUGHT or self._may_change(error, obj):
                return True, ()
        return False, ()

    def _neighbours(self, refused: Rehearsal, error: SimulationError | None) -> Neighbours:
        """Return the movable objects that leave no room for the fingers in a rehearsal, each with its location.

        None where a location has several slots: then it is not known which of them the objects are in.
        """
        if not (isinstance(error, BlockedError) and error.at_goal and self._may_change(error, refused.obj)):
            return ()
        found = tuple((other, refused.places[other]) for other in error.by if other in refused.places)
        locations = (refused.location, *(place for _, place in found))
        alone = all(self._scene.model.location(place).capacity == 1 for place in locations)
        return found if alone else ()

    def _run(self, rehearsal: Rehearsal) -> tuple[int, SimulationError | None]:
        return rehearsal.run(self._cell, self._scene, self._skills)

    def _if_moved_away(
        self, rehearsal: Rehearsal, done: int, error: SimulationError
    ) -> tuple[Rehearsal, int, SimulationError]:
        """Return a failed rehearsal without movable objects in the way, the number of its actions done and its error.

        The supports of its object stay. If it succeeds without the others, the arguments are returned.
        """
        if not isinstance(error, BlockedError) or not self._may_change(error, rehearsal.obj):
            return rehearsal, done, error
        model = self._scene.model
        carriers = {*under(model, rehearsal.location), *under(model, rehearsal.places[rehearsal.obj])}
        kept = {other.name for other in model.objects if other.fixed} | {rehearsal.obj}
        places = {other: place for other, place in rehearsal.places.items() if other in kept or place in carriers}
        alone = replace(rehearsal, places=places)
        with suppress(ModelError):  # fixed objects may rest on movable ones
            went, left = self._run(alone)
            if left is not None and not self._may_change(left, rehearsal.obj):
                return alone, went, left
        return rehearsal, done, error

    def _may_change(self, error: SimulationError, obj: str) -> bool:
        """Return whether a plan could remove the cause of an error with an object by moving another one first."""
        movable = {other.name for other in self._scene.model.objects if not other.fixed} - {obj}
        # Here a SkillError means that the supports do not fit.
        return isinstance(error, SkillError) or (isinstance(error, BlockedError) and not movable.isdisjoint(error.by))


def _bringing(obj: str, origin: str, location: str, places: Places) -> Rehearsal:
    """Return the rehearsal that brings an object from one location to another and grasps it again there."""
    take = f"grasp {obj}"
    actions = f"transit {origin}", take, f"transport {obj} {location}", f"release {obj} {location}", take
    return Rehearsal(actions, {**places, obj: origin}, obj, location)
