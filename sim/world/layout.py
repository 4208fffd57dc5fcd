"""The layout: the slots of every location, derived from the manipulation model alone."""

import itertools
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from prefplan.errors import check_known
from prefplan.limits import check_limits
from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from prefplan.models.manipulation.surroundings import with_height
from sim.errors import SimulationError, collecting
from sim.external.user_scene import UserScene
from sim.geometry.rectangle import Rectangle
from sim.motion.kinematics import Arm
from sim.motion.trajectory import ToolPose
from sim.robots.gripper import Gripper
from sim.robots.robot import Robot
from sim.world.clearance import blockages, check_surroundings, collisions, overlapping
from sim.world.fixtures import blocks_of
from sim.world.places import AT_RADIUS_M, FLOOR, Extent, Slot, Station, TableLayout, extent
from sim.world.shapes import CUBE_EDGE_M, LARGEST_M, ObjectShape, shape_of

ROW_GAP_M = 0.019
"""Distance between neighbouring objects of one location, m."""

BIN_MARGIN_M = 0.0125
"""Distance from the last object of a row to a bin's wall, m."""

PAD_MARGIN_M = 0.0375
"""Distance from an object to the edge of a pad or of a stove, m."""

PLATE_MARGIN_M = 0.020
"""Distance from the corner of an object to the edge of a plate, m."""

SUPPORT_OVERLAP_M = 0.010
"""Least length by which an object rests on each of its supports, m."""

MAX_HEIGHT_DIFFERENCE_M = 0.001
"""Greatest difference in height of objects that together carry another, m."""

MIN_MASS_KG = 0.001
"""Least mass of an object, kg. At 0.01 g, contact forces are too small for the fingers to hold it."""

NEIGHBOUR_DISTANCE_M = 0.12
"""Distance to another location below which the fingers are kept out of the gap if possible, m."""


def arrange(model: ManipulationModel, robot: Robot, own: UserScene | None = None) -> TableLayout:
    """Return the stations and slots of a model, turned such that a robot can work there; `own` is the user's own scene.

    A location that is out of reach is no fault: a plan may do without it.

    Raises:
        SimulationError: locations of an unknown kind, without a definite position, or obstructing others, and objects
            that the hand cannot grasp. Each fault starts with the location's or the object's key.
    """
    faults: list[str] = []
    shapes: dict[str, ObjectShape] = {}
    for obj in model.objects:
        with collecting(faults):
            shapes[obj.name] = shape_of(obj, robot.gripper, model.folder, own)
            _check_mass(obj, shapes[obj.name], robot)
    sizes = {place.name: _bounds(model, place, shapes) for place in model.locations}
    stations = _stations(model, Arm(robot), sizes, faults)
    slots = {name: station.slots for name, station in stations.items()}
    for place in model.locations:
        with collecting(faults):
            _stack(place, model, slots, shapes, sizes)
    fixed = list(stations.values())
    faults += collisions(fixed)
    for station in fixed:
        with collecting(faults):
            check_surroundings(station, model)
    if faults:
        raise SimulationError(*faults)
    slots = {place.name: slots[place.name] for place in model.locations}
    return TableLayout(tuple(fixed), slots, shapes)


def _stations(model: ManipulationModel, arm: Arm, sizes: Mapping[str, Extent], faults: list[str]) -> dict[str, Station]:
    """Return the stations of a model, each turned such that the fingers have space if possible; add to the faults."""
    robot, walls = arm.robot, blocks_of(model.fixtures)
    grounded = [place for place in model.locations if place.at is not None]
    options: dict[str, list[Station]] = {}
    for place in grounded:
        check_limits()
        with collecting(faults):
            yaws = _yaws(place, grounded, robot)
            options[place.name] = [_station(place, yaw, robot.gripper, sizes[place.name]) for yaw in yaws]
    # Each station with its preferred yaw or, if fewer stations overlap then, all stations with the same yaw.
    alike = [
        {place.name: _station(place, yaw, robot.gripper, sizes[place.name]) for place in grounded}
        for yaw in ((np.pi / 2, 0.0) if len(options) == len(grounded) else ())
    ]
    stations = min(
        ({name: at[0] for name, at in options.items()}, *alike),
        key=lambda chosen: sum(overlapping(*pair) for pair in itertools.combinations(chosen.values(), 2)),
    )
    turned: set[str] = set()
    # The second pass is for stations blocked by others that were turned later.
    for name in (*options, *options):
        others = [station for other, station in stations.items() if other != name]
        blocked = partial(blockages, others=others, walls=walls, gripper=robot.gripper)
        if name in turned and not any(blocked(stations[name])):
            continue
        ranked = sorted(options[name], key=blocked)
        reached = (at for at in ranked if not blocked(at)[0] and _within_reach(arm, at))
        stations[name] = next(reached, ranked[0])
        turned.add(name)
    return stations


