"""The shapes of objects: cubes, boxes, cylinders and meshes, and the orientations in which they look the same."""

import functools
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from prefplan.errors import check_known
from prefplan.models.manipulation.model import Object
from sim.errors import SimulationError
from sim.external.body_parts import parts_of
from sim.external.meshes import MeshParts, mesh_of
from sim.external.user_scene import UserScene
from sim.geometry.antipodes import Antipodes, antipodes
from sim.geometry.point_cloud import PointCloud
from sim.geometry.seats import Seat, seats
from sim.robots.gripper import PAD_CLEARANCE_M, Gripper, SuctionGripper

SIZES = {
    "cube": ("edge",),
    "box": ("length along x", "length along y", "height"),
    "cylinder": ("diameter", "height"),
    "mesh": ("length along x", "length along y", "height"),
}
"""Kinds of objects, and the lengths in their `size`; that of a mesh comes from its file."""

LARGEST_M = 20
"""Greatest length of an object, of a row of them or of a fixture, m; greater ones are probably in millimetres."""

CUBE_EDGE_M = 0.045
"""Edge of an object without a given size, m: the open hand has clearance on both sides."""

DENSITY_KG_M3 = 0.055 / CUBE_EDGE_M**3
"""Density, about that of beech: a cube of `CUBE_EDGE_M` weighs 55 g."""

MASSES_KG = (0.020, 0.250)
"""Least and greatest default mass of an object, kg."""

USUAL_OPENING_M = 0.07
"""Width of the open hand, m: 12 mm on either side of a default cube, and the fingers still fit into a bin."""

ROUND_TURNS = 16
"""Number of turns of a round object about the vertical that are tried."""

_MIRRORED = [
    np.eye(3)[list(order)] * np.array(signs)[:, None]
    for order, signs in itertools.product(itertools.permutations(range(3)), itertools.product((1.0, -1.0), repeat=3))
]

QUARTER_TURNS = np.array([turn for turn in _MIRRORED if np.linalg.det(turn) > 0])
"""(24, 3, 3) rotations that turn a cube into itself, the identity first."""


