"""Choice of a grasp: the arm must reach it without a collision, where the object is and where it is put down next."""

import itertools
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from sim.errors import BlockedError, SimulationError
from sim.motion.trajectory import ToolPose, wrap
from sim.perception.sensors import DIAGONAL, ObjectPose
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
from sim.world.grasps import TILT_STEP_RAD, GraspPose, openings, ranked, tilt_of, tilts_of
from sim.world.places import Slot
from sim.world.shapes import ObjectShape, about_z


class ChosenGrasp(NamedTuple):
    """A grasp, its pre-grasp pose, and the pose of the tool in which the fingers close, or let go of the object."""

    grasp: GraspPose
    before: ToolPose
    tool: ToolPose


def _in_any_case(grasp: GraspPose) -> bool:
    return True


def choose_grasp(
    cell: Workcell,
    obj: str,
    pose: ObjectPose,
    yaw: float,
    destination: str | None,
    *,
    tilted: bool = False,
    unlike: Sequence[ToolPose] = (),
    briefly: bool = False,
) -> ChosenGrasp:
    """Return the grasp that `find_grasp` finds, or raise an error that says why there is none, unless `briefly`.

    Raises:
        BlockedError: bodies are in the way of grasps that the arm reaches.
        SimulationError: the arm reaches no grasp, or none with which the object can be put down next.
    """
    found = find_grasp(cell, obj, pose, yaw, destination=destination, tilted=tilted, unlike=unlike)
    if found is not None:
        return found
    if briefly:
        raise SimulationError(f"{obj} cannot be grasped")
    frame, collisions = frame_of(pose, yaw), list[Collection[str]]()
    if any(_free_grasps(cell, obj, pose, frame, _candidates(cell, obj, pose, frame, tilted), unlike, collisions)):
        where = f" at {destination}" if destination is not None else ""
        raise SimulationError(f"{obj} cannot be set upright{where} in any grasp")
    if collisions:
        raise BlockedError.beside_fingers(collisions, movable=cell.scene.model.movable)
    if next(ranked(pose.shape, cell.scene.robot.gripper, frame), None) is None:
        raise SimulationError(f"{obj} stands or lies so that no grasp can pick it up and set it upright")
    raise SimulationError(f"{obj} is out of reach")


def find_grasp(
    cell: Workcell,
    obj: str,
    pose: ObjectPose,
    yaw: float,
    *,
    destination: str | None = None,
    tilted: bool = False,
    like: ToolPose | None = None,
    unlike: Sequence[ToolPose] = (),
    certain: bool = False,
) -> ChosenGrasp | None:
    """Return the first suitable grasp, or None.

    A suitable grasp is possible where the object is and where it is released next, if this location is known and has
    space now. For a standing object, there are two fallbacks: a grasp that is barely possible at the next location
    (`_placing`), then any grasp that is possible where the object is.

    Args:
        cell: the running simulation.
        obj: the object.
        pose: measured pose of the object.
        yaw: heading of the preferred closing direction, rad.
        destination: location at which the object is put down next; None if that is not known.
        tilted: leave out grasps for which the hand points straight down.
        like: leave out grasps for which the hand does not point nearly as in this pose (`TILT_STEP_RAD`).
        unlike: leave out grasps for which the hand points nearly as in one of these poses.
        certain: leave out both fallbacks.
    """
    slot, frame = _next_slot(cell, obj, destination), frame_of(pose, yaw)
    outside: Iterator[GraspPose] = (
        grasp
        for grasp in _candidates(cell, obj, pose, frame, tilted, like)
        if not _is_inside(cell, obj, grasp.at(pose.position, frame).symmetric_poses(), grasp.opening)
    )

    tests: list[Callable[[GraspPose], bool]] = [_in_any_case]
    if slot is not None:
        fits, barely_fits = (_placing(cell, obj, slot, barely=barely) for barely in (False, True))
        tests = [fits, barely_fits, _in_any_case] if pose.is_upright and not certain else [fits]
    for suits in tests:
        outside, again = itertools.tee(outside)
        found = next(_free_grasps(cell, obj, pose, frame, again, unlike, suits=suits), None)
        if found is not None:
            return found
    return None