def _check_mass(obj: Object, shape: ObjectShape, robot: Robot) -> None:
    """Raise `SimulationError` for a mass that a robot cannot carry or whose contacts cannot be simulated."""
    mass, most = shape.mass, robot.gripper.held_mass(shape.height)
    where = f"objects.{obj.name}.{'mass' if obj.body is None else 'body'}"
    if mass < MIN_MASS_KG:
        raise SimulationError(f"{where}: {mass:g} kg is too light for the simulation: at least {MIN_MASS_KG:g} kg")
    if obj.fixed:
        return
    if mass > most:
        # Rounding to the nearest could show a mass that is slightly too great as small enough.
        shown = f"{int(100 * most) / 100:g} kg of an object {shape.height:g} m high"
        raise SimulationError(f"{where}: {mass:g} kg, but the suction cup holds at most {shown}")
    if robot.payload_kg is not None and mass > robot.payload_kg:
        raise SimulationError(
            f"{where}: {mass:g} kg, but the robot {robot.name} carries at most {robot.payload_kg:g} kg"
        )


def _bounds(model: ManipulationModel, place: Location, shapes: Mapping[str, ObjectShape]) -> Extent:
    """Return bounds on the dimensions of the objects for which a location must have space.

    A movable object may come to any open location. A spot has neither walls nor a rim: it needs space only for the
    objects that start there or, if none does, for the least sides of all, since its neighbours decide what fits.
    """
    first = [shapes[obj.name] for obj in model.objects if obj.name in shapes and obj.start == place.name]
    movable = [shapes[obj.name] for obj in model.objects if obj.name in shapes and not (obj.fixed or place.closed)]
    size = extent([*first, *movable])
    if _kind(place) != "spot" or place.at is None or not (first or movable):
        return size
    if first:
        tight = extent(first)
        taken = len(first) == place.capacity
        return replace(size, half=tight.half, clear=tight.high, opening=tight.opening, taken=taken)
    each = [extent([shape]) for shape in movable]
    least = np.min([one.half for one in each], axis=0)
    return replace(size, half=least, clear=size.low, opening=min(one.opening for one in each))


def _kind(place: Location) -> str:
    return place.kind or ("pad" if place.marks else "spot")


def _yaws(place: Location, grounded: list[Location], robot: Robot) -> list[float]:
    """Return closing directions to try, rad: past a near neighbour, y, x, across the arm, along it, and diagonal."""
    here = np.array(with_height(place.at or ()))
    bearing = float(np.arctan2(*(here - robot.position)[1::-1]))
    yaws = [np.pi / 2, 0.0, bearing + np.pi / 2, bearing, np.pi / 4, 3 * np.pi / 4]
    apart = [np.array(with_height(other.at or ())) - here for other in grounded if other.name != place.name]
    nearest = min(apart, key=np.linalg.norm, default=np.full(3, np.inf))
    if np.linalg.norm(nearest) < NEIGHBOUR_DISTANCE_M:
        yaws.insert(0, float(np.arctan2(-nearest[0], nearest[1]) % np.pi))
    return yaws


def _within_reach(arm: Arm, station: Station) -> bool:
    """Return whether the arm reaches the middle of the lowest object at each slot with the slot's yaw."""
    try:
        for slot in station.slots:
            arm.reach(ToolPose.down(slot.position + [0.0, 0.0, station.size.low / 2], slot.yaw).symmetric_poses())
    except SimulationError:
        return False
    return True