@dataclass(frozen=True, eq=False)
class ObjectShape:
    """A cube, box, cylinder or mesh in a frame of its own, in which it stands upright.

    Its yaw is the heading of its x axis: the preferred closing direction from above.

    Attributes:
        kind: one of `SIZES`.
        half: (3,) half its sides along x, y and z, m.
        widths: in the closing directions of fingers from above, the preferred one first, m; none for a suction cup.
        symmetry: the turn about z after which it looks the same, rad; 0 for any.
        mass: kg.
        turned: whether its x axis is the y axis of its file or of its body in the user's scene.
        surface: of a mesh, if the gripper has fingers; else None.
        pairs: opposite patches of that surface, which pads can press.
        seats: flat places of a mesh, if the gripper is a suction cup; else none.
        corners: (K, 3) vertices of the convex hull of a mesh, m; None for other shapes.
    """

    kind: str
    half: np.ndarray
    widths: tuple[float, ...]
    symmetry: float
    mass: float
    turned: bool = False
    surface: PointCloud | None = None
    pairs: tuple[Antipodes, ...] = ()
    seats: tuple[Seat, ...] = ()
    corners: np.ndarray | None = None

    @property
    def height(self) -> float:
        """Its full height, m."""
        return 2 * float(self.half[2])

    @property
    def is_round(self) -> bool:
        """Whether it looks the same after any turn about its own z axis."""
        return self.symmetry == 0

    @property
    def is_heavy(self) -> bool:
        """Whether it is heavier than any object of default mass."""
        return self.mass > MASSES_KG[1]

    @functools.cached_property
    def symmetries(self) -> np.ndarray:
        """(K, 3, 3) rotations after which it looks the same, identity first; turns about a round one's z left out."""
        if self.is_round:
            return np.array([np.eye(3), np.diag([1.0, -1.0, -1.0])])
        if self.symmetry > math.pi:
            return np.eye(3)[None]
        kept = np.isclose(np.abs(QUARTER_TURNS) @ self.half, self.half).all(axis=1)
        return QUARTER_TURNS[kept]

    def support(self, direction: np.ndarray) -> float:
        """Return how far it extends from its middle in a (3,) direction of its own frame, m."""
        if self.corners is not None:
            return float((self.corners @ direction).max())
        slopes = np.abs(direction)
        if self.is_round:
            slopes = np.array([np.hypot(*slopes[:2]), 0.0, slopes[2]])
        return float(slopes @ self.half)

    def depth(self, rotation: np.ndarray) -> float:
        """Return how far it reaches below its middle, m, with (3, 3) axes in the world frame."""
        return self.support(-rotation[2])

    def distance(self, point: np.ndarray) -> float:
        """Return how far a (3,) point of its own frame is from it, m; 0 inside."""
        beside = np.abs(point)
        if self.is_round:
            beside = np.array([np.hypot(*beside[:2]), 0.0, beside[2]])
        return float(np.linalg.norm(np.maximum(beside - self.half, 0.0)))

    def most_upright(self, rotation: np.ndarray) -> np.ndarray:
        """Return the most upright of the (3, 3) rotations in which it looks as it does in `rotation`."""
        heights = self.symmetries[:, :, 2] @ rotation[2]
        return np.asarray(rotation @ self.symmetries[int(heights.argmax())])

    def heading_to(self, rotation: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Return a (3, 3) rotation with a round object's x axis turned as near as possible to a (3,) direction.

        Other objects keep their rotation, and so does a round one if the direction is zero or along its axis.
        """
        x = direction - (direction @ rotation[:, 2]) * rotation[:, 2]
        length = np.linalg.norm(x)
        if not self.is_round or length < 1e-9:
            return rotation
        return np.column_stack([x / length, np.cross(rotation[:, 2], x / length), rotation[:, 2]])

    def standing(self, yaw: float) -> np.ndarray:
        """Return the (K, 3, 3) rotations in which it stands on a face, aligned with a heading, rad."""
        turns = yaw + (np.arange(ROUND_TURNS) * 2 * np.pi / ROUND_TURNS if self.is_round else np.zeros(1))
        return np.concatenate([about_z(turn) @ self.symmetries for turn in turns])

    def yaw_near(self, yaw: float, heading: float) -> float:
        """Return the yaw nearest to a heading, rad, at which it looks as it does at `yaw`."""
        if self.is_round:
            return heading
        return yaw + self.symmetry * round((heading - yaw) / self.symmetry)


def about_z(turn: float) -> np.ndarray:
    """Return the (3, 3) rotation about the vertical, rad."""
    c, s = np.cos(turn), np.sin(turn)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def opening(width: float) -> float:
    """Return the usual width of the open hand, m, for an object of a width, m."""
    return max(USUAL_OPENING_M, width + 2 * PAD_CLEARANCE_M)


def shape_of(obj: Object, gripper: Gripper, folder: Path = Path(), own: UserScene | None = None) -> ObjectShape:
    """Return the shape of an object; sides of a mesh are those of its bounding box.

    Mesh files are in `folder`. An object that is a body of the user's own scene must have been `resolved`. Raises
    `SimulationError` for an unknown kind, or a movable object that the gripper cannot hold; the message starts with
    its key.
    """
    where = f"objects.{obj.name}"
    check_known(f"{where}.kind", "kind", obj.kind, SIZES, SimulationError)
    mesh = mesh_of(obj, folder) if obj.kind == "mesh" and obj.size is None else None
    size = mesh.size if mesh is not None else _checked_size(obj, where)
    if obj.kind == "mesh" and obj.body is not None and own is not None:
        mesh = parts_of(own, obj.body)
    if obj.kind == "cylinder":
        x, height = size
        y, volume = x, math.pi / 4 * x**2 * height
    else:
        x, y, height = size * 3 if len(size) == 1 else size
        volume = x * y * height
    low, high = gripper.held_lengths["wide"]
    along, across = (y, x) if low <= y <= high else (x, y)
    fingers = not isinstance(gripper, SuctionGripper)
    closing = tuple(width for width in (along, across) if fingers and low <= width <= high)
    symmetry = {"cylinder": 0.0, "mesh": 2 * math.pi}.get(obj.kind, math.pi / 2 if along == across else math.pi)
    mass = obj.mass or float(np.clip(DENSITY_KG_M3 * volume, *MASSES_KG))
    half = np.array([along, across, height]) / 2
    shape = ObjectShape(obj.kind, half, closing, symmetry, mass, turned=along != x)
    if mesh is None:
        _check_lengths(obj, where, gripper, {"wide": along, "high": height, "long": across})
        return shape
    _check_lengths(obj, where, gripper, {"high": height, "long": max(x, y)})
    mesh = mesh.turned_back if shape.turned else mesh
    shape = replace(shape, corners=mesh.corners)
    return shape if obj.fixed else _held_mesh(shape, mesh, gripper, f"{where}.{'body' if obj.body else 'file'}")


def _held_mesh(shape: ObjectShape, mesh: MeshParts, gripper: Gripper, where: str) -> ObjectShape:
    """Return the shape of a mesh with the places that a gripper can press; raise `SimulationError` if it has none."""
    if isinstance(gripper, SuctionGripper):
        found = seats(
            mesh.parts,
            half_width=gripper.finger_half_width_m,
            hand_half_width=gripper.palm_half_width_m,
            hand_height=gripper.palm_height_m,
        )
        if not found:
            width = 2 * gripper.finger_half_width_m
            raise SimulationError(f"{where}: it is nowhere flat over {width:g} x {width:g} m, as the suction cup needs")
        return replace(shape, seats=found)
    low, high = gripper.held_lengths["wide"]
    pairs = antipodes(mesh.surface, low, high)
    if not any(pair.direction[2] == 0 for pair in pairs):
        raise SimulationError(
            f"{where}: no two upright faces of it that the hand could press lie {low:g} to {high:g} m apart"
        )
    return replace(shape, surface=mesh.surface, pairs=pairs, widths=(max(pair.width for pair in pairs),))


def _check_lengths(obj: Object, where: str, gripper: Gripper, lengths: Mapping[str, float]) -> None:
    """Raise `SimulationError` for lengths, m, that a gripper cannot hold; `wide` is along the closing direction.

    A fixed object is never grasped, so it may have any.
    """
    for adjective, length in () if obj.fixed else lengths.items():
        low, high = gripper.held_lengths[adjective]
        if not low <= length <= high:
            limits = f"{low:g} to {high:g} m" if math.isfinite(high) else f"at least {low:g} m"
            key = "body" if obj.body else "scale" if obj.kind == "mesh" else "size"
            raise SimulationError(
                f"{where}.{key}: {length:g} m {adjective}, but the hand grasps objects of {limits} {adjective}"
            )


def _checked_size(obj: Object, where: str) -> tuple[float, ...]:
    """Return the `size` of an object, m; raise `SimulationError` unless it is complete and positive."""
    if obj.size is None and obj.kind == "cube":
        return (CUBE_EDGE_M,)
    meaning = f"a {obj.kind} has {', '.join(SIZES[obj.kind])}, in metres"
    if obj.size is None:
        raise SimulationError(f"{where}.size: missing; {meaning}")
    if len(obj.size) != len(SIZES[obj.kind]):
        raise SimulationError(f"{where}.size: {meaning}, not {list(obj.size)}")
    if not all(math.isfinite(length) and length > 0 for length in obj.size):
        raise SimulationError(f"{where}.size: must be positive, not {list(obj.size)}")
    if max(obj.size) > LARGEST_M:
        raise SimulationError(f"{where}.size: must be metres, at most {LARGEST_M}, not {list(obj.size)}")
    return obj.size
