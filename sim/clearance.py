"""Whether the arm can work at every place: within reach, apart from one another, room for the hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from prefplan.models.manipulation import ManipulationModel
from sim.errors import SimulationError
from sim.places import (
    ARM_LENGTH,
    BLOCK_GAP,
    BLOCK_HALF,
    CARRYING_HEIGHT,
    FINGER_TIPS,
    FINGERS_HALF,
    LAMP_DISTANCE,
    LAMP_HALF,
    NEAREST,
    PALM_CLEARANCE,
    PALM_HALF,
    SHOULDER_HEIGHT,
    WIDEST,
    WRIST_HEIGHT,
    WRIST_OFFSET,
    Slot,
    Station,
)
from sim.rectangle import Rectangle, overlap

Slots = Mapping[str, tuple[Slot, ...]]


def check_reach(slots: Slots) -> None:
    """Raise `SimulationError` for a slot that the hand cannot get at from above."""
    tallest = max((float(slot.position[2]) + BLOCK_HALF for row in slots.values() for slot in row), default=0.0)
    for row in slots.values():
        for slot in row:
            where = f"locations.{slot.location}"
            x, y, z = slot.position
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


def check_apart(stations: Sequence[Station]) -> None:
    """Raise `SimulationError` for two locations whose objects, walls or plates would touch."""
    for i, station in enumerate(stations):
        for other in stations[:i]:
            if overlap(_covered(station), _covered(other)):
                apart = np.hypot(*(station.outline.centre - other.outline.centre))
                raise SimulationError(
                    f"locations.{station.name}: {apart:.3f} m from {other.name!r}, so close that they would touch"
                )


def check_fingers(model: ManipulationModel, stations: Sequence[Station], slots: Slots) -> None:
    """Raise `SimulationError` for a slot at which the hand would meet something that may stand elsewhere."""
    for station in stations:
        for other in stations:
            if other is not station and _fingers_meet(station, other):
                raise SimulationError(
                    f"locations.{station.name}: no room for the fingers beside {other.name!r}; move them apart"
                )
    flat = [slot for row in slots.values() for slot in row]
    for slot in flat:
        for beside in flat:
            if beside.location == slot.location or _rests_on(model, beside.location, slot.location):
                continue
            if _hand_meets(slot, beside):
                raise SimulationError(
                    f"locations.{slot.location}: no room for the hand beside an object at {beside.location!r}; "
                    "move them apart"
                )


def blocked(station: Station, others: Sequence[Station]) -> bool:
    """Return whether the fingers at a station would meet another, or the other's would meet it."""
    return any(_fingers_meet(station, other) or _fingers_meet(other, station) for other in others)


def lamp_foot(station: Station, stations: Sequence[Station], slots: Slots) -> np.ndarray:
    """Return the (2,) foot of a station's lamp: out of the hand's way, the farther from the base the better."""
    centre = station.outline.centre
    outwards = float(np.arctan2(centre[1], centre[0]))
    for turn in np.radians([0, 30, -30, 60, -60, 90, -90, 120, -120]):
        direction = np.array([np.cos(outwards + turn), np.sin(outwards + turn)])
        reach = max(float((slot.position[:2] - centre) @ direction) for slot in station.slots)
        foot = centre + direction * (reach + LAMP_DISTANCE)
        stand = Rectangle(foot, np.full(2, LAMP_HALF), outwards + turn)
        far = all(
            np.hypot(*(slot.position[:2] - foot)) > LAMP_DISTANCE - LAMP_HALF / 2
            for row in slots.values()
            for slot in row
        )
        if far and not any(overlap(stand, _covered(other)) for other in stations):
            return foot
    raise SimulationError(
        f"locations.{station.name}: no room for its lamp {LAMP_DISTANCE:.2f} m away; move other locations off"
    )


def _covered(station: Station) -> Rectangle:
    return station.outline.grown(BLOCK_GAP / 2)


def _fingers(slot: Slot) -> Rectangle:
    return Rectangle(slot.position[:2], FINGERS_HALF, slot.yaw)


def _fingers_meet(station: Station, other: Station) -> bool:
    return any(overlap(_fingers(slot), other.outline) for slot in station.slots)


def _hand_meets(slot: Slot, other: Slot) -> bool:
    block = Rectangle(other.position[:2], np.full(2, BLOCK_HALF), other.yaw)
    top = other.position[2] + BLOCK_HALF
    if top > slot.position[2] + PALM_CLEARANCE and overlap(Rectangle(slot.position[:2], PALM_HALF, slot.yaw), block):
        return True
    return top > slot.position[2] - FINGER_TIPS and overlap(_fingers(slot), block)


def _rests_on(model: ManipulationModel, upper: str, lower: str) -> bool:
    supports = model.location(upper).on
    return lower in supports or any(_rests_on(model, support, lower) for support in supports)
