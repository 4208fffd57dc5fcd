"""Slots: where in a location with room for several an object lies, and the hand is.

Plans do not choose slots, but what an action takes of the arm depends on them. They are told apart where costs are
measured, and follow from what was done before: an object is put into the free slot farthest from the others there.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from prefplan.errors import ModelError

FAR_APART = 2
"""As many slots from the nearest object is as good as any farther."""


def hand_poses(names: Iterable[str], capacities: Iterable[int], start: str) -> tuple[str, ...]:
    """Return every pose of the hand: over each location's middle, over its slots if it has several, and at the start.

    Args:
        names: of the locations.
        capacities: how many slots each has.
        start: the hand's first pose, a location or any other word.
    """
    names = tuple(names)
    slots = [pose(name, i) for name, room in zip(names, capacities, strict=True) if room > 1 for i in range(room)]
    return (*names, *slots, *((start,) if start not in names else ()))


def pose(location: str, slot: int | None) -> str:
    """Return the name of the hand's pose over a slot; None for the only one, or the middle between several."""
    return location if slot is None else f"{location}[{slot}]"


def location_of(pose: str) -> str:
    """Return the location, or the start pose, that the hand is over in a pose."""
    return pose.partition("[")[0]


def free_slot(taken: np.ndarray) -> np.ndarray:
    """Return the slot into which an object is put: the free one farthest from those taken, the first of several.

    Args:
        taken: (K, N) bool, which of the K slots of a location, side by side, are taken in each of N states.

    Returns:
        (N,) their indices; of no meaning where all are taken.
    """
    indices = np.arange(len(taken))
    apart = np.minimum(np.abs(indices[:, None] - indices[None, :]), FAR_APART)
    nearest = np.where(taken[None, :, :], apart[:, :, None], FAR_APART).min(axis=1)
    return nearest.argmax(axis=0)


def slots_at_start(
    places: Sequence[tuple[str, str]], known: Mapping[str, int], room: Mapping[str, int]
) -> dict[str, int]:
    """Return the slot of every object at the start: the one it is known to lie in, else they fill them in order.

    Args:
        places: each object and the location where it rests.
        known: slots of some objects.
        room: how many slots each location has.

    Raises:
        ModelError: there are too many objects at a location.
    """
    found = dict(known)
    taken = {(place, known[obj]) for obj, place in places if obj in known}
    for obj, place in places:
        if obj in found:
            continue
        slot = next((i for i in range(room[place]) if (place, i) not in taken), None)
        if slot is None:
            raise ModelError(f"start: no room for {obj!r} at {place!r}, which has room for {room[place]}")
        found[obj] = slot
        taken.add((place, slot))
    return found
