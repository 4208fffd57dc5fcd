"""Grounding: the symbolic state that observed poses imply, and how it differs from the predicted one."""

import itertools
from collections.abc import Iterable, Mapping, Sequence

import mujoco
import numpy as np

from prefplan.models.manipulation.model import ManipulationState
from sim.errors import in_metres
from sim.geometry.rectangle import overlap
from sim.perception.sensors import ObjectPose, Poses, on_table
from sim.world.places import AT_RADIUS_M, Slot, lowest_under
from sim.world.scene import Scene

AT_HEIGHT_M = 0.008
"""Greatest vertical distance of an object's underside from what it rests on, m."""

POINTING_M = 0.12
"""Distance ahead of the tool up to which the hand points, m."""

POINTING_SAMPLES = 7
"""Number of points ahead of the tool that are checked."""

NOWHERE = "no location"
"""The hand's location when the hand is over none; no location can have this name."""


def resting(scene: Scene, poses: Poses) -> dict[str, Slot]:
    """Return the slot of every object that rests in one.

    If a location has more objects than its capacity, only those nearest to their slots count. The scenario's locations
    come first: an object is at a temporary location only if it is at none of them.
    """
    found = {obj: slot for obj in poses if (slot := slot_of(scene, poses, obj)) is not None}

    def off(obj: str) -> float:
        return float(np.hypot(*(poses[obj].position - found[obj].position)[:2]))

    for place in scene.model.locations:
        there = sorted((obj for obj, slot in found.items() if slot.location == place.name), key=off)
        for obj in there[place.capacity :]:
            del found[obj]
    spots = {obj: slot_of(scene, poses, obj, temporary=True) for obj in poses if obj not in found}
    return found | {obj: slot for obj, slot in spots.items() if slot is not None}


def slot_of(scene: Scene, poses: Poses, name: str, *, temporary: bool = False) -> Slot | None:
    """Return the slot in which an object rests, whatever the location's capacity, or None.

    It rests there if it is upright, near the slot's centre, and its underside is level with the surface. At a location
    on top of others, the surface is the top of an object at one of these, and the centre is the middle of all objects
    there. Only the scenario's locations are considered, or with `temporary` only the temporary ones, where an object
    need not be upright.
    """
    pose = poses[name]
    if not pose.is_upright and not temporary:
        return None
    underside = pose.underside
    slots = [slot for place, row in scene.slots.items() if (place in scene.temporary) == temporary for slot in row]
    for slot in sorted(slots, key=lambda slot: float(np.linalg.norm(underside - slot.position))):
        supports = scene.model.location(slot.location).on
        centre, floors = slot.position[:2], [float(slot.position[2])] if temporary or not supports else []
        if np.hypot(*(underside[:2] - centre)) > 2 * AT_RADIUS_M:
            continue
        if supports:
            lower = [other for other, below in poses.items() if below.position[2] < pose.position[2]]
            under = _standing_on(scene, poses, lower, supports)
            floors += [poses[other].top for other in under.values()]
            if not temporary:
                centre = middle_of_supports(scene, poses, under, supports)
        near = bool(np.hypot(*(underside[:2] - centre)) < slot.radius)
        if near and any(abs(underside[2] - floor) < AT_HEIGHT_M for floor in floors):
            return slot
    return None


def middle_of_supports(scene: Scene, poses: Poses, under: Mapping[str, str], supports: Sequence[str]) -> np.ndarray:
    """Return the (2,) middle of locations that carry another, m: of the objects there, or of slots that are empty."""
    where = [poses[under[name]].position if name in under else scene.slots[name][0].position for name in supports]
    return np.asarray(np.mean(where, axis=0)[:2])


def carriers(poses: Poses, name: str) -> list[str]:
    """Return the objects that carry an object: its underside is level with their top, or below it if it leans."""
    pose = poses[name]
    bottom = pose.underside[2]
    found = []
    for other, below in poses.items():
        higher = pose.position[2] > below.position[2] + below.above / 2
        level = abs(bottom - below.top) < AT_HEIGHT_M
        level = level or (not pose.is_upright and higher and bottom < below.top)
        if other != name and level and overlap(pose.footprint, below.footprint):
            found.append(other)
    return found


