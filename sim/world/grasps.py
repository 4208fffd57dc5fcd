"""Grasps: poses of the hand relative to an object, derived from the object's shape and the gripper."""

import functools
import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from sim.geometry.point_cloud import PointCloud
from sim.geometry.seats import Seat
from sim.motion.trajectory import ToolPose
from sim.robots.gripper import MAX_LIFT_M, PAD_CLEARANCE_M, Gripper, SuctionGripper
from sim.world.shapes import ObjectShape, opening

TIGHT_CLEARANCE_M = 0.0025
"""Least distance from an object to either pad where space is tight, m: larger than the error of a sensed position."""

CLEARANCES_M = (None, PAD_CLEARANCE_M, TIGHT_CLEARANCE_M)
"""Clearances of the open hand to try in turn, m; None for the usual opening."""

TILTED_LIFTS_M = (0.0, 0.004, 0.010)
"""Distances by which a tilted hand is drawn back from the object's middle, m: the fingertips clear what is below."""

MAX_SHIFT_M = 0.018
"""Greatest shift of a tilted grasp along a high object, m: the palm clears the object's end, and the hand the table."""

END_M = 0.02
"""Least distance from a shifted grasp to the object's end, m."""

MAX_OFFSET_M = 0.027
"""Greatest distance from the pads' middle to the object's middle in a shifted grasp, m."""

MAX_OFF_LINE_M = 0.0075
"""Greatest distance from the pads' middle to their line of contact with a round object, m; the Panda's pads are 18 mm
high."""

PALM_TOLERANCE_M = 0.004
"""By how much an object may exceed the gripper's `palm_height_m` in a tilted grasp, m."""

MAX_BULGE_M = 0.0015
"""How far a surface may protrude beside the patch that a pad presses, m."""

TILTS_RAD = np.radians([0, 30, -30, 45, -45, 60, -60, 90, -90, 120, -120, 135, -135, 150, -150, 180])
"""Rotations of the hand about the closing direction; at 0, it points down at the upright object."""

MAX_TILT_RAD = np.radians(91)
"""Greatest tilt of the hand from straight down: beyond, it would point upwards."""

TILT_STEP_RAD = np.radians(15)
"""Resolution at which tilts of the hand are compared."""

MAX_SLOPE = np.sin(np.radians(15))
"""Greatest slope (sine) of the closing direction: beyond, one finger would be below the object."""


@dataclass(frozen=True, eq=False)
class GraspPose:
    """A pose of the tool frame, relative to an object, at which the fingers close on the object; see `ToolPose`.

    `width` is the object's width between the pads, m. `clearance` is the distance from the object to each pad of the
    open hand, m; None for the usual opening.
    """

    position: np.ndarray
    rotation: np.ndarray
    width: float
    clearance: float | None = None

    @property
    def opening(self) -> float:
        """Width to which the hand opens before the grasp, m."""
        return opening(self.width) if self.clearance is None else self.width + 2 * self.clearance

    def at(self, position: np.ndarray, rotation: np.ndarray) -> ToolPose:
        """Return the tool's pose if the object's frame is at a (3,) position, m, with a (3, 3) rotation."""
        return ToolPose(position + rotation @ self.position, rotation @ self.rotation)


def openings(grasp: GraspPose) -> tuple[GraspPose, ...]:
    """Return a grasp with each of `CLEARANCES_M`: the hand opens less and less."""
    return tuple(replace(grasp, clearance=clearance) for clearance in CLEARANCES_M)


