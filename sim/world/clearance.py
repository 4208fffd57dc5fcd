"""Feasibility of a layout: locations apart from one another, and each on a surface with space above it."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError
from sim.geometry.rectangle import Rectangle, contains, overlap
from sim.robots.gripper import Gripper
from sim.world.fixtures import MAX_CONTACT_M, Block, blocks_of
from sim.world.furniture import BIN_HEIGHT_M, BIN_WALL_M
from sim.world.places import FLOOR, OBJECT_GAP_M, Station

SAME_HEIGHT_M = 0.001
"""Greatest difference in height between a location and the surface that it lies on, m."""


def collisions(stations: Sequence[Station]) -> Iterator[str]:
    """Yield an error message for each pair of locations whose objects, walls or plates overlap."""
    for other, station in itertools.combinations(stations, 2):
        if overlapping(station, other):
            distance = float(np.hypot(*(station.outline.centre - other.outline.centre)))
            least = _least_distance(station, other)
            missing = f"{100 * (least - distance):.1f} cm too close"
            yield (
                f"locations.{station.name}: {distance:.3f} m from {other.name!r}, {missing}: they would touch; at "
                f"least {least:.3f} m"
            )


def overlapping(station: Station, other: Station) -> bool:
    """Return whether the objects, walls or plates of two locations overlap or leave no gap for putting objects down."""
    return _level(station, other) and overlap(*_claimed(station, other))


def space(station: Station) -> Block:
    """Return the space that a station's objects and walls need above the surface that carries the station."""
    high, wall = FLOOR[station.kind] + station.size.clear, 0.0
    if station.kind == "bin":
        high, wall = max(high, BIN_HEIGHT_M), BIN_WALL_M
    return Block(station.name, station.outline.grown(wall), station.height, station.height + high)


def _level(station: Station, other: Station) -> bool:
    """Return whether objects at two stations overlap in height, rather than lie one above the other."""
    one, two = space(station), space(other)
    return one.low < two.high and two.low < one.high


def check_surroundings(station: Station, model: ManipulationModel) -> None:
    """Raise `SimulationError` unless a station lies on the table or on a fixture, with room for its objects.

    In a user's scene, `sim.external.user_scene.resolved` has found what carries it.
    """
    needed, blocks = space(station), blocks_of(model.fixtures)
    if model.scene is None:
        _check_carried(needed, blocks)
    inside = next((block for block in blocks if block.meets(needed.outline, needed.low, needed.high)), None)
    if inside is None:
        return
    above = inside.low > needed.low + MAX_CONTACT_M
    lacking = f"leaves {inside.low - needed.low:.3f} m above it, and its objects need {needed.high - needed.low:.3f} m"
    stands = f"stands in it (its upper side is at {inside.high:g} m)"
    raise SimulationError(f"locations.{needed.name}: the fixture {inside.name!r} {lacking if above else stands}")


def _check_carried(place: Block, blocks: Sequence[Block]) -> None:
    """Raise `SimulationError` unless a location above the table top lies entirely on a block that carries it."""
    if place.low <= SAME_HEIGHT_M:
        return
    surfaces = [block for block in blocks if block.carries and block.high > 0]
    level = [surface for surface in surfaces if abs(surface.high - place.low) <= SAME_HEIGHT_M]
    if any(contains(surface.outline, place.outline) for surface in level):
        return
    where = f"locations.{place.name}.at"
    here = [surface for surface in surfaces if overlap(surface.outline, place.outline)]
    if over := next((surface for surface in level if surface in here), None):
        raise SimulationError(f"{where}: it reaches over the edge of the fixture {over.name!r}")
    heights = " or ".join(f"{other:g}" for other in sorted({0.0, *(round(surface.high, 6) for surface in here)}))
    raise SimulationError(
        f"{where}: no fixture carries it {place.low:g} m above the table top; there, it can lie at {heights} m"
    )


def _least_distance(station: Station, other: Station) -> float:
    """Return the distance along the line between two stations at which they no longer touch, m, to the millimetre."""
    moved, fixed = _claimed(station, other)
    apart = station.outline.centre - other.outline.centre
    distance = float(np.hypot(*apart))
    direction = apart / distance if distance else np.array([1.0, 0.0])
    while overlap(replace(moved, centre=other.outline.centre + distance * direction), fixed):
        distance = (np.floor(distance * 1000) + 1) / 1000
    return distance


def blockages(
    station: Station, others: Sequence[Station], walls: Sequence[Block], gripper: Gripper
) -> tuple[bool, bool, bool, bool]:
    """Return what blocks a station, the worst first.

    The flags: another station overlaps it; a fixture is in its space; the fingers at it would collide with a fixture or
    another station; the fingers at another station, which may still be turned, would collide with it.
    """
    level = [other for other in others if _level(station, other)]
    needed, fingers, low = space(station), _fingers(station, gripper), station.height + FLOOR[station.kind]
    return (
        any(overlapping(station, other) for other in level),
        any(block.meets(needed.outline, needed.low, needed.high) for block in walls),
        any(_fingers_meet(station, other, gripper) for other in level)
        or any(block.meets(outline, low, low + station.size.high) for block in walls for outline in fingers),
        any(_fingers_meet(other, station, gripper) for other in level),
    )


def _fingers_meet(station: Station, other: Station, gripper: Gripper) -> bool:
    return any(overlap(outline, other.outline) for outline in _fingers(station, gripper))


def _fingers(station: Station, gripper: Gripper) -> list[Rectangle]:
    """Return the outline of the open fingers at each slot of a station."""
    half = np.array([station.size.opening / 2 + gripper.finger_depth_m, gripper.finger_half_width_m])
    return [Rectangle(slot.position[:2], half, slot.yaw) for slot in station.slots]


def _claimed(*pair: Station) -> list[Rectangle]:
    """Return the area of each of two stations, grown by half the gap that is needed to put an object down.

    Two stations that are filled from the start need no gap.
    """
    gap = 0.0 if all(station.size.taken for station in pair) else OBJECT_GAP_M
    return [space(station).outline.grown(gap / 2 - MAX_CONTACT_M) for station in pair]
