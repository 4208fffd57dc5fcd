"""What the arm can do: each object at each location is tried out with the skills of a run, but without physics.

feasibility = Feasibility(build_scene(model))
answer = feasibility.check("blue", "bin")       # answer.reason: "out of reach by 5 cm", or None if all can be done
system.without(answer.barred)                   # the model without what the arm cannot do
"""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial

from prefplan.errors import ModelError
from prefplan.models.feasibility import Transfer
from sim.capability.arrangement import Places, arranged, vacated
from sim.capability.attempts import MORE_ORIGINS, Attempt, Attempts, is_at_goal, while_there
from sim.capability.diagnosis import FailureDiagnosis
from sim.capability.place_check import Neighbours, PlaceCheck
from sim.capability.rehearsal import BROUGHT, TAKEN, Rehearsal, bringing, putting_back, unable_to_begin
from sim.capability.transfers import Transfers
from sim.errors import BlockedError
from sim.skills.catalogue import SKILLS
from sim.skills.grasp_choice import is_placeable
from sim.skills.skill import Skill
from sim.world.scene import Scene


class Feasibility:
    """Finds what the arm can do in a scene with the objects at their starts."""

    def __init__(self, scene: Scene, skills: Mapping[str, Skill] = SKILLS) -> None:
        """Check the arm in a scene, with skills by kind of action."""
        # By object, the failed attempt to take it from its start; None if it can be grasped there, e.g. to be put back.
        self._immovable: dict[str, Attempt | None] = {}
        self._scene, self._attempts = scene, Attempts(scene, skills)
        self._diagnosis = FailureDiagnosis(scene, self._attempts.cell, skills)
        self._transfers = Transfers(self._attempts)

    def rehearse(self, transfer: Transfer) -> PlaceCheck | None:
        """See `Transfers.rehearse`."""
        return self._transfers.rehearse(transfer)

    def check_start(self) -> str | None:
        """Return why the hand cannot reach its start location; None if it can, or does not start at a location."""
        start, model = self._scene.model.start, self._scene.model
        if start not in self._scene.slots:
            return None
        _, error = self._attempts.run(Rehearsal((f"transit {start}",), dict(model.initial_state.place), "", start))
        return None if error is None else unable_to_begin(self._scene, error)

    def check(self, obj: str, location: str) -> PlaceCheck:
        """Return whether an object can be brought to a location, put down and grasped again; the model must allow it.

        Other objects are at their starts, without those on it or in its place. `crowded_by` has all objects and
        locations, not only their starts, beside which there is no room.
        """
        found = self._check(obj, location)
        return replace(found, crowded_by=self._attempts.crowding(obj, location)) if found.put else found

    def _check(self, obj: str, location: str) -> PlaceCheck:
        """Return the answer of `check`, without `crowded_by`."""
        places = arranged(self._scene.model, obj, location)
        assert places is not None
        start = self._scene.model.initial_state.place[obj]
        staying = putting_back(obj, location, places)
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
        origins = self._attempts.beside(location, start)[: None if stayed.error is None else MORE_ORIGINS]
        put, put_unless = (arrives, ()) if settled else self._bringable(obj, location, places, first, origins)
        movable = self._immovable.get(obj) is None
        indirect = put and not settled and movable and brought is not None and brought.for_good
        place = partial(PlaceCheck, obj, location, not_from=start if indirect else "")
        if stayed.error is None:
            assert brought is not None
            reason = while_there(f"from {start}: {brought.error}", put_unless)
            return place(reason, put=put, put_unless=put_unless)
        take = not stayed.for_good or (brought is not None and brought.succeeds_alone)
        unless = self._attempts.unsteady(stayed) or self._attempts.hindering(stayed)
        if stayed.done >= TAKEN:
            reason = f"to put it there: {self._diagnosis.reason(stayed.rehearsal, stayed.error)}"
            return place(while_there(reason, unless), put=put or take, put_unless=unless)
        reason = while_there(self._diagnosis.reason(stayed.rehearsal.beginning(TAKEN), stayed.error), unless)
        return place(reason, take=take, put=put or take, take_unless=unless, put_unless=put_unless)

    def _brought(self, obj: str, location: str, places: Places) -> Attempt | None:
        """Attempt to bring an object from its start to a location; None if it starts there, or cannot be tried."""
        start = self._scene.model.initial_state.place[obj]
        if start == location:
            return None
        if (immovable := self._immovable.get(obj)) is not None:
            return immovable
        with suppress(ModelError):  # its supports at the start may have to be its supports at the location
            brought = self._attempts.attempt(bringing(obj, start, location, places))
            if brought.for_good and brought.done < TAKEN and obj not in self._immovable:
                there = arranged(self._scene.model, obj, start)
                can_be_taken = there is not None and self._stayed(putting_back(obj, start, there)).done >= TAKEN
                self._immovable[obj] = None if can_be_taken else brought
            return brought
        return None

    def _is_placeable(self, staying: Rehearsal) -> bool:
        """Return whether the hand fits in some grasp where an object is put down, among carriers and fixed objects.

        A rehearsal takes far longer, and tries only the grasps that are possible where it begins.
        """
        try:
            staying.alone(self._scene.model).arrange(self._attempts.cell, self._scene)
        except ModelError:  # fixed objects may rest on movable ones
            return True
        return is_placeable(self._attempts.cell, staying.obj, staying.location)

    def _stayed(self, staying: Rehearsal) -> Attempt:
        """Attempt to grasp an object and to put it back; if the hand's way is blocked, come from other locations, too.

        A grasp after which the object cannot be put back counts as well: then `done` is `TAKEN`.
        """
        stayed = self._attempts.attempt(staying)
        if not stayed.for_good:
            return stayed
        for via in (
            self._attempts.beside(staying.location)[:MORE_ORIGINS] if isinstance(stayed.error, BlockedError) else ()
        ):
            if stayed.done:
                break
            other = self._attempts.attempt(replace(stayed.rehearsal, via=via))
            stayed = other if other.done or not other.for_good else stayed
        without_release = stayed.rehearsal.beginning(TAKEN)
        if stayed.done < TAKEN and not is_at_goal(stayed.error) and self._attempts.run(without_release)[1] is None:
            return replace(stayed, done=TAKEN)
        return stayed

    def _bringable(
        self, obj: str, location: str, places: Places, first: Attempt | None, origins: Iterable[str]
    ) -> tuple[bool, Neighbours]:
        """Return whether an object may be brought to a location, and the objects that have to be moved away first.

        It may also be put down in between at one of several `origins`, without the objects there: where it starts,
        walls may leave only grasps that do not fit at the location. `first` is the attempt from its start, if made.
        """
        start = self._scene.model.initial_state.place[obj]
        if first is not None and first.done < TAKEN:
            return start != location, ()  # what cannot be grasped at its start is never brought anywhere
        may_change, model = first is not None and not first.for_good, self._scene.model
        for origin in origins:
            with suppress(ModelError):  # fixed objects may stand there
                rehearsal = bringing(obj, origin, location, vacated(model, places, origin))
                other = self._attempts.attempt(rehearsal if may_change else rehearsal.alone(model))
                if other.done >= BROUGHT or not (may_change or other.for_good):
                    return True, ()
        return may_change, self._attempts.hindering(first) if first is not None else ()
