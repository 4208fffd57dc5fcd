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
from sim.capability.arrangement import arranged
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
        take, put = f"grasp {obj}", f"release {obj} {location}"
        brought, refused = 0, None
        if start != location:
            actions = f"transit {start}", take, f"transport {obj} {location}", put, take
            with suppress(ModelError):  # its supports at the start may have to be its supports at the location
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
        if done >= TAKEN and brought >= BROUGHT:
            return PlaceCheck(obj, location)
        may_change, unless = self._may_change(error), self._neighbours(staying, error)
        if done >= TAKEN:
            reason = f"to put it there: {self._diagnosis.reason(staying, error)}"
            return PlaceCheck(obj, location, reason, put=may_change, put_unless=unless)
        return PlaceCheck(
            *(obj, location, self._diagnosis.reason(replace(staying, actions=staying.actions[:TAKEN]), error)),
            take=may_change,
            put=may_change or brought >= BROUGHT,
            take_unless=unless,
            put_unless=self._neighbours(staying, refused) if TAKEN <= brought < BROUGHT else (),
        )

    def _neighbours(self, refused: Rehearsal, error: SimulationError | None) -> Neighbours:
        """Return the movable objects that leave no room for the fingers in a rehearsal, each with its location.

        None where a location has several slots: then it is not known which of them the objects are in.
        """
        if not (isinstance(error, BlockedError) and error.at_goal and self._may_change(error)):
            return ()
        found = tuple((other, refused.places[other]) for other in error.by if other in refused.places)
        locations = (refused.location, *(place for _, place in found))
        alone = all(self._scene.model.location(place).capacity == 1 for place in locations)
        return found if alone else ()

    def _run(self, rehearsal: Rehearsal) -> tuple[int, SimulationError | None]:
        return rehearsal.run(self._cell, self._scene, self._skills)

    def _if_moved_away(
        self, staying: Rehearsal, done: int, error: SimulationError
    ) -> tuple[Rehearsal, int, SimulationError]:
        """Return a failed rehearsal without movable objects in the way, the number of its actions done and its error.

        The supports of its object stay. If it succeeds without the others, the arguments are returned.
        """
        model = self._scene.model
        carriers = under(model, staying.location)
        kept = {other.name for other in model.objects if other.fixed} | {staying.obj}
        places = {other: place for other, place in staying.places.items() if other in kept or place in carriers}
        alone = replace(staying, places=places)
        with suppress(ModelError):  # fixed objects may rest on movable ones
            went, left = self._run(alone)
            if left is not None and not self._may_change(left):
                return alone, went, left
        return staying, done, error

    def _may_change(self, error: SimulationError) -> bool:
        """Return whether a plan could remove the cause of an error by moving an object first."""
        movable = {other.name for other in self._scene.model.objects if not other.fixed}
        # Here a SkillError means that the supports do not fit.
        return isinstance(error, SkillError) or (isinstance(error, BlockedError) and not movable.isdisjoint(error.by))
