"""The hand close to objects: straight motions, poses free of collisions, and what it holds."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from sim.errors import BlockedError, SimulationError
from sim.motion.kinematics import TILTED_MARGIN_RAD
from sim.motion.trajectory import ToolPose
from sim.perception.sensors import DIAGONAL, ObjectPose, Posture
from sim.simulation.workcell import Workcell
from sim.skills.clear_paths import check_path
from sim.skills.skill import SkillError
from sim.world.grasps import GraspPose, grasps
from sim.world.shapes import about_z

HOVER_HEIGHT_M = 0.12
"""Height of the tool over a slot's centre before and after it grasps or releases: a held block clears a resting one."""

TRANSFER_CLEARANCE_M = 0.03
"""Least clearance at which the tool or its load passes over objects at rest."""

CLOSING_CHECKS = 4
"""Number of gripper widths checked for collision while closing: no wall fits between, as fingers are
11 mm thick (the Panda's)."""

FINGER_CLEARANCE_M = 0.0015
"""Least clearance of the fingers from other bodies: the arm comes to rest within 1 mm of its reference."""

FORESEEN_CLEARANCE_M = 0.003
"""The same for a tilted hand where an object that is not held yet is to be put: it will hang a little differently."""

DRAWN_BACK_M, LIFTED_M = 0.08, np.array([0.0, 0.0, 0.02])
"""How far a tilted hand is drawn back along its axis where it cannot come from above, and raised meanwhile, m."""

APPROACH_STEPS, MAX_APPROACH_STEP_RAD = 4, 0.3
"""Number of steps in which a tilted hand is followed to an object, and how far a joint may turn in each, rad."""

FORESEEN_MARGIN_RAD, CHOSEN_MARGIN_RAD, PLACING_MARGIN_RAD = 0.15, 0.12, 0.09
"""Distances that poses of a tilted hand keep from the ends of the joints, rad: where an object that is not held yet is
to be put, where one is taken, and where a held one is put and the hand travels to. What is measured again is not quite
where it was, so that each leaves space for the next."""

PATH_CLEARANCE_M = 0.006
"""Least clearance of the arm and its load from obstacles along a path; they deviate from it by 2 mm at most."""

PLANNING_CLEARANCE_M = 0.008
"""Least clearance of planned paths at their samples: in between they may come nearer, but not than the one above."""

OPEN_DURATION_S = 0.25
"""Duration of opening the hand."""

BLEND_M = 0.02
"""Distance of the tool from its goal at which the next movement may begin."""


def move_tool(
    cell: Workcell,
    goals: Sequence[ToolPose],
    *,
    within: float = 0.0,
    seconds: float = 0.0,
    watch: Callable[[], None] = lambda: None,
) -> ToolPose:
    """Move the tool along a straight line to one of several poses nearby; return which one.

    Args:
        cell: the running simulation.
        goals: poses that would do.
        within: distance from the goal at which the next movement may begin, m; 0 to come to rest there.
        seconds: least duration, s.
        watch: called again and again meanwhile; if it raises an error, the arm brakes.
    """
    goal, pose = None, goals[0]
    if len(goals) == 1 and not pose.points_down:
        # Step by step the elbow keeps its place, where a search from far away may bring a joint to its end.
        with contextlib.suppress(SimulationError):
            goal = _followed(cell, cell.reference, cell.arm.tool(cell.reference), pose, margin=TILTED_MARGIN_RAD)[-1]
    if goal is None:
        goal, pose = cell.arm.reach(goals, near=cell.reference)
    references = cell.arm.move(cell.reference, goal, pose, seconds=seconds, ending=cell.ending)
    check_path(cell, references, clearance=FINGER_CLEARANCE_M)
    cell.follow(references, within=within, watch=watch)
    return pose


def pregrasps(pose: ToolPose) -> tuple[ToolPose, ...]:
    """Return poses from which the hand comes straight to a pose and leaves it: from above, or along its own axis."""
    above = pose.shifted([0.0, 0.0, HOVER_HEIGHT_M])
    return (above,) if pose.points_down else (above, pose.shifted(DRAWN_BACK_M * -pose.rotation[:, 2] + LIFTED_M))


def free_pose(
    cell: Workcell,
    goals: Sequence[ToolPose],
    grasp: GraspPose,
    *,
    near: np.ndarray | None = None,
    margin: float = CHOSEN_MARGIN_RAD,
    clearance: float = FINGER_CLEARANCE_M,
) -> tuple[ToolPose, ToolPose]:
    """Return which of several poses the hand takes to open and close for a grasp there without a collision.

    Args:
        cell: the running simulation.
        goals: poses that would do.
        grasp: how wide the hand opens and closes.
        near: (n,) where the arm comes from, rad; None for anywhere.
        margin: of a tilted hand from the ends of the joints, rad.
        clearance: of a tilted hand from other bodies, m.

    Returns:
        From where it comes straight to that pose, and the pose.

    Raises:
        BlockedError: bodies are in the way of the hand.
        SimulationError: the arm reaches none of the poses.
    """
    blockers: set[str] = set()
    unreachable = SimulationError("the joints would have to turn round")
    for options in zip(*map(pregrasps, goals), strict=True):
        try:
            q, before = cell.arm.reach(options, near=near, margin=margin)
            pose = goals[next(i for i, option in enumerate(options) if option is before)]
            met = _met(cell, q, grasp.opening, FINGER_CLEARANCE_M if pose.points_down else PLANNING_CLEARANCE_M)
            path = _followed(cell, q, before, pose, margin=margin)
        except SimulationError as error:
            unreachable = error
            continue
        beside = FINGER_CLEARANCE_M if pose.points_down else clearance
        for q in path[:-1]:
            met |= _met(cell, q, grasp.opening, beside)
        for width in np.linspace(grasp.opening, grasp.width, CLOSING_CHECKS):
            met |= _met(cell, path[-1], float(width), beside)
        if not met:
            return before, pose
        blockers |= met
    if blockers:
        raise BlockedError.beside_fingers(blockers)
    raise unreachable