@functools.lru_cache(maxsize=256)
def grasps(shape: ObjectShape, gripper: Gripper) -> tuple[GraspPose, ...]:
    """Return the grasps of an object by increasing tilt, those from above first.

    The hand closes along a side of a box or across a cylinder; the palm must clear the object. For each tilt, the usual
    opening comes first, then narrower ones. A hand that points straight down also grasps with the pads higher on the
    object, and a tilted hand also near an end of a high object.
    """
    if isinstance(gripper, SuctionGripper):
        return _suctions(shape, gripper)
    if shape.surface is not None:
        return _on_surface(shape, shape.surface, gripper)
    found = []
    for (rank, closing, width), tilt in itertools.product(_closings(shape, gripper), TILTS_RAD):
        rotation, off_top = _hand(closing, tilt)
        approach = rotation[:, 2]
        variants = _variants(shape, approach, gripper, straight=off_top == 0)
        for (order, lift, clearance), shift in itertools.product(variants, _shifts(shape, closing, approach, gripper)):
            off_line = lift * float(np.hypot(*approach[:2])) if shape.is_round and not closing[2] else 0.0
            position = shift - lift * approach
            palm = shape.support(-approach) + float(position @ approach)
            near = not shift.any() or np.linalg.norm(position) <= MAX_OFFSET_M
            if off_line <= MAX_OFF_LINE_M and palm <= gripper.palm_height_m + PALM_TOLERANCE_M and near:
                key = off_top, rank > 1, order, bool(shift.any()), lift, rank
                found.append((key, GraspPose(position, rotation, width, clearance)))
    found.sort(key=lambda entry: entry[0])
    return tuple(grasp for _, grasp in found)


def _hand(closing: np.ndarray, tilt: float) -> tuple[np.ndarray, int]:
    """Return the (3, 3) axes of a hand turned about its closing direction, rad, and its tilt from above, degrees."""
    start = np.array([-1.0, 0.0, 0.0] if closing[2] else [0.0, 0.0, -1.0])
    approach = np.cos(tilt) * start + np.sin(tilt) * np.cross(closing, start)
    return _axes(closing, approach), round(np.degrees(np.arccos(np.clip(-approach[2], -1, 1))))


def _axes(closing: np.ndarray, approach: np.ndarray) -> np.ndarray:
    """Return the (3, 3) axes of the hand from its closing and approach directions, (3,) each."""
    return np.column_stack([np.cross(closing, approach), closing, approach])


def _on_surface(shape: ObjectShape, surface: PointCloud, gripper: Gripper) -> tuple[GraspPose, ...]:
    """Return the grasps of a mesh at its `Antipodes` in which the hand does not collide with it."""
    found = []
    for pair, tilt in itertools.product(shape.pairs, TILTS_RAD):
        rotation, off_top = _hand(pair.direction, tilt)
        seen = (surface.points - pair.position) @ rotation
        off_centre = round(float(np.linalg.norm(pair.position - surface.centre)), 3)
        for order, clearance in enumerate(CLEARANCES_M):
            grasp = GraspPose(pair.position, rotation, pair.width, clearance)
            if not _obstructing(seen, grasp, gripper).any():
                found.append(((off_top, off_centre, order), grasp))
    found.sort(key=lambda entry: entry[0])
    return tuple(grasp for _, grasp in found)


def _obstructing(points: np.ndarray, grasp: GraspPose, gripper: Gripper) -> np.ndarray:
    """Return which of (N, 3) points in the tool frame, m, are in the palm or in the space swept by a closing finger."""
    x, y, z = np.abs(points[:, 0]), np.abs(points[:, 1]), points[:, 2]
    end = min(grasp.opening, gripper.opening_m) / 2 + gripper.finger_depth_m
    finger = (x < gripper.finger_half_width_m) & (y > grasp.width / 2 + MAX_BULGE_M) & (y < end)
    palm = (x < gripper.palm_half_width_m) & (z < -gripper.palm_height_m)
    return palm | finger & (z < gripper.fingertip_m)


def _suctions(shape: ObjectShape, gripper: SuctionGripper) -> tuple[GraspPose, ...]:
    """Return the grasps by a suction cup on each seat of a mesh, or flat face of another shape, the top one first."""
    found = []
    for seat in sorted(shape.seats, key=lambda seat: round(-seat.normal[2], 2)) or _faces(shape, gripper):
        # Two headings of the hand, each as close as possible to an axis of the object.
        for axis in np.eye(3)[np.argsort(np.abs(seat.normal), kind="stable")[:2]]:
            closing = axis - (axis @ seat.normal) * seat.normal
            closing /= np.linalg.norm(closing)
            position = seat.position - gripper.press_m * seat.normal
            found.append(GraspPose(position, _axes(closing, -seat.normal), 0.0, gripper.opening_m / 2))
    return tuple(found)


