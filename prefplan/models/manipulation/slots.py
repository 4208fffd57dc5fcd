"""Slots: the places of a location that holds several objects.

Plans do not choose slots, but the measured cost of an action depends on them; so only models with measured costs
distinguish them. The actions determine them: an object is put into the free slot farthest from the others there.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from prefplan.errors import ModelError
from prefplan.models.kernels import Integer

FAR_APART = 2
"""Slots at least this far from the nearest object, in slots, are equally good."""


def hand_poses(counts: Mapping[str, int], start: str) -> tuple[str, ...]:
    """Return every pose of the hand: over each location's middle, over its slots if it has several, and the start pose.

    `counts` are the numbers of slots by location; `start` is a location or any other word.
    """
    slots = [pose(name, i) for name, count in counts.items() if count > 1 for i in range(count)]
    return (*counts, *slots, *((start,) if start not in counts else ()))


def pose(location: str, slot: int | None) -> str:
    """Return the name of the hand's pose over a slot; None for the only slot, or for the middle of several."""
    return location if slot is None else f"{location}[{slot}]"


def location_of(pose: str) -> str:
    """Return the location, or the start pose, that the hand is over in a pose."""
    return pose.partition("[")[0]


def free_slot(taken: Sequence[int] | np.ndarray, first: Integer, end: Integer) -> Integer:
    """Return the slot into which an object is put: the free one farthest from those taken, the first of several.

    The location has the slots from `first` to below `end`, at least one of them free; `taken` may include others.
    """
    best, farthest = first, 0
    if end - first == 1:
        return best
    for slot in range(first, end):
        nearest = FAR_APART
        for other in taken:
            if first <= other < end:
                nearest = min(nearest, abs(slot - other))
        if nearest > farthest:
            best, farthest = slot, nearest
    return best


def slots_at_start(
    places: Sequence[tuple[str, str]], given: Mapping[str, int], capacities: Mapping[str, int]
) -> dict[str, int]:
    """Return the slot of every object at the start: its given slot, else the first free one, in the objects' order.

    Each object is given with the location where it rests, each location with its number of slots.

    Raises:
        ModelError: there are too many objects at a location.
    """
    slots = dict(given)
    taken = {(place, given[obj]) for obj, place in places if obj in given}
    for obj, place in places:
        if obj in slots:
            continue
        slot = next((i for i in range(capacities[place]) if (place, i) not in taken), None)
        if slot is None:
            raise ModelError(f"start: no room for {obj!r} at {place!r}, which has room for {capacities[place]}")
        slots[obj] = slot
        taken.add((place, slot))
    return slots
