"""Grounding: the symbolic state read back from the simulation, and how it differs from what was expected."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from prefplan.models.manipulation import ManipulationState
from sim.panda import TCP
from sim.places import Slot
from sim.scene import Scene

AT_RADIUS = 0.045
"""An object is at a slot when its centre is this near to the slot's on the horizontal, m: a block's width."""

AT_HEIGHT = 0.008
"""... and this near on the vertical, m: a tilted block is further off."""

TOUCH = 0.002
"""Objects touch when they are this near, m: contacts flicker, so their absence says little."""

NOWHERE = "no location"
"""Where the hand is when it is over none: not a name, so that no location can bear it."""


@dataclass(frozen=True)
class ObjectPose:
    """Where an object is.

    Attributes:
        position: (3,) of its centre, m, robot base frame.
        yaw: heading of its upright faces about z, rad; a cube's repeats every 90 degrees.
    """

    position: np.ndarray
    yaw: float


def object_pose(scene: Scene, data: mujoco.MjData, name: str) -> ObjectPose:
    """Return where an object is: the skills' and the grounding's only perception, here the true pose."""
    body = data.body(name)
    axes = body.xmat.reshape(3, 3)
    level = axes[:, int(np.argmin(np.abs(axes[2])))]
    return ObjectPose(body.xpos.copy(), float(np.arctan2(level[1], level[0])))


def slot_of(scene: Scene, data: mujoco.MjData, name: str) -> Slot | None:
    """Return the slot in which an object rests, or None.

    It rests there when it is near the slot's centre and, where the location lies on others, touches an object
    that stands on one of them.
    """
    position = object_pose(scene, data, name).position
    near = [
        slot
        for row in scene.slots.values()
        for slot in row
        if np.hypot(*(position - slot.position)[:2]) < AT_RADIUS and abs(position[2] - slot.position[2]) < AT_HEIGHT
    ]
    for slot in sorted(near, key=lambda slot: float(np.linalg.norm(position - slot.position))):
        supports = scene.model.location(slot.location).on
        if not supports:
            return slot
        under = [slot_of(scene, data, other) for other in _carriers(scene, data, name)]
        if any(below is not None and below.location in supports for below in under):
            return slot
    return None


def hand_over(scene: Scene, data: mujoco.MjData, location: str) -> bool:
    """Return whether the hand is over a location."""
    tool = data.site(TCP).xpos
    return any(
        np.hypot(*(tool - slot.position)[:2]) < AT_RADIUS and tool[2] > slot.position[2]
        for slot in scene.slots[location]
    )


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
    own, bottom = model.geom(name).id, data.body(name).xpos[2] - scene.half
    lower = [thing.name for thing in scene.model.objects if data.body(thing.name).xpos[2] < bottom]
    return [thing for thing in lower if _distance(model, data, own, model.geom(thing).id) < TOUCH]


def _distance(model: mujoco.MjModel, data: mujoco.MjData, geom: int, other: int) -> float:
    return float(mujoco.mj_geomDistance(model, data, geom, other, 2 * TOUCH, None))
