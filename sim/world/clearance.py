"""Feasibility of a layout: every slot within reach, locations apart, and clearance for the hand at each of them."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError
from sim.geometry.rectangle import Rectangle, overlap
from sim.world.arm_clearance import arm_meets
from sim.world.places import (
    ARM_LENGTH,
    CARRYING_HEIGHT,
    FINGER_DEPTH,
    FINGER_HALF,
    FINGER_TIPS,
    LAMP_DISTANCES,
    LAMP_HALF,
    LAMP_HEAD,
    LAMP_TOP,
    NEAREST,
    OBJECT_GAP,
    PALM_CLEARANCE,
    PALM_HALF,
    SHOULDER_HEIGHT,
    WIDEST,
    WRIST_HEIGHT,
    WRIST_OFFSET,
    Slot,
    Station,
)
from sim.world.shapes import CUBE_EDGE, Extent

MAX_START_TURN_RAD = np.radians(5)
"""Objects may start turned by this much, rad."""

Slots = Mapping[str, tuple[Slot, ...]]


def check_reach(slots: Slots, size: Extent) -> None:
    """Raise `SimulationError` for a slot out of the hand's reach from above."""
    tallest = max((float(slot.position[2]) + size.high for row in slots.values() for slot in row), default=0.0)
    for row in slots.values():
        for slot in row:
            where = f"locations.{slot.location}"
            x, y, z = slot.position + [0.0, 0.0, size.high / 2]
            distance = float(np.hypot(x, y))
            reach = min(reach_at(z), reach_at(tallest + CARRYING_HEIGHT))
            if distance > reach:
                over = f" when it passes over a stack {tallest:.2f} m high" if reach < reach_at(z) else ""
                raise SimulationError(
                    f"{where}: {distance:.2f} m from the robot's base, beyond its reach of {reach:.2f} m{over}"
                )
            if distance < NEAREST:
                raise SimulationError(
                    f"{where}: {distance:.2f} m from the robot's base, too near: at least {NEAREST:.2f} m"
                )
            if abs(np.arctan2(y, x)) > WIDEST:
                raise SimulationError(
                    f"{where}: behind the robot, which turns {np.degrees(WIDEST):.0f} degrees to either side"
                )


def reach_at(height: float) -> float:
    """Return how far from the base's axis the fingers of a hand that points down get, at a height, m."""
    rise = height + WRIST_HEIGHT - SHOULDER_HEIGHT
    return WRIST_OFFSET + float(np.sqrt(max(0.0, ARM_LENGTH**2 - rise**2)))


def check_apart(stations: Sequence[Station], size: Extent) -> None:
    """Raise `SimulationError` for two locations whose objects, walls or plates would collide."""
    for i, station in enumerate(stations):
        for other in stations[:i]:
            if overlap(_covered(station, size), _covered(other, size)):
                apart = np.hypot(*(station.outline.centre - other.outline.centre))
                raise SimulationError(
                    f"locations.{station.name}: {apart:.3f} m from {other.name!r}, so close that they would touch"
                )


def check_fingers(model: ManipulationModel, stations: Sequence[Station], slots: Slots, size: Extent) -> None:
    """Raise `SimulationError` for a slot at which the hand would collide with an object or a fixture elsewhere."""
    for station in stations:
        for other in stations:
            if other is not station and _fingers_meet(station, other, size):
                raise SimulationError(
                    f"locations.{station.name}: no room for the fingers beside {other.name!r}; move them apart"
                )
    flat = [slot for row in slots.values() for slot in row]
    for slot in flat:
        for beside in flat:
            here, there = slot.location, beside.location
            if here == there or _rests_on(model, here, there) or _rests_on(model, there, here):
                continue
            spread = _storeys(model, slot.location) * (size.high - size.low)
            if _hand_meets(slot, beside, size, lowest=slot.position[2] - spread):
                raise SimulationError(
                    f"locations.{slot.location}: no room for the hand beside an object at {beside.location!r}; "
                    "move them apart"
                )
            tool = slot.position + [0.0, 0.0, size.low / 2]
            if arm_meets(tool, _footprint(beside, size), beside.position[2] + size.high):
                raise SimulationError(
                    f"locations.{slot.location}: no room for the arm over an object at {beside.location!r}, between it "
                    "and the base; move them apart"
                )


