"""Which grasp: one that the arm reaches without a collision where the object is, and where it is put next."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from sim.errors import BlockedError, SimulationError
from sim.motion.trajectory import ToolPose, wrap
from sim.perception.sensors import DIAGONAL, ObjectPose, Posture
from sim.simulation.workcell import Workcell
from sim.skills.hand import (
    FINGER_CLEARANCE_M,
    FORESEEN_CLEARANCE_M,
    FORESEEN_MARGIN_RAD,
    PLACING_MARGIN_RAD,
    frame_of,
    free_pose,
    held_grasp,
)
from sim.skills.placing import free_slot, resting_centre
from sim.skills.skill import SkillError
from sim.world.grasps import MAX_SLOPE, MAX_TILT_RAD, GraspPose, grasps, openings, tilt_of, tilts_of
from sim.world.places import Slot
from sim.world.shapes import ObjectShape, about_z

TILT_STEP_RAD = np.radians(15)
"""Tilts of the hand that differ by less than this are equally good."""


Choice = tuple[GraspPose, ToolPose, ToolPose]
"""A grasp, the pose from which the hand comes, and that in which the fingers close."""


@dataclass
class Refusals:
    """Why no grasp serves.

    Attributes:
        blockers: what is in the way of grasps that the arm reaches.
        inside: grasps with which the hand alone would be inside something, whether or not the arm reaches them.
        unplaceable: whether one would do where the object is.
    """

    blockers: set[str] = field(default_factory=set)
    inside: list[GraspPose] = field(default_factory=list)
    unplaceable: bool = False


def choose_grasp(
    cell: Workcell,
    obj: str,
    pose: ObjectPose,
    yaw: float,
    *,
    tilted: bool = False,
    unlike: Sequence[ToolPose] = (),
) -> Choice:
    """Return what `find_grasp` does; arguments as there.

    Raises:
        BlockedError: bodies are in the way of all grasps.
        SimulationError: the arm reaches none, or none that serves.
    """
    refusals = Refusals()
    found = find_grasp(cell, obj, pose, yaw, tilted=tilted, unlike=unlike, refusals=refusals)
    if found is not None:
        return found
    if refusals.unplaceable:
        raise SimulationError(f"no grasp of {obj} lets the hand set it upright at {cell.destination}")
    frame = frame_of(pose, yaw)
    for grasp in refusals.inside:
        with suppress(SimulationError):
            _freely(cell, pose, frame, grasp, refusals.blockers)
    if refusals.blockers:
        raise BlockedError.beside_fingers(refusals.blockers)
    if next(ranked(cell, obj, frame), None) is None:
        raise SimulationError(f"{obj} stands or lies so that the hand cannot come to where it could hold it")
    raise SimulationError(f"{obj} is out of reach")


def find_grasp(
    cell: Workcell,
    obj: str,
    pose: ObjectPose,
    yaw: float,
    *,
    tilted: bool = False,
    unlike: Sequence[ToolPose] = (),
    foreseen: bool = True,
    certain: bool = False,
    refusals: Refusals | None = None,
) -> Choice | None:
    """Return the first grasp that serves, or None.

    It serves both where the object is, and where it is to be released next, if that is known and there is space now.
    What stands is taken even if none serves there.

    Args:
        cell: the running simulation.
        obj: the object.
        pose: as measured.
        yaw: heading of the preferred closing direction, rad.
        tilted: leave out grasps for which the hand points straight down.
        unlike: leave out grasps for which the hand points about as in one of these poses.
        foreseen: whether it shall serve where the object is released next.
        certain: whether it must serve there for what stands, too.
        refusals: why other grasps do not serve is added to them.
    """
    frame, refusals = frame_of(pose, yaw), refusals or Refusals()
    shape, slot = cell.scene.shapes[obj], _next_slot(cell, obj) if foreseen else None
    placeable: dict[bytes, bool] = {}
    first: Choice | None = None
    for grasp, before, tool in _free_grasps(cell, obj, pose, frame, refusals, tilted=tilted):
        if any(tool.rotation[:, 2] @ other.rotation[:, 2] > np.cos(TILT_STEP_RAD) for other in unlike):
            continue
        if slot is None:
            return grasp, before, tool
        alike = _placed_alike(shape, grasp)
        if alike not in placeable:
            placeable[alike] = _can_place(cell, obj, slot, grasp)
        if placeable[alike]:
            return grasp, before, tool
        first = first or (grasp, before, tool)
    refusals.unplaceable = first is not None
    return first if pose.posture == Posture.UPRIGHT and not certain else None


def _free_grasps(
    cell: Workcell, obj: str, pose: ObjectPose, frame: np.ndarray, refusals: Refusals, *, tilted: bool
) -> Iterator[Choice]:
    """Yield grasps that the arm reaches freely where the object is; add why it does not take others.

    Arguments and poses are those of `choose_grasp`; each grasp is turned as the hand then is.
    """
    for grasp in ranked(cell, obj, frame):
        tool = grasp.at(pose.position, frame)
        if tilted and tool.points_down:
            continue
        if all(cell.hand_is_inside(goal, width=grasp.opening) for goal in tool.symmetric_poses()):
            refusals.inside.append(grasp)
            continue
        with suppress(SimulationError):
            yield _freely(cell, pose, frame, grasp, refusals.blockers)


def _freely(cell: Workcell, pose: ObjectPose, frame: np.ndarray, grasp: GraspPose, blockers: set[str]) -> Choice:
    """Return a grasp as the arm reaches it freely, see `free_pose`; add what is in its way to the blockers."""
    try:
        before, tool = free_pose(cell, grasp.at(pose.position, frame).symmetric_poses(), grasp, near=cell.reference)
    except BlockedError as error:
        blockers.update(error.by)
        raise
    return replace(grasp, rotation=frame.T @ tool.rotation), before, tool


def choose_placement(
    cell: Workcell,
    obj: str,
    slot: Slot,
    grasp: GraspPose,
    *,
    near: np.ndarray | None = None,
    margin: float,
    clearance: float = FINGER_CLEARANCE_M,
) -> tuple[ToolPose, ToolPose, float]:
    """Return the tool's pose that sets an object, so grasped, upright into a slot, the fingers free to open.

    Before it, the pose from which the hand comes straight to it; after it, how wide the hand can open there, m.

    Args:
        cell: the running simulation.
        obj: the object.
        slot: where it is put.
        grasp: how the hand holds it.
        near: (n,) where the arm comes from, rad; None for anywhere.
        margin: of a tilted hand from the ends of the joints, rad.
        clearance: of a tilted hand from other bodies, m.

    Raises:
        BlockedError: bodies are in the way.
        SimulationError: the arm does not reach it.
    """
    blockers: set[str] = set()
    unreachable = SimulationError(f"the hand would have to reach from below to set {obj} upright")
    for goals in _placements(cell.scene.shapes[obj], grasp, resting_centre(cell, obj, slot), slot.yaw):
        for option in openings(grasp):
            try:
                before, pose = free_pose(cell, goals, option, near=near, margin=margin, clearance=clearance)
                return before, pose, option.opening
            except BlockedError as error:
                blockers.update(error.by)
            except SimulationError as error:
                unreachable = error
                break
    if blockers:
        raise BlockedError.beside_fingers(blockers)
    raise unreachable


def choose_placement_of_held(cell: Workcell, obj: str, slot: Slot) -> tuple[ToolPose, ToolPose, float]:
    """Return, as `choose_placement` does, how the held object is set into a slot: upright, or else leaning as it hangs.

    Raises:
        BlockedError, SimulationError: as for `choose_placement`.
    """
    aloft = cell.contacts.aloft
    cell.contacts.handle(obj)  # not aloft: in the slot it touches what carries it

    def choose(grasp: GraspPose) -> tuple[ToolPose, ToolPose, float]:
        placement = partial(choose_placement, cell, obj, slot, grasp, margin=PLACING_MARGIN_RAD)
        try:
            return placement(near=cell.reference)
        except SimulationError:
            return placement()  # as it was foreseen: the nearest of equally good poses may be in the way of something

    try:
        return choose(held_grasp(cell, obj))
    except SimulationError:
        if cell.observe(obj).posture != Posture.LEANING:
            raise
        return choose(held_grasp(cell, obj, leaning=True))
    finally:
        cell.contacts.handle(obj, aloft=aloft)


def _next_slot(cell: Workcell, obj: str) -> Slot | None:
    """Return the slot into which an object is put next; None if that is not known, or it is taken now."""
    try:
        return free_slot(cell, obj, cell.destination) if cell.destination else None
    except SkillError:
        return None


def ranked(cell: Workcell, obj: str, frame: np.ndarray) -> Iterator[GraspPose]:
    """Yield the grasps of an object whose frame is turned so, those first for which the hand tilts least at both ends.

    In the end it stands upright.
    """
    shape = cell.scene.shapes[obj]
    options = grasps(shape, cell.scene.robot.gripper)
    rotations = np.array([grasp.rotation for grasp in options])
    turned = frame @ rotations
    # The third row of an upright rotation says how steep the hand points down in the end.
    final = np.einsum("ki,nij->knj", shape.symmetries[:, 2], rotations)
    final_tilts = np.where(np.abs(final[:, :, 1]) < MAX_SLOPE, tilts_of(final[:, :, 2]), np.inf).min(axis=0)
    tilts = np.where(np.abs(turned[:, 2, 1]) < MAX_SLOPE, np.maximum(tilts_of(turned[:, 2, 2]), final_tilts), np.inf)
    for i in np.argsort(np.round(tilts / TILT_STEP_RAD), kind="stable"):
        if tilts[i] <= MAX_TILT_RAD:
            yield options[i]


def _placements(shape: ObjectShape, grasp: GraspPose, centre: np.ndarray, yaw: float) -> Iterator[tuple[ToolPose, ...]]:
    """Yield groups of equally good poses of the tool that set an object upright, its (3,) centre at a given place, m.

    The less the hand tilts the better; then the closing direction that is nearest to a heading, rad, or square to it.
    """

    def rank(pose: ToolPose) -> tuple[int, int, int]:
        off = abs(wrap(pose.yaw - yaw, np.pi))
        tilt = round(float(tilts_of(pose.rotation[2, 2])) / TILT_STEP_RAD)
        return tilt, round(np.degrees(min(off, np.pi / 2 - off))), round(np.degrees(off))

    poses = (grasp.at(centre, rotation) for rotation in shape.standing(yaw))
    usable = [pose for pose in poses if np.isfinite(tilt_of(pose.rotation))]
    for _, group in itertools.groupby(sorted(usable, key=rank), key=rank):
        yield tuple(group)


def _placed_alike(shape: ObjectShape, grasp: GraspPose) -> bytes:
    """Return what is alike in grasps that put an object down alike: all but the opening and a round object's turn."""
    rotation, position = grasp.rotation, grasp.position
    if shape.is_round:
        closing = rotation[:, 1] if abs(rotation[2, 1]) < DIAGONAL else rotation[:, 2]
        turn = about_z(-float(np.arctan2(closing[1], closing[0])))
        rotation, position = turn @ rotation, turn @ position
    return (np.round([*rotation.ravel(), *position], 6) + 0.0).tobytes()


def _can_place(cell: Workcell, obj: str, slot: Slot, grasp: GraspPose) -> bool:
    try:
        choose_placement(cell, obj, slot, grasp, margin=FORESEEN_MARGIN_RAD, clearance=FORESEEN_CLEARANCE_M)
    except SimulationError:
        return False
    return True