def _followed(
    cell: Workcell, q: np.ndarray, before: ToolPose, pose: ToolPose, *, margin: float = PLACING_MARGIN_RAD
) -> list[np.ndarray]:
    """Return joint angles, rad, on the straight path to a pose from another one, where they are (n,) q; the last there.

    They keep a margin from the ends of the joints, rad, unless the hand points down.

    Raises:
        SimulationError: it does not reach it, or has to turn round meanwhile.
    """
    if pose.points_down:
        return [cell.arm.reach([pose])[0]]
    path = [q]
    for share in np.linspace(0, 1, APPROACH_STEPS + 1)[1:]:
        step = ToolPose(before.position + share * (pose.position - before.position), pose.rotation)
        path.append(cell.arm.reach([step], near=path[-1], margin=margin)[0])
        if np.abs(path[-1] - path[-2]).max() > MAX_APPROACH_STEP_RAD:
            raise SimulationError("the joints would have to turn round")
    return path[1:]


def check_approach(cell: Workcell, q: np.ndarray, before: ToolPose, pose: ToolPose) -> None:
    """Check that the hand, from a pose where the joint angles are (n,) q, rad, comes straight to another one.

    Raises:
        BlockedError: bodies are in its way, other than the handled object.
        SimulationError: the arm does not reach it, or has to turn round meanwhile.
    """
    checker, obj = cell.collision_checker(), cell.contacts.handled
    steps = _followed(cell, q, before, pose)
    touches = itertools.chain.from_iterable(checker.touches(q, clearance=FINGER_CLEARANCE_M) for q in steps)
    met = {other for one, other in touches if obj not in (one, other)}
    if met:
        raise BlockedError.on_the_way(met)


def _met(cell: Workcell, q: np.ndarray, width: float, clearance: float) -> set[str]:
    """Return what is nearer to the hand, opened to a width, m, than a clearance, m, except the object it handles."""
    return set(cell.collisions(q, width=width, clearance=clearance)) - {cell.contacts.handled or ""}


def transfer_height(cell: Workcell, objects: Iterable[str], *, held: str | None = None) -> float:
    """Return the height of the tool at which it and its load clear some objects at rest, m."""
    tops = [cell.observe(obj).top for obj in objects if obj != held]
    below = cell.scene.robot.gripper.fingertip_m
    if held:
        pose = cell.observe(held)
        hanging = float(cell.arm.tool(cell.angles).position[2] - pose.position[2]) + pose.below
        below = max(float(pose.shape.half[2]), pose.below, hanging)
    return max(tops, default=0.0) + below + TRANSFER_CLEARANCE_M


def frame_of(pose: ObjectPose, yaw: float) -> np.ndarray:
    """Return the (3, 3) axes of an object up to its symmetry, its x axis nearest to a heading, rad, or level."""
    shape = pose.shape
    if pose.posture == Posture.UPRIGHT:
        return about_z(shape.yaw_near(pose.yaw, yaw))
    frame = shape.most_upright(pose.rotation)
    return shape.heading_to(frame, np.cross([0.0, 0.0, 1.0], frame[:, 2]))


def held_grasp(cell: Workcell, obj: str, *, leaning: bool = False) -> GraspPose:
    """Return how the hand holds an object; what stands, or leans if that is asked for, is taken to stand exactly."""
    shape, pose, tool = cell.scene.shapes[obj], cell.observe(obj), cell.arm.tool(cell.angles)
    frame = about_z(pose.yaw) if leaning else frame_of(pose, pose.yaw)
    closing, approach = tool.rotation[:, 1], tool.rotation[:, 2]
    frame = shape.heading_to(frame, closing if abs(closing @ frame[:, 2]) < DIAGONAL else approach)
    rotation = frame.T @ tool.rotation
    position = frame.T @ (tool.position - pose.position)

    options = grasps(shape, cell.scene.robot.gripper)
    alike = np.abs(np.vecdot([grasp.rotation[:, 1] for grasp in options], rotation[:, 1])).round(2)
    shifts = np.array([grasp.position for grasp in options]) - position
    similar = options[int(np.where(alike == alike.max(), np.sqrt(np.vecdot(shifts, shifts)), np.inf).argmin())]
    return GraspPose(position, rotation, similar.width)


def check_held(cell: Workcell, obj: str) -> None:
    """Raise SkillError unless the hand holds an object; one that is not observed now may have slipped: wait for it.

    Raises:
        ObservationTimeoutError: it is not observed for too long.
    """
    cell.observe(obj)
    if cell.held() != obj:
        raise SkillError(f"no contact force on both finger pads: {obj} is not held")
