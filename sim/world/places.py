"""Stations, slots and the layout of a model, and the dimensions of the objects for which there is space."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from prefplan.models.manipulation.model import ManipulationModel
from sim.geometry.rectangle import Rectangle
from sim.world.shapes import CUBE_EDGE_M, ObjectShape, opening

AT_RADIUS_M = 0.045
"""Greatest horizontal distance of an object at a slot from the slot's centre, m: a block's width."""

OBJECT_GAP_M = 0.005
"""Least gap to the neighbours of an object that is put down, m."""

START_OFFSET_M = 0.005
"""Greatest random offset of objects at the start from their slots, along x and along y, m."""

START_TURN_RAD = np.radians(5)
"""Greatest random turn of objects at the start, rad."""

FLOOR = {"spot": 0.0, "pad": 0.004, "bin": 0.003, "stove": 0.012, "plate": 0.006}
"""Kinds of locations (an outline, a sheet of metal, a box with walls, a hob, a dish), each with the height above the
table of the surface that objects rest on, m."""


@dataclass(frozen=True)
class Extent:
    """Bounds on the dimensions of the objects that may come to a location.

    Attributes:
        half: (2,) greatest half sides along the closing direction and across it, m.
        slim: least half side of any, m.
        low: least height of any, m.
        high: greatest height of any, m.
        clear: height that must be free above the surface, m.
        opening: greatest width of the open hand, m; 0 for a suction cup.
        taken: whether `half` and `clear` are those of the objects that fill the location at the start.
    """

    half: np.ndarray
    slim: float
    low: float
    high: float
    clear: float
    opening: float
    taken: bool = False


@dataclass(frozen=True)
class Slot:
    """Where one object rests.

    Attributes:
        location: the location it belongs to.
        index: 0 .. capacity - 1 within the location.
        position: (3,) where the middle of the object's underside rests, m (z = 0 is the table top).
            On other objects, z is the greatest possible: see `sim.perception.grounding.slot_of`.
        yaw: heading about z of the closing direction, rad; the fingers have space on either side.
            The object rests with this yaw, up to its symmetry.
        radius: greatest horizontal distance from the slot's centre at which an object counts as resting in it, m;
            farther off, it would be beside a small plate.
    """

    location: str
    index: int
    position: np.ndarray
    yaw: float
    radius: float = AT_RADIUS_M


@dataclass(frozen=True)
class Station:
    """A location on the table or on a fixture, with what stands there.

    Attributes:
        kind: a key of `FLOOR`.
        outline: area of the table that it covers, without walls.
        slots: side by side across the closing direction.
        size: bounds on the objects that may come there.
        height: height above the table top of the surface that carries it, m.
        marks: whether it marks objects released there.
    """

    name: str
    kind: str
    outline: Rectangle
    slots: tuple[Slot, ...]
    size: Extent
    height: float = 0.0
    marks: bool = False


@dataclass(frozen=True)
class TableLayout:
    """The stations and slots of a model, and the shapes of its objects.

    Attributes:
        stations: the locations on the table and on fixtures, in the order of the file.
        slots: for every location, in the order of the file, as many slots as its capacity.
        shapes: of every object, in the order of the file.
    """

    stations: tuple[Station, ...]
    slots: dict[str, tuple[Slot, ...]]
    shapes: dict[str, ObjectShape]


def extent(shapes: Iterable[ObjectShape]) -> Extent:
    """Return the bounds on the dimensions of shapes; without any, those of a cube of `CUBE_EDGE_M`."""
    cube = ObjectShape("cube", np.full(3, CUBE_EDGE_M / 2), (CUBE_EDGE_M,), symmetry=np.pi / 2, mass=0.0)
    known = list(shapes) or [cube]
    half = np.array([shape.half for shape in known])
    return Extent(
        half=half[:, :2].max(axis=0),
        slim=float(half[:, :2].min()),
        low=2 * float(half[:, 2].min()),
        high=2 * float(half[:, 2].max()),
        clear=2 * float(half[:, 2].max()),
        opening=max((opening(width) for shape in known for width in shape.widths), default=0.0),
    )


def under(model: ManipulationModel, location: str) -> list[str]:
    """Return the locations that a location lies on, directly or not, the upper ones first."""
    direct = list(model.location(location).on)
    deeper = [lower for support in direct for lower in under(model, support)]
    return list(dict.fromkeys([*direct, *deeper]))


def lowest_under(model: ManipulationModel, location: str) -> str:
    """Return the lowest location under a location; the location itself if it lies on none or is not in the model."""
    return [location, *(under(model, location) if location in model.slot_counts else ())][-1]


def unused_names(model: ManipulationModel, stem: str, number: int, *, taken: Iterable[str] = ()) -> tuple[str, ...]:
    """Return names, such as `spot1`, that do not occur in any name or proposition of the model."""
    used = [obj.name for obj in model.objects] + [place.name for place in model.locations]
    used += [*model.marks, *model.propositions, *taken]
    while any(stem in name for name in used):
        stem += "_"
    return tuple(f"{stem}{i + 1}" for i in range(number))