def _station(place: Location, yaw: float, gripper: Gripper, size: Extent) -> Station:
    kind = _kind(place)
    check_known(f"locations.{place.name}.kind", "kind", kind, FLOOR, SimulationError)
    centre = np.array(place.at, dtype=float)[:2]
    across = np.array([-np.sin(yaw), np.cos(yaw)])
    pitch = _pitch(gripper, size)
    if place.capacity * pitch > LARGEST_M:
        length = f"{place.capacity * pitch:.0f} m long, at most {LARGEST_M}"
        raise SimulationError(f"locations.{place.name}.capacity: a row of {place.capacity} objects would be {length}")
    offsets = (np.arange(place.capacity) - (place.capacity - 1) / 2) * pitch
    row = np.array([0.0, offsets[-1]])
    half = size.half + row
    if kind in ("pad", "stove"):
        half = half + PAD_MARGIN_M
    elif kind == "bin":
        inside = size.opening / 2 + gripper.finger_depth_m + 0.004
        half = np.maximum(half + BIN_MARGIN_M, inside)
    elif kind == "plate":
        half = float(np.hypot(*size.half)) + PLATE_MARGIN_M + row
    radius = AT_RADIUS_M if kind == "spot" else min(AT_RADIUS_M, float(half.min()))
    slots = tuple(
        Slot(place.name, i, np.array([*(centre + offset * across), place.height + FLOOR[kind]]), yaw, radius)
        for i, offset in enumerate(offsets)
    )
    return Station(place.name, kind, Rectangle(centre, half, yaw), slots, size, place.height, bool(place.marks))


def _pitch(gripper: Gripper, size: Extent) -> float:
    """Return the distance between neighbouring slots, m: the palm over a low object must clear a high neighbour."""
    pitch = 2 * float(size.half[1]) + ROW_GAP_M
    if size.high > size.low / 2 + gripper.palm_height_m:
        pitch = max(pitch, float(size.half[1] + gripper.palm_half_width_m))
    return pitch


def _stack(
    place: Location,
    model: ManipulationModel,
    slots: dict[str, tuple[Slot, ...]],
    shapes: dict[str, ObjectShape],
    sizes: Mapping[str, Extent],
) -> None:
    """Add the slot of a location on others, whose slots come first: midway between them and one object higher."""
    if place.name in slots or place.at is not None:
        return
    where = f"locations.{place.name}"
    if place.capacity > 1:
        raise SimulationError(f"{where}.capacity: what lies on other objects has room for 1, not {place.capacity}")
    if place.kind or place.marks:
        key = "kind" if place.kind else "marks"
        raise SimulationError(f"{where}.{key}: only a location on the table can have one")
    for support in place.on:
        _stack(model.location(support), model, slots, shapes, sizes)
        if support not in slots:
            return  # reported there
        if len(slots[support]) > 1:
            raise SimulationError(
                f"{where}.on: {support!r} has room for {len(slots[support])}, so nothing has a fixed place on it"
            )
    below = [slots[support][0] for support in place.on]
    position = np.mean([slot.position for slot in below], axis=0)
    lying = [obj.name for obj in model.objects if obj.name in shapes and (not obj.fixed or obj.start == place.name)]
    sides = [shapes[name].half[:2] for name in lying] or [np.full(2, CUBE_EDGE_M / 2)]
    for slot in below:
        if abs(slot.position[2] - position[2]) > 1e-6:
            raise SimulationError(f"{where}.on: {below[0].location!r} and {slot.location!r} differ in height")
        apart = position[:2] - slot.position[:2]
        axes = Rectangle(slot.position[:2], np.zeros(2), slot.yaw).axes
        most = sizes[slot.location].slim - SUPPORT_OVERLAP_M
        if all(np.any(np.abs(axes @ apart) > most + half) for half in sides):
            longest = max(float(half.max()) for half in sides)
            raise SimulationError(
                f"{where}.on: its middle is {np.hypot(*apart):.3f} m from {slot.location!r}, so an object of "
                f"{2 * longest:.3f} m would not rest on it: at most {longest + most:.3f} m"
            )
    if len(below) > 1:
        _check_level(place, model, shapes)
    high = max(sizes[slot.location].high for slot in below)
    slots[place.name] = (Slot(place.name, 0, position + [0.0, 0.0, high], below[0].yaw),)


def _check_level(place: Location, model: ManipulationModel, shapes: dict[str, ObjectShape]) -> None:
    """Raise `SimulationError` unless there are as many objects of one height as a location has supports."""
    heights = {name: shape.height for name, shape in shapes.items()}
    under = [obj.name for obj in model.objects if obj.name in shapes and (not obj.fixed or obj.start in place.on)]
    under.sort(key=heights.__getitem__)
    level = any(
        heights[high] - heights[low] <= MAX_HEIGHT_DIFFERENCE_M
        for low, high in zip(under, under[len(place.on) - 1 :], strict=False)
    )
    if under and not level:
        low, high = under[0], under[-1]
        raise SimulationError(
            f"locations.{place.name}.on: what rests on {len(place.on)} objects needs them equally high, but {low!r} is "
            f"{heights[low]:g} m high and {high!r} {heights[high]:g} m"
        )
