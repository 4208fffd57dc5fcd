"""Arrangements in which nothing lies on one object at a location, as similar to the start as the model allows."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from prefplan.models.manipulation.model import ManipulationModel, ManipulationState
from prefplan.models.manipulation.slots import free_slot, slots_at_start
from sim.world.places import under
from sim.world.scene import Scene, initial_state

AWAY_M = np.array([50.0, 50.0, -10.0])
"""(3,) position of objects that are left out, m."""

Places = dict[str, str]
"""Locations of objects by their names, in the model's order; objects that are left out have none."""


def allowed_places(model: ManipulationModel) -> Iterator[tuple[str, str]]:
    """Yield each movable object and location for which `arranged` finds an arrangement."""
    for obj in model.objects:
        for place in model.locations:
            if not obj.fixed and arranged(model, obj.name, place.name) is not None:
                yield obj.name, place.name


def arranged(model: ManipulationModel, obj: str, location: str) -> Places | None:
    """Return places with one object at a location and nothing on it; the others are at their starts if possible.

    Objects that would lie on it or take its place are left out. If the location rests on empty locations, movable
    objects are put there. None if fixed objects, or too few movable ones, make this impossible.
    """
    start = model.initial_state.place
    places = {other: place for other, place in start.items() if other != obj}
    fixed = {other.name for other in model.objects if other.fixed}
    over = {place.name for place in model.locations if location in under(model, place.name)}
    there = [other for other in places if places[other] == location and other not in fixed]
    vacant = model.location(location).capacity - sum(places[other] == location for other in places)
    left_out = [*there[: max(0, 1 - vacant)], *(other for other in places if places[other] in over)]
    if vacant + len(there) < 1:
        return None
    carriers = [*reversed(under(model, location)), location]
    places = _supported(model, {other: place for other, place in places.items() if other not in left_out})
    for support in carriers[:-1]:
        if support not in places.values():
            stand_in = _stand_in(model, places, obj, carriers)
            if stand_in is None:
                return None
            places[stand_in] = support
    places[obj] = location
    if fixed - places.keys():
        return None
    return {other.name: places[other.name] for other in model.objects if other.name in places}


def vacated(model: ManipulationModel, places: Places, location: str) -> Places:
    """Return the places without the movable objects at a location, and without what rests on them."""
    movable = model.movable
    return _supported(model, {obj: place for obj, place in places.items() if place != location or obj not in movable})


def _supported(model: ManipulationModel, places: Places) -> Places:
    """Return the places without objects whose supports are missing."""
    resting = {
        obj: place
        for obj, place in places.items()
        if all(support in places.values() for support in model.location(place).on)
    }
    return places if len(resting) == len(places) else _supported(model, resting)


def _stand_in(model: ManipulationModel, places: Places, obj: str, kept: list[str]) -> str | None:
    """Return a movable object to put below another: preferably one that is left out, else one that carries nothing."""
    start = model.initial_state.place
    carrying = {support for place in places.values() for support in model.location(place).on}
    below = under(model, start[obj])
    free = [
        other.name
        for other in reversed(model.objects)
        if other.name != obj and not other.fixed and places.get(other.name) not in {*carrying, *kept}
    ]
    return min(free, key=lambda name: (name in places, start[name] in below), default=None)


def staged(scene: Scene, places: Places) -> Scene:
    """Return a scene with the objects in `places` alone; those at their start location keep their slots.

    Raises:
        ModelError: the model does not allow these places.
    """
    model = scene.model
    first = model.initial_state
    known = {place.name: place.capacity for place in model.locations}
    before = slots_at_start(first.places, dict(first.slots), known)
    slots = {obj: before[obj] for obj, place in places.items() if first.place.get(obj) == place}
    for obj, place in places.items():
        if obj not in slots:
            taken = [slots[other] for other, there in places.items() if there == place and other in slots]
            slots[obj] = int(free_slot(taken, 0, known[place]))
    found = beginning(scene, places, slots)
    replace(found.model, begin=None)  # raises ModelError for objects without their supports
    return found


def beginning(scene: Scene, places: Places, slots: Mapping[str, int]) -> Scene:
    """Return a scene with the objects in `places` alone, each in a slot of its location, and an empty hand.

    `slots` has the index of the slot by object, for objects at locations with several slots.
    """
    model = scene.model
    objects = tuple(replace(obj, start=places[obj.name]) for obj in model.objects if obj.name in places)
    begin = ManipulationState(model.start, None, tuple(places.items()), slots=tuple(slots.items()))
    shapes = {name: shape for name, shape in scene.shapes.items() if name in {*places, *scene.spares}}
    return replace(scene, model=replace(model, objects=objects, begin=begin), shapes=shapes)


def positions(scene: Scene, arrangement: Scene) -> np.ndarray:
    """Return the (nq,) joint positions of a scene in which the objects are arranged, and the others far away."""
    data = initial_state(arrangement)
    for obj in scene.shapes.keys() - arrangement.shapes.keys():
        data.joint(obj).qpos[:3] = AWAY_M
    return data.qpos