def _candidates(
    cell: Workcell, obj: str, pose: ObjectPose, frame: np.ndarray, tilted: bool, like: ToolPose | None = None
) -> Iterator[GraspPose]:
    """Yield grasps in the order of preference; for the arguments see `find_grasp`, `frame` is the (3, 3) axes."""
    for grasp in ranked(cell.scene.shapes[obj], cell.scene.robot.gripper, frame):
        tool = grasp.at(pose.position, frame)
        if not (tilted and tool.points_down) and (like is None or _points_alike(tool, like)):
            yield grasp


def _free_grasps(
    cell: Workcell,
    obj: str,
    pose: ObjectPose,
    frame: np.ndarray,
    candidates: Iterable[GraspPose],
    unlike: Sequence[ToolPose],
    collisions: list[Collection[str]] | None = None,
    *,
    suits: Callable[[GraspPose], bool] = _in_any_case,
) -> Iterator[ChosenGrasp]:
    """Yield the candidates that suit and that the arm reaches without a collision where the object is.

    A candidate that suits in neither of its symmetric poses is not checked for collisions. If `collisions` are given,
    the bodies in the way of each pose of blocked candidates are added to them, which takes longer.
    """
    for grasp in candidates:
        poses = grasp.at(pose.position, frame).symmetric_poses()
        if not any(suits(replace(grasp, rotation=frame.T @ one.rotation)) for one in poses):
            continue
        try:
            choice = freely(cell, obj, pose, frame, grasp, briefly=collisions is None)
        except BlockedError as error:
            if collisions is not None:
                collisions += error.collisions
        except SimulationError:
            continue
        else:
            if not any(_points_alike(choice.tool, other) for other in unlike) and suits(choice.grasp):
                yield choice


def _points_alike(one: ToolPose, other: ToolPose) -> bool:
    """Return whether the hand points in nearly the same direction in two poses."""
    return bool(one.rotation[:, 2] @ other.rotation[:, 2] > np.cos(TILT_STEP_RAD))


def freely(
    cell: Workcell, obj: str, pose: ObjectPose, frame: np.ndarray, grasp: GraspPose, *, briefly: bool = False
) -> ChosenGrasp:
    """Return a grasp with the poses that `free_pose` finds; errors as of `free_pose`.

    One of two symmetric poses of the hand is chosen, and the grasp gets the rotation of this pose.
    """
    goals = grasp.at(pose.position, frame).symmetric_poses()
    before, tool = free_pose(cell, goals, grasp, obj, near=cell.reference, briefly=briefly)
    return ChosenGrasp(replace(grasp, rotation=frame.T @ tool.rotation), before, tool)


def _placement(
    cell: Workcell,
    obj: str,
    slot: Slot,
    grasp: GraspPose,
    *,
    near: np.ndarray | None = None,
    margin: float,
    clearance: float = FINGER_CLEARANCE_M,
    foreseen: bool = False,
) -> ChosenGrasp:
    """Return how to set an object, held in a grasp, upright into a slot; for limits and errors, see `free_pose`.

    With `foreseen`, the object is not held yet, and errors may not name all bodies in the way.
    """
    collisions: list[Collection[str]] = []
    unreachable = SimulationError(f"the hand would have to reach from below to set {obj} upright")
    for goals in _placements(cell.scene.shapes[obj], grasp, resting_centre(cell, obj, slot), slot.yaw):
        for option in openings(grasp):
            if foreseen and _is_inside(cell, obj, goals, option.opening):
                continue
            try:
                poses = free_pose(
                    cell, goals, option, obj, near=near, margin=margin, clearance=clearance, briefly=foreseen
                )
                return ChosenGrasp(option, *poses)
            except BlockedError as error:
                collisions += error.collisions
            except SimulationError as error:
                unreachable = error
                break
    if collisions:
        raise BlockedError.beside_fingers(collisions, movable=cell.scene.model.movable)
    raise unreachable