def _faces(shape: ObjectShape, gripper: SuctionGripper) -> list[Seat]:
    """Return the middles of the flat faces that a suction cup fits on, the top one first."""
    found = []
    for normal in (*np.eye(3)[::-1], *-np.eye(3)[::-1]):
        beside = [axis for axis in np.eye(3) if not axis @ normal]
        fits = all(shape.support(axis) >= gripper.finger_half_width_m for axis in beside)
        if fits and (normal[2] or not shape.is_round):
            found.append(Seat(shape.support(normal) * normal, normal))
    return found


def _closings(shape: ObjectShape, gripper: Gripper) -> Iterator[tuple[int, np.ndarray, float]]:
    """Yield each closing direction: its rank, the direction itself, (3,) in the object's frame, and the width, m."""
    if shape.is_round:
        headings = np.radians([0, 90, 45, 135, 22.5, 67.5, 112.5, 157.5])
        closings = [np.array([np.cos(heading), np.sin(heading), 0.0]) for heading in headings]
    else:
        closings = [*np.eye(3)[:2]]
    low, high = gripper.held_lengths["wide"]
    for rank, closing in enumerate([*closings, np.array([0.0, 0.0, 1.0])]):
        width = 2 * shape.support(closing)
        if low <= width <= high:
            yield rank, closing, width


def _shifts(shape: ObjectShape, closing: np.ndarray, approach: np.ndarray, gripper: Gripper) -> list[np.ndarray]:
    """Return the offsets of a grasp from the object's middle, (3,) m: none, or towards the side of the approach."""
    along = np.round(approach[2], 6)
    if shape.half[2] <= gripper.palm_height_m or closing[2] or abs(along) == 1:
        return [np.zeros(3)]
    shift = min(MAX_SHIFT_M, float(shape.half[2]) - END_M)
    return [np.zeros(3), *(np.array([0.0, 0.0, end * shift]) for end in (1.0, -1.0) if end * along <= 0)]


def _variants(
    shape: ObjectShape, approach: np.ndarray, gripper: Gripper, *, straight: bool
) -> Iterator[tuple[int, float, float | None]]:
    """Yield a rank, the distance by which the hand is drawn back from the object's middle, m, and the clearance, m."""
    top = shape.support(approach)
    low, high = max(0.0, top - gripper.palm_height_m), min(top, MAX_LIFT_M)
    for order, clearance in enumerate(CLEARANCES_M):
        lifts = ((low,) if clearance is None else (low, high)) if straight else TILTED_LIFTS_M
        for lift in lifts:
            yield order, lift, clearance


def ranked(shape: ObjectShape, gripper: Gripper, frame: np.ndarray) -> Iterator[GraspPose]:
    """Yield the grasps that can pick up an object with (3, 3) axes `frame` and set it upright.

    They are ordered by the hand's tilt at the pick or when the object is set upright, whichever is greater.
    """
    options = grasps(shape, gripper)
    rotations = np.array([grasp.rotation for grasp in options])
    turned = frame @ rotations
    # Once the object is upright, the third row of its rotation gives the slopes of the hand's axes.
    final = np.einsum("ki,nij->knj", shape.symmetries[:, 2], rotations)
    final_tilts = np.where(np.abs(final[:, :, 1]) < MAX_SLOPE, tilts_of(final[:, :, 2]), np.inf).min(axis=0)
    tilts = np.where(np.abs(turned[:, 2, 1]) < MAX_SLOPE, np.maximum(tilts_of(turned[:, 2, 2]), final_tilts), np.inf)
    for i in np.argsort(np.round(tilts / TILT_STEP_RAD), kind="stable"):
        if tilts[i] <= MAX_TILT_RAD:
            yield options[i]


def tilt_of(rotation: np.ndarray) -> float:
    """Return the tilt of a hand with (3, 3) axes, rad; infinite if it cannot grasp anything that lies on a surface."""
    tilt = float(tilts_of(rotation[2, 2]))
    return tilt if tilt <= MAX_TILT_RAD and abs(rotation[2, 1]) < MAX_SLOPE else np.inf


def tilts_of(steepness: np.ndarray) -> np.ndarray:
    """Return the tilts from straight down, rad, of hands whose approach directions have these vertical components."""
    return np.asarray(np.arccos(np.clip(-steepness, -1.0, 1.0)))
