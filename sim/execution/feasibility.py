"""What the arm can do before anything runs: each object at each location, tried out by the skills of a run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from prefplan.errors import ModelError
from prefplan.models.manipulation.model import ManipulationModel, ManipulationState
from prefplan.models.manipulation.slots import free_slot, slots_at_start
from sim.errors import BlockedError, SimulationError
from sim.simulation.kinematic_cell import KinematicCell
from sim.skills.catalogue import perform
from sim.world.scene import Scene, initial_state

AWAY_M = np.array([50.0, 50.0, -10.0])
"""Where objects are that are left out, m."""

Places = dict[str, str]
"""Locations of objects by their names, in the model's order; objects that are left out have none."""


@dataclass(frozen=True)
class PlaceCheck:
    """Whether an object can be taken at a location and put there.

    Attributes:
        obj: name of the object.
        location: name of the location.
        reason: why it cannot, or why it cannot be brought there from where it starts; None if it can.
        usable: whether it can be taken and put there once it is there.
    """

    obj: str
    location: str
    reason: str | None
    usable: bool


def allowed_places(model: ManipulationModel) -> Iterator[tuple[str, str]]:
    """Yield each object and location for which the model has states in which the one lies free at the other."""
    for obj in model.objects:
        for place in model.locations:
            if not obj.fixed and arranged(model, obj.name, place.name) is not None:
                yield obj.name, place.name


def arranged(model: ManipulationModel, obj: str, location: str) -> Places | None:
    """Return where objects are when one lies free at a location: the others where they start, as far as that goes.

    What lies on it, or would be at its place, is left out. Where locations must carry it, others are put there if none
    starts there. None if that cannot be: what is fixed keeps it from being there.
    """
    start = model.initial_state.place
    places = {other: place for other, place in start.items() if other != obj}
    fixed = {other.name for other in model.objects if other.fixed}
    over = _over(model, location)
    there = [other for other in places if places[other] == location and other not in fixed]
    room = model.location(location).capacity - sum(places[other] == location for other in places)
    left_out = [*there[: max(0, 1 - room)], *(other for other in places if places[other] in over)]
    if room + len(there) < 1:
        return None
    carriers = [*reversed(_under(model, location)), location]
    places = _supported(model, {other: place for other, place in places.items() if other not in left_out})
    for support in carriers[:-1]:
        if support not in places.values():
            stand_in = _stand_in(model, places, obj, carriers)
            if stand_in is None:
                return None
            places[stand_in] = support
    if fixed - {obj} - places.keys():
        return None
    return {
        other.name: {**places, obj: location}[other.name] for other in model.objects if other.name in {*places, obj}
    }


def _supported(model: ManipulationModel, places: Places) -> Places:
    """Return the places without those objects that would lie on nothing."""
    resting = {
        obj: place
        for obj, place in places.items()
        if all(support in places.values() for support in model.location(place).on)
    }
    return places if len(resting) == len(places) else _supported(model, resting)


def _over(model: ManipulationModel, location: str) -> set[str]:
    """Return the locations that lie on a location, and so on."""
    direct = {place.name for place in model.locations if location in place.on}
    return direct.union(*(_over(model, upper) for upper in direct))


def _under(model: ManipulationModel, location: str) -> list[str]:
    """Return the locations that a location lies on, and so on, the upper ones first."""
    direct = list(model.location(location).on)
    deeper = [lower for support in direct for lower in _under(model, support)]
    return list(dict.fromkeys([*direct, *deeper]))


def _stand_in(model: ManipulationModel, places: Places, obj: str, kept: list[str]) -> str | None:
    """Return an object that can be put below another one: one that is left out, or else nothing lies on."""
    start = model.initial_state.place
    carrying = {support for place in places.values() for support in model.location(place).on}
    below = _under(model, start[obj])
    free = [
        other.name
        for other in reversed(model.objects)
        if other.name != obj and not other.fixed and places.get(other.name) not in {*carrying, *kept}
    ]
    return min(free, key=lambda name: (name in places, start[name] in below), default=None)


class Rehearsal:
    """Tries out in a scene, without physics, what a run would do."""

    def __init__(self, scene: Scene) -> None:
        """Begin with the scene as it starts."""
        self.scene = scene
        self.cell = KinematicCell(scene, initial_state(scene))

    def check(self, obj: str, location: str) -> PlaceCheck:
        """Return whether an object can be taken at a location and put there, which the model allows."""
        places = arranged(self.scene.model, obj, location)
        assert places is not None
        start = self.scene.model.initial_state.place[obj]
        there = f"grasp {obj}", f"release {obj} {location}"
        brought = None
        if start != location and self._stage({**places, obj: start}):
            brought = self._tried(
                location, f"transit {start}", f"grasp {obj}", f"transport {obj} {location}", there[1], *there
            )
            if brought is None:
                return PlaceCheck(obj, location, None, usable=True)
        self._stage(places)
        error = self._tried(location, f"transit {location}", *there)
        if error is None:
            return PlaceCheck(obj, location, f"from {start}: {brought}" if brought else None, usable=True)
        return PlaceCheck(obj, location, str(error), usable=self._may_be_moved(error))

    def _may_be_moved(self, error: SimulationError) -> bool:
        """Return whether an object is in the way that a plan may put elsewhere first."""
        movable = {other.name for other in self.scene.model.objects if not other.fixed}
        return isinstance(error, BlockedError) and not movable.isdisjoint(error.by)

    def _tried(self, destination: str, *actions: str) -> SimulationError | None:
        """Return why actions cannot be carried out one after another; None if they can."""
        self.cell.destination = destination
        try:
            for action in actions:
                perform(self.cell, action)
        except SimulationError as error:
            return error
        return None

    def _stage(self, places: Places) -> bool:
        """Put objects where they are to be, and leave the others out; return whether they can be there."""
        try:
            scene = staged(self.scene, places)
        except ModelError:
            return False
        qpos = initial_state(scene).qpos.copy()
        for obj in self.scene.shapes.keys() - places.keys():
            first = int(self.scene.mujoco.joint(obj).qposadr[0])
            qpos[first : first + 3] = AWAY_M
        self.cell.begin(scene, qpos)
        return True


def staged(scene: Scene, places: Places) -> Scene:
    """Return a scene that has some of the objects alone, each where it is to be, in the slots where they start.

    Raises:
        ModelError: they cannot be there.
    """
    model = scene.model
    first = model.initial_state
    known = {place.name: place.capacity for place in model.locations}
    before = slots_at_start(first.places, dict(first.slots), known)
    slots = {obj: before[obj] for obj, place in places.items() if first.place[obj] == place}
    for obj, place in places.items():
        if obj not in slots:
            used = {slots[other] for other, there in places.items() if there == place and other in slots}
            taken = np.array([[i in used] for i in range(known[place])])
            slots[obj] = int(free_slot(taken)[0])
    objects = tuple(replace(obj, start=places[obj.name]) for obj in model.objects if obj.name in places)
    begin = ManipulationState(model.start, None, tuple(places.items()), slots=tuple(slots.items()))
    replace(model, objects=objects, begin=None)  # raises ModelError for what lies on nothing
    return replace(
        scene,
        model=replace(model, objects=objects, begin=begin),
        shapes={name: shape for name, shape in scene.shapes.items() if name in places},
    )