def is_placeable(cell: Workcell, obj: str, location: str) -> bool:
    """Return whether the hand fits, in some grasp, where an object that is not held yet is put down at a location."""
    slot, options = _next_slot(cell, obj, location), ranked(cell.scene.shapes[obj], cell.scene.robot.gripper, np.eye(3))
    # Objects that leave no slot free now may be moved away.
    return slot is None or any(map(_placing(cell, obj, slot, barely=True), options))


def choose_placement_of_held(cell: Workcell, obj: str, slot: Slot) -> ChosenGrasp:
    """Return how to set the held object down, upright or else leaning as it is, and how wide the fingers open there.

    Raises:
        BlockedError: bodies are in the way.
        SimulationError: the arm reaches no such pose.
    """

    def choose(grasp: GraspPose) -> ChosenGrasp:
        placement = partial(_placement, cell, obj, slot, grasp, margin=PLACING_MARGIN_RAD)
        try:
            return placement(near=cell.reference)
        except SimulationError:
            return placement()  # as in `_can_place`: the configuration nearest to the present one may collide

    try:
        return choose(held_grasp(cell, obj))
    except SimulationError:
        if not cell.observe(obj).leans:
            raise
        return choose(held_grasp(cell, obj, leaning=True))


def _next_slot(cell: Workcell, obj: str, destination: str | None) -> Slot | None:
    """Return the slot into which an object is put next; None if that is not known, or the object does not fit now."""
    try:
        return free_slot(cell, obj, destination) if destination else None
    except SkillError:
        return None


def _placements(shape: ObjectShape, grasp: GraspPose, centre: np.ndarray, yaw: float) -> Iterator[tuple[ToolPose, ...]]:
    """Yield groups of equally good poses of the tool that set an object upright with its centre at a (3,) position, m.

    Groups with less tilt of the hand come first, then those with the closing direction nearest to parallel or square to
    the heading `yaw`, rad.
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
    """Return a key that is equal for grasps with the same placements, whatever the opening or a round object's turn."""
    rotation, position = grasp.rotation, grasp.position
    if shape.is_round:
        closing = rotation[:, 1] if abs(rotation[2, 1]) < DIAGONAL else rotation[:, 2]
        turn = about_z(-float(np.arctan2(closing[1], closing[0])))
        rotation, position = turn @ rotation, turn @ position
    return (np.round([*rotation.ravel(), *position], 6) + 0.0).tobytes()


def _placing(cell: Workcell, obj: str, slot: Slot, *, barely: bool) -> Callable[[GraspPose], bool]:
    """Return a test whether an object that is not held yet can be put into a slot in a grasp.

    With `barely`, the smaller margin and clearance of a held object suffice.
    """
    shape, known = cell.scene.shapes[obj], cell.answers(obj)

    def can_place(grasp: GraspPose) -> bool:
        question = slot.position.tobytes(), slot.yaw, _placed_alike(shape, grasp), barely
        if question not in known:
            known[question] = _can_place(cell, obj, slot, grasp, barely=barely)
        return known[question]

    return can_place


def _can_place(cell: Workcell, obj: str, slot: Slot, grasp: GraspPose, *, barely: bool) -> bool:
    margin, clearance = FORESEEN_MARGIN_RAD, FORESEEN_CLEARANCE_M
    if barely:
        margin, clearance = PLACING_MARGIN_RAD, FINGER_CLEARANCE_M
    try:
        _placement(cell, obj, slot, grasp, margin=margin, clearance=clearance, foreseen=True)
    except SimulationError:
        return False
    return True


def _is_inside(cell: Workcell, obj: str, goals: Sequence[ToolPose], width: float) -> bool:
    """Return whether at every goal the hand, opened to a width, m, would be inside a body other than the object."""
    return all(cell.hand_is_inside(goal, touching=obj, width=width) for goal in goals)
