"""Where things stand: the slots of every location, derived from the manipulation model alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from prefplan.errors import choices
from prefplan.models.manipulation import Location, ManipulationModel
from sim.errors import SimulationError

BLOCK_HALF = 0.0225
"""Half the edge of an object, a cube of 4.5 cm that the open hand (8 cm) takes with room to spare, m."""

REACH = 0.80
"""Farthest horizontal distance from the base at which the hand can point down, m (arm almost straight)."""

NEAREST = 0.28
"""Nearest horizontal distance from the base at which the hand clears the robot's own foot, m."""

ROW_PITCH = 0.064
"""Distance between neighbouring slots of one location, m: 19 mm between blocks."""

KINDS = ("spot", "pad", "bin")
"""What a location on the table looks like: a marking, a raised plate, a box with walls."""

FLOOR = {"spot": 0.0, "pad": 0.004, "bin": 0.003}
"""Height above the table of the surface on which objects rest, m."""


@dataclass(frozen=True)
class Slot:
    """Room for one object.

    Attributes:
        location: the location it belongs to.
        index: 0 .. capacity - 1 within the location.
        position: (3,) where the object's centre rests, m, robot base frame (z = 0 is the table top).
        yaw: heading about z of the line along which the fingers close, rad; both sides are free of walls and
            neighbours. The object rests square to it: its yaw is this one modulo 90 degrees.
    """

    location: str
    index: int
    position: np.ndarray
    yaw: float


def kind_of(place: Location) -> str | None:
    """Return how a location looks: its `kind`, else `pad` if it marks, `spot` on the table, None on others."""
    if place.on:
        return None
    return place.kind or ("pad" if place.marks else "spot")


def layout(model: ManipulationModel) -> dict[str, tuple[Slot, ...]]:
    """Return the slots of every location, in the order of the file.

    Raises:
        SimulationError: a location out of reach, of an unknown kind, or without a definite place.
    """
    slots: dict[str, tuple[Slot, ...]] = {}
    for place in model.locations:
        _place(place.name, model, slots)
    return {place.name: slots[place.name] for place in model.locations}


def _place(name: str, model: ManipulationModel, slots: dict[str, tuple[Slot, ...]]) -> None:
    if name in slots:
        return
    place = model.location(name)
    for support in place.on:
        _place(support, model, slots)
    slots[name] = _stacked(place, slots) if place.on else _on_table(place, model)


def _on_table(place: Location, model: ManipulationModel) -> tuple[Slot, ...]:
    where = f"locations.{place.name}"
    kind = kind_of(place)
    if kind not in KINDS:
        raise SimulationError(f"{where}.kind: unknown kind {kind!r} {choices(str(kind), KINDS)}")
    assert place.at is not None
    yaw = _closing_yaw(place, model)
    along = np.array([-np.sin(yaw), np.cos(yaw)])
    offsets = (np.arange(place.capacity) - (place.capacity - 1) / 2) * ROW_PITCH
    slots = tuple(
        Slot(place.name, i, np.array([*(place.at + offset * along), FLOOR[kind] + BLOCK_HALF]), yaw)
        for i, offset in enumerate(offsets)
    )
    for slot in slots:
        distance = float(np.hypot(*slot.position[:2]))
        if distance > REACH:
            raise SimulationError(
                f"{where}: {distance:.2f} m from the robot's base, beyond its reach of {REACH:.2f} m"
            )
        if distance < NEAREST:
            raise SimulationError(
                f"{where}: {distance:.2f} m from the robot's base, nearer than {NEAREST:.2f} m"
            )
    return slots


def _closing_yaw(place: Location, model: ManipulationModel) -> float:
    """Return a closing line that keeps the fingers out of the gap to the nearest neighbour."""
    assert place.at is not None
    others = [
        np.subtract(o.at, place.at) for o in model.locations if o.at is not None and o.name != place.name
    ]
    near = [d for d in others if np.hypot(*d) < 0.12]
    if not near:
        return float(np.pi / 2)
    d = min(near, key=lambda d: float(np.hypot(*d)))
    return float((np.arctan2(d[1], d[0]) + np.pi / 2 + 1e-9) % np.pi - 1e-9)


def _stacked(place: Location, slots: dict[str, tuple[Slot, ...]]) -> tuple[Slot, ...]:
    below = [slots[support][0] for support in place.on]
    position = np.mean([slot.position for slot in below], axis=0) + [0.0, 0.0, 2 * BLOCK_HALF]
    return (Slot(place.name, 0, position, below[0].yaw),)
