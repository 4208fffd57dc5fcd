"""The shapes of objects: cubes, boxes and cylinders, and how the hand takes them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from prefplan.errors import choices
from prefplan.models.manipulation.model import ManipulationModel, Object
from sim.errors import SimulationError
from sim.robots.robot import Gripper

SIZES = {"cube": ("edge",), "box": ("length along x", "length along y", "height"), "cylinder": ("diameter", "height")}
"""Kinds of objects, and what their `size` says."""

CUBE_EDGE_M = 0.045
"""Edge of an object of no given size, m: the open hand takes it with clearance on both sides."""

MIN_HELD_WIDTH_M = 0.005
"""Least commanded width of the hand that holds an object."""

MAX_LENGTH_M = 0.120
"""Greatest length of an object across the closing line: a longer one turns between the fingers."""

DENSITY_KG_M3 = 0.055 / CUBE_EDGE_M**3
"""Density of beech: a cube of usual size weighs 55 g."""

MASSES_KG = (0.020, 0.250)
"""Limits of an object's mass."""

USUAL_OPENING_M = 0.07
"""Width of the open hand, m: 12 mm to either side of a usual cube, and the fingers still fit into a bin."""

PAD_CLEARANCE_M = 0.0075
"""Least distance from an object to either pad of the open hand where there is space, m."""

TIGHT_CLEARANCE_M = 0.0025
"""... and where there is hardly any: a sensed position is off by less, m."""

MAX_GRIP_LIFT_M = 0.022
"""Greatest height of the pads' middle over an object's in a high grip, m: half of the pads hold a usual cube, 2 mm over
a bin's rim, and it is not so far from the tool that it would not count as held."""


@dataclass(frozen=True)
class Grip:
    """How the fingers close on an object.

    Attributes:
        turn: heading of their closing line from the object's own yaw, rad.
        width: of the object along it, m.
        clearance: distance from the object to either pad of the open hand, m; None for the usual opening.
        lift: height of the pads' middle over the object's, m.
    """

    turn: float
    width: float
    clearance: float | None = None
    lift: float = 0.0

    @property
    def opening(self) -> float:
        """Width of the hand that opens for it, m."""
        return opening(self.width) if self.clearance is None else self.width + 2 * self.clearance


@dataclass(frozen=True)
class ObjectShape:
    """An upright cube, box or cylinder. Its yaw is the heading of the line along which the fingers rather close.

    Attributes:
        kind: one of `SIZES`.
        half: (3,) half its sides along that line, across it and upwards, m.
        grips: usual grips, the better one first.
        symmetry: the turn about z after which it looks the same, rad; 0 for any.
        mass: kg.
    """

    kind: str
    half: np.ndarray
    grips: tuple[Grip, ...]
    symmetry: float
    mass: float

    @property
    def height(self) -> float:
        """Its whole height, m."""
        return 2 * float(self.half[2])

    @property
    def grip_variants(self) -> tuple[Grip, ...]:
        """Grips to try, the better one first: the usual ones, with the hand opened less and less, also near the top."""
        high = min(float(self.half[2]), MAX_GRIP_LIFT_M)
        narrow, tight = (
            [replace(grip, clearance=clearance, lift=lift) for lift in (0.0, high) for grip in self.grips]
            for clearance in (PAD_CLEARANCE_M, TIGHT_CLEARANCE_M)
        )
        return (*self.grips, *narrow, *tight)

    def depth(self, rotation: np.ndarray) -> float:
        """Return how far below its middle it reaches with its (3, 3) axes turned, m."""
        slopes = np.abs(rotation[2])
        if self.kind == "cylinder":
            slopes = np.array([np.hypot(*slopes[:2]), 0.0, slopes[2]])
        return float(slopes @ self.half)

    def yaw_near(self, yaw: float, line: float) -> float:
        """Return, of the yaws at which it looks as it does at `yaw`, the nearest to a line, rad."""
        if not self.symmetry:
            return line
        return yaw + self.symmetry * round((line - yaw) / self.symmetry)


