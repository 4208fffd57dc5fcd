"""Where an object can be put down: free slots, and the tool's pose that puts the held object into one."""

from __future__ import annotations

import numpy as np

from sim.geometry.rectangle import Rectangle, overlap
from sim.motion.trajectory import wrap
from sim.perception.grounding import footprint, middle_of_supports
from sim.perception.sensors import Poses
from sim.simulation.workcell import Workcell
from sim.skills.hand import held_grip
from sim.skills.skill import SkillError
from sim.world.places import AT_RADIUS_M, Slot
from sim.world.scene import Scene
from sim.world.shapes import Grip

OBJECT_GAP_M = 0.005
"""Least gap between objects that rest side by side."""

MAX_OVERHANG_M = 0.005
"""Greatest distance of an object from the middle of what carries it, to put it nearer to its slot's centre."""

MAX_STEP_M = 0.005
"""Greatest difference in height between objects that carry another between them."""

DISTANCE_CAP_M = 0.1
"""Distance of centres beyond which slots are equally good."""

DROP_HEIGHT_M = 0.0005
"""Height from which an object is released, so that the hand does not press it onto the surface below."""


def free_slot(cell: Workcell, obj: str, location: str) -> Slot:
    """Return the slot of a location farthest from the other objects on its level.

    Raises:
        SkillError: the object does not fit into it.
    """
    slot = max(cell.scene.slots[location], key=lambda slot: _clearance(cell, obj, slot))
    check_free(cell, obj, slot)
    return slot


def check_free(cell: Workcell, obj: str, slot: Slot) -> None:
    """Raise SkillError unless an object fits into a slot, and would rest on all that is to carry it there."""
    fits, nearest = _clearance(cell, obj, slot)
    if not fits:
        raise SkillError(f"no room for {obj} on {slot.location}: another object is {nearest * 1000:.0f} mm from it")
    poses, under = _supports(cell, obj, slot)
    place = Rectangle(resting_centre(cell, obj, slot)[:2], cell.scene.shapes[obj].half[:2], slot.yaw)
    tops = {other: _top(cell.scene, poses, other) for other in under.values()}
    for other, top in tops.items():
        if not overlap(place, footprint(cell.scene, poses, other)) or top < max(tops.values()) - MAX_STEP_M:
            raise SkillError(f"{obj} would not rest on {other}")


def closing_lines(cell: Workcell, obj: str, slot: Slot) -> list[tuple[float, Grip]]:
    """Return the closing lines, rad, each with its grip, at which the held object can be placed square to a slot."""
    grip, shape = held_grip(cell, obj), cell.scene.shapes[obj]
    if shape.symmetry > np.pi / 2:
        return [(slot.yaw + grip.turn, grip)]
    return [(slot.yaw, grip), (slot.yaw + np.pi / 2, grip)]


def resting_centre(cell: Workcell, obj: str, slot: Slot) -> np.ndarray:
    """Return the (3,) centre of an object when it rests in a slot, on the objects that support it there now, m."""
    scene, supports = cell.scene, cell.scene.model.location(slot.location).on
    if not supports:
        return slot.position + [0.0, 0.0, scene.shapes[obj].half[2]]
    poses, under = _supports(cell, obj, slot)
    floor = max((_top(scene, poses, other) for other in under.values()), default=float(slot.position[2]))
    middle = middle_of_supports(scene, poses, under, supports)
    off = slot.position[:2] - middle
    off *= min(1.0, MAX_OVERHANG_M / max(float(np.hypot(*off)), 1e-9))
    return np.array([*middle + off, floor + scene.shapes[obj].half[2]])


def placing_pose(cell: Workcell, obj: str, slot: Slot) -> tuple[np.ndarray, float]:
    """Return the tool's (3,) position, m, and yaw, rad, that put the held object, as it lies in the hand, into a slot.

    A tilted object would touch down with an edge and tip, so that its lowest point sets the height. The arm may be
    moving, unless the sensor needs several observations.
    """
    if cell.sensor.samples > 1:
        cell.settle()
    held = cell.measure(obj)
    tool = cell.arm.tool(cell.angles)
    symmetry = cell.scene.shapes[obj].symmetry
    turn = wrap(slot.yaw - held.yaw, symmetry) if symmetry else 0.0
    c, s = np.cos(turn), np.sin(turn)
    offset = held.position - tool.position
    lowest = offset[2] - cell.scene.shapes[obj].depth(held.rotation) + cell.scene.shapes[obj].half[2]
    turned = np.array([c * offset[0] - s * offset[1], s * offset[0] + c * offset[1], lowest - DROP_HEIGHT_M])
    return resting_centre(cell, obj, slot) - turned, tool.yaw + turn


def _supports(cell: Workcell, obj: str, slot: Slot) -> tuple[Poses, dict[str, str]]:
    """Return the poses of the other objects, and which of them lies on top at each location that carries a slot."""
    poses = {other: cell.observe(other) for other in cell.shapes if other != obj}
    under: dict[str, str] = {}
    for place in cell.scene.model.location(slot.location).on:
        nominal = cell.scene.slots[place][0].position[:2]
        there = [other for other in poses if np.hypot(*(poses[other].position[:2] - nominal)) < AT_RADIUS_M]
        if there:
            under[place] = max(there, key=lambda other: _top(cell.scene, poses, other))
    return poses, under


def _top(scene: Scene, poses: Poses, obj: str) -> float:
    return float(poses[obj].position[2] + scene.shapes[obj].half[2])


def _clearance(cell: Workcell, obj: str, slot: Slot) -> tuple[bool, float]:
    """Return whether an object fits into a slot, and the distance to the nearest other object on its level, m."""
    shapes = cell.shapes
    own, centre = shapes[obj].half, resting_centre(cell, obj, slot)
    others = [(shape, cell.observe(other)) for other, shape in shapes.items() if other != obj]
    level = [
        (shape, pose)
        for shape, pose in others
        if abs(pose.position - centre)[2] < own[2] + shape.half[2] - OBJECT_GAP_M
    ]
    place = Rectangle(centre[:2], own[:2] + OBJECT_GAP_M, slot.yaw)
    taken = [Rectangle(pose.position[:2], shape.half[:2], shape.yaw_near(pose.yaw, slot.yaw)) for shape, pose in level]
    nearest = min((float(np.hypot(*(pose.position - centre)[:2])) for _, pose in level), default=DISTANCE_CAP_M)
    return not any(overlap(place, other) for other in taken), min(nearest, DISTANCE_CAP_M)