def blocked(station: Station, others: Sequence[Station], size: Extent) -> bool:
    """Return whether the fingers at a station would collide with another station, or the reverse."""
    return any(_fingers_meet(station, other, size) or _fingers_meet(other, station, size) for other in others)


def lamp_foot(station: Station, stations: Sequence[Station], slots: Slots, size: Extent) -> np.ndarray:
    """Return the (2,) foot of a station's lamp: clear of the hand and the arm, the farther from the base the better."""
    centre = station.outline.centre
    outwards = float(np.arctan2(centre[1], centre[0]))
    turns = np.radians([0, 30, -30, 60, -60, 90, -90, 120, -120])
    for distance, turn in itertools.product(LAMP_DISTANCES, turns):
        direction = np.array([np.cos(outwards + turn), np.sin(outwards + turn)])
        reach = max(float((slot.position[:2] - centre) @ direction) for slot in station.slots)
        foot = centre + direction * (reach + distance)
        stand = Rectangle(foot, np.full(2, LAMP_HALF), outwards + turn)
        head = Rectangle(foot, LAMP_HEAD, outwards + turn)
        if any(_lamp_meets(head, slot, size) for row in slots.values() for slot in row):
            continue
        if not any(overlap(stand, _covered(other, size)) for other in stations):
            return foot
    raise SimulationError(
        f"locations.{station.name}: no room for its lamp {LAMP_DISTANCES[0]:.2f} m away; move other locations off"
    )


def _covered(station: Station, size: Extent) -> Rectangle:
    swing = float(np.sin(MAX_START_TURN_RAD)) * max(0.0, float(size.half.max()) - CUBE_EDGE / 2)
    return station.outline.grown(OBJECT_GAP / 2 + swing)


def _fingers(slot: Slot, size: Extent) -> Rectangle:
    return Rectangle(slot.position[:2], np.array([size.opening / 2 + FINGER_DEPTH, FINGER_HALF]), slot.yaw)


def _fingers_meet(station: Station, other: Station, size: Extent) -> bool:
    return any(overlap(_fingers(slot, size), other.outline) for slot in station.slots)


def _lamp_meets(head: Rectangle, slot: Slot, size: Extent) -> bool:
    """Return whether the hand or the arm at a slot would collide with a lamp's head."""
    if np.hypot(*(slot.position[:2] - head.centre)) < LAMP_DISTANCES[0] - LAMP_HALF / 2:
        return True
    if overlap(Rectangle(slot.position[:2], PALM_HALF, slot.yaw), head):
        return True
    return arm_meets(slot.position + [0.0, 0.0, size.low / 2], head, LAMP_TOP)


def _footprint(slot: Slot, size: Extent) -> Rectangle:
    return Rectangle(slot.position[:2], size.half, slot.yaw)


def _hand_meets(slot: Slot, other: Slot, size: Extent, *, lowest: float) -> bool:
    """Return whether the hand at a slot, whose surface is not below `lowest`, collides with an object in another."""
    footprint = _footprint(other, size)
    top, middle = other.position[2] + size.high, lowest + size.low / 2
    if top > middle + PALM_CLEARANCE and overlap(Rectangle(slot.position[:2], PALM_HALF, slot.yaw), footprint):
        return True
    return top > middle - FINGER_TIPS and overlap(_fingers(slot, size), footprint)


def _storeys(model: ManipulationModel, location: str) -> int:
    return max((1 + _storeys(model, support) for support in model.location(location).on), default=0)


def _rests_on(model: ManipulationModel, upper: str, lower: str) -> bool:
    supports = model.location(upper).on
    return lower in supports or any(_rests_on(model, support, lower) for support in supports)