@dataclass(frozen=True)
class Extent:
    """Bounds on the dimensions of the objects that may come to a location.

    Attributes:
        half: (2,) greatest half sides along the closing line and across it, m.
        slim: least half side of any, m.
        low: least height of any, m.
        high: greatest height of any, m.
        opening: greatest width of the open hand, m.
    """

    half: np.ndarray
    slim: float
    low: float
    high: float
    opening: float


def opening(width: float) -> float:
    """Return how wide the hand opens round what has a width, m."""
    return max(USUAL_OPENING_M, width + 2 * PAD_CLEARANCE_M)


def shapes_of(model: ManipulationModel, gripper: Gripper) -> dict[str, ObjectShape]:
    """Return the shape of every object.

    Raises:
        SimulationError: an object of an unknown kind, or that the hand cannot take. The message starts with its key.
    """
    return {obj.name: shape_of(obj, gripper) for obj in model.objects}


def shape_of(obj: Object, gripper: Gripper) -> ObjectShape:
    """Return the shape of an object, and how a gripper takes it.

    Raises:
        SimulationError: as in `shapes_of`.
    """
    where = f"objects.{obj.name}"
    if obj.kind not in SIZES:
        raise SimulationError(f"{where}.kind: unknown kind {obj.kind!r} {choices(obj.kind, SIZES)}")
    widths = gripper.squeeze_m + MIN_HELD_WIDTH_M, gripper.opening_m - 2 * PAD_CLEARANCE_M
    # A lower object has the finger tips touch the surface below it, a higher one touches the palm.
    heights = 2 * gripper.fingertip_m, 2 * gripper.palm_height_m
    size = _checked_size(obj, where)
    if obj.kind == "cylinder":
        diameter, height = size
        along = across = diameter
        volume = math.pi / 4 * diameter**2 * height
    else:
        x, y, height = size * 3 if len(size) == 1 else size
        along, across = (y, x) if widths[0] <= y <= widths[1] else (x, y)
        volume = x * y * height
    for length, adjective, (low, high) in (
        (along, "wide", widths),
        (height, "high", heights),
        (across, "long", (0.0, MAX_LENGTH_M)),
    ):
        if not low <= length <= high:
            limits = f"{low:g} to {high:g} m {adjective}"
            raise SimulationError(f"{where}.size: {length:g} m {adjective}, but the hand takes what is {limits}")
    turns = {0.0: along, math.pi / 2: across}
    grips = tuple(Grip(turn, width) for turn, width in turns.items() if widths[0] <= width <= widths[1])
    symmetry = 0.0 if obj.kind == "cylinder" else math.pi / 2 if along == across else math.pi
    mass = float(np.clip(DENSITY_KG_M3 * volume, *MASSES_KG))
    return ObjectShape(obj.kind, np.array([along, across, height]) / 2, grips, symmetry, mass)


def extent(shapes: Iterable[ObjectShape]) -> Extent:
    """Return the bounds on the dimensions of shapes; for none, those of a cube of usual size."""
    known = list(shapes)
    if not known:
        return Extent(np.full(2, CUBE_EDGE_M / 2), CUBE_EDGE_M / 2, CUBE_EDGE_M, CUBE_EDGE_M, opening(CUBE_EDGE_M))
    half = np.array([shape.half for shape in known])
    return Extent(
        half=half[:, :2].max(axis=0),
        slim=float(half[:, :2].min()),
        low=2 * float(half[:, 2].min()),
        high=2 * float(half[:, 2].max()),
        opening=max(grip.opening for shape in known for grip in shape.grips),
    )


def _checked_size(obj: Object, where: str) -> tuple[float, ...]:
    """Return the right number of positive lengths, m."""
    if obj.size is None and obj.kind == "cube":
        return (CUBE_EDGE_M,)
    meaning = f"a {obj.kind} has {', '.join(SIZES[obj.kind])}, in metres"
    if obj.size is None:
        raise SimulationError(f"{where}.size: missing; {meaning}")
    if len(obj.size) != len(SIZES[obj.kind]):
        raise SimulationError(f"{where}.size: {meaning}, not {list(obj.size)}")
    if not all(math.isfinite(length) and length > 0 for length in obj.size):
        raise SimulationError(f"{where}.size: must be positive, not {list(obj.size)}")
    return obj.size