def hand_over(scene: Scene, data: mujoco.MjData, location: str) -> bool:
    """Return whether the hand is over a location: over its row of slots or between two of them.

    A tilted hand is over what it points at within `POINTING_M`. The height of a pile there does not matter.
    """
    floor = scene.slots[lowest_under(scene.model, location)][0].position[2]
    tool, row = data.site(scene.robot.tool), scene.slots[location]
    first, last = row[0].position, row[-1].position
    along = (last - first)[:2]
    axis = tool.xpos + np.linspace(0, POINTING_M, POINTING_SAMPLES)[:, None] * tool.xmat.reshape(3, 3)[:, 2]
    offsets = (axis - first)[:, :2]
    shares = np.clip(offsets @ along / max(along @ along, 1e-12), 0.0, 1.0)
    near = np.hypot(*(offsets - shares[:, None] * along).T) < AT_RADIUS_M
    return bool(near.any() and tool.xpos[2] > floor)


def hand_location(scene: Scene, data: mujoco.MjData, candidates: Iterable[str]) -> str:
    """Return the first of several locations that the hand is over, or `NOWHERE`."""
    over = (name for name in candidates if name in scene.slots and hand_over(scene, data, name))
    return next(over, NOWHERE)


def observe(
    scene: Scene,
    data: mujoco.MjData,
    poses: Poses,
    *,
    hand: str,
    held: str | None,
    marks: frozenset[tuple[str, str]] = frozenset(),
) -> ManipulationState:
    """Return the observed symbolic state.

    An object that neither rests in a slot nor is held has no place in this state.

    Args:
        scene: of the execution.
        data: simulated state, of which only the robot's own configuration is used.
        poses: of every observed object of the model.
        hand: location to which the hand was last sent; another one is returned only if the hand is not there.
        held: the object that the pads hold, by their latest contact forces.
        marks: of the objects; no sensor observes them.
    """
    if hand in scene.slots and not (held and _is_over(scene, poses[held], hand)):
        hand = hand_location(scene, data, (hand, *scene.slots))
    slots = resting(scene, {name: pose for name, pose in poses.items() if name != held})
    places = tuple((obj.name, slots[obj.name].location) for obj in scene.model.objects if obj.name in slots)
    return ManipulationState(hand=hand, held=held, places=places, marks=present_marks(marks, poses))


def _is_over(scene: Scene, pose: ObjectPose, location: str) -> bool:
    """Return whether a held object is over a location; the hand need not be, if it holds the object off its middle."""
    return any(np.hypot(*(pose.position - slot.position)[:2]) < AT_RADIUS_M for slot in scene.slots[location])


def present_marks(marks: frozenset[tuple[str, str]], poses: Poses) -> frozenset[tuple[str, str]]:
    """Return the marks without those of objects that fell from the table."""
    return frozenset((obj, mark) for obj, mark in marks if obj not in poses or on_table(poses[obj]))


def mismatch(scene: Scene, poses: Poses, *, predicted: ManipulationState, observed: ManipulationState) -> str | None:
    """Return the first difference of an observed state from the predicted one, in words, or None.

    The places of objects are compared first, then the hand, the marks, and objects that are not in the model.
    """
    for obj in (known.name for known in scene.model.objects):
        expected, found = _where(predicted, obj), _where(observed, obj)
        if expected == found:
            continue
        if found is None:
            found = f"it lies off every location, at {in_metres(poses[obj].position, decimals=2)}"
        elif observed.held == obj:
            found = "it is in the hand"
        else:
            found = f"it rests {found}"
        return f"expected {obj} {expected}, but {found}"
    if predicted.hand != observed.hand:
        return f"expected the hand over {predicted.hand}, but it is over {observed.hand}"
    for obj, mark in sorted(predicted.marks ^ observed.marks):
        return f"expected {obj} {'' if (obj, mark) in predicted.marks else 'not '}to be {mark}"
    for obj in poses.keys() - {known.name for known in scene.model.objects}:
        return f"an unknown object has appeared at {in_metres(poses[obj].position, decimals=2)}"
    return None


def _where(state: ManipulationState, obj: str) -> str | None:
    if state.held == obj:
        return "in the hand"
    place = state.place.get(obj)
    return None if place is None else f"on {place}"


def _standing_on(scene: Scene, poses: Poses, objects: Iterable[str], locations: Sequence[str]) -> dict[str, str]:
    """Return, by location, which of some objects stands there."""
    found = {}
    for obj, temporary in itertools.product(objects, (False, True)):
        slot = slot_of(scene, poses, obj, temporary=temporary)
        if slot is not None and slot.location in locations:
            found[slot.location] = obj
    return found
