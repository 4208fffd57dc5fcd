"""Grounding: the symbolic state read back from the simulation, and how it differs from what was expected."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from prefplan.models.manipulation import ManipulationState
from sim.panda import TCP
from sim.places import Slot
from sim.scene import Scene
from sim.shapes import UPRIGHT

AT_RADIUS = 0.045
"""An object is at a slot when its centre is this near to the slot's on the horizontal, m: a block's width."""

AT_HEIGHT = 0.008
"""... and its underside this near to what it rests on, m."""

TOUCH = 0.002
"""Objects touch when they are this near, m: contacts flicker, so their absence says little."""

NOWHERE = "no location"
"""Where the hand is when it is over none: not a name, so that no location can bear it."""


@dataclass(frozen=True)
class ObjectPose:
    """Where an object is.

    Attributes:
        position: (3,) of its centre, m, robot base frame.
        yaw: heading about z of the line along which the fingers rather close, rad, up to its shape's symmetry.
        tilt: of its height from the vertical, rad; a cube stands on any of its faces.
    """

    position: np.ndarray
    yaw: float
    tilt: float


def object_pose(scene: Scene, data: mujoco.MjData, name: str) -> ObjectPose:
    """Return where an object is: the skills' and the grounding's only perception, here the true pose."""
    body = data.body(name)
    axes = body.xmat.reshape(3, 3)
    steep = np.abs(axes[2])
    cube = scene.shapes[name].kind == "cube"
    level = axes[:, int(np.argmin(steep)) if cube else int(steep[0] > np.sqrt(0.5))]
    tilt = np.arccos(min(1.0, float(steep.max() if cube else steep[2])))
    return ObjectPose(body.xpos.copy(), float(np.arctan2(level[1], level[0])), float(tilt))


def slot_of(scene: Scene, data: mujoco.MjData, name: str) -> Slot | None:
    """Return the slot in which an object rests, or None.

    It rests there when it is upright, near the slot's centre and as high as what it would rest on. Where the location
    lies on others, that is an object it touches, standing on one of them.
    """
    pose = object_pose(scene, data, name)
    if pose.tilt > UPRIGHT:
        return None
    underside = pose.position - [0.0, 0.0, scene.shapes[name].half[2]]
    slots = [slot for row in scene.slots.values() for slot in row]
    near = [slot for slot in slots if np.hypot(*(underside - slot.position)[:2]) < AT_RADIUS]
    for slot in sorted(near, key=lambda slot: float(np.linalg.norm(underside - slot.position))):
        supports = scene.model.location(slot.location).on
        floors = [float(slot.position[2])]
        if supports:
            under = [other for other in _carriers(scene, data, name) if _stands_on(scene, data, other, supports)]
            floors = [float(data.body(other).xpos[2] + scene.shapes[other].half[2]) for other in under]
        if any(abs(underside[2] - floor) < AT_HEIGHT for floor in floors):
            return slot
    return None


def hand_over(scene: Scene, data: mujoco.MjData, location: str) -> bool:
    """Return whether the hand is over a location: over its row of slots or between two of them."""
    tool, row = data.site(TCP).xpos, scene.slots[location]
    first, last = row[0].position, row[-1].position
    along = (last - first)[:2]
    share = np.clip((tool - first)[:2] @ along / max(along @ along, 1e-12), 0.0, 1.0)
    return bool(np.hypot(*(tool - first)[:2] - share * along) < AT_RADIUS and tool[2] > first[2])


def observe(
    scene: Scene,
    data: mujoco.MjData,
    *,
    hand: str,
    held: str | None,
    marks: frozenset[tuple[str, str]] = frozenset(),
) -> ManipulationState:
    """Return the symbolic state of the simulation.

    An object that neither rests in a slot nor is held has no place in it.

    Args:
        scene: the scene.
        data: its state.
        hand: where the hand was last sent; elsewhere is reported only if it is not there.
        held: what the pads hold, from the forces they felt of late.
        marks: what the past left behind and no sensor shows.
    """
    if hand in scene.slots and not hand_over(scene, data, hand):
        hand = next((name for name in scene.slots if hand_over(scene, data, name)), NOWHERE)
    slots = [(thing.name, slot_of(scene, data, thing.name)) for thing in scene.model.objects if thing.name != held]
    places = tuple((name, slot.location) for name, slot in slots if slot is not None)
    return ManipulationState(hand=hand, held=held, places=places, marks=marks)


def mismatch(
    scene: Scene, data: mujoco.MjData, *, predicted: ManipulationState, observed: ManipulationState
) -> str | None:
    """Return how an observed state differs from the predicted one, in words, or None.

    The first difference among the objects is told, else that of the hand or the marks.
    """
    for thing in (object.name for object in scene.model.objects):
        expected, found = _where(predicted, thing), _where(observed, thing)
        if expected == found:
            continue
        if found is None:
            at = ", ".join(f"{x:.2f}" for x in data.body(thing).xpos)
            found = f"it lies off every location, at ({at}) m"
        elif observed.held == thing:
            found = "it is in the hand"
        else:
            found = f"it rests {found}"
        return f"expected {thing} {expected}, but {found}"
    if predicted.hand != observed.hand:
        return f"expected the hand over {predicted.hand}, but it is over {observed.hand}"
    for thing, mark in sorted(predicted.marks ^ observed.marks):
        return f"expected {thing} {'' if (thing, mark) in predicted.marks else 'not '}to be {mark}"
    return None


def _where(state: ManipulationState, thing: str) -> str | None:
    if state.held == thing:
        return "in the hand"
    place = state.place.get(thing)
    return None if place is None else f"on {place}"


def _carriers(scene: Scene, data: mujoco.MjData, name: str) -> list[str]:
    """Return the objects that an object touches and whose centres are lower than its bottom."""
    model = scene.mujoco
    own, bottom = model.geom(name).id, data.body(name).xpos[2] - scene.shapes[name].half[2]
    lower = [thing.name for thing in scene.model.objects if data.body(thing.name).xpos[2] < bottom]
    return [thing for thing in lower if _distance(model, data, own, model.geom(thing).id) < TOUCH]


def _stands_on(scene: Scene, data: mujoco.MjData, name: str, locations: tuple[str, ...]) -> bool:
    slot = slot_of(scene, data, name)
    return slot is not None and slot.location in locations


def _distance(model: mujoco.MjModel, data: mujoco.MjData, geom: int, other: int) -> float:
    return float(mujoco.mj_geomDistance(model, data, geom, other, 2 * TOUCH, None))
