"""The hand close to objects: straight motions, collision-free poses, and what it holds."""

import contextlib
import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from sim.errors import BlockedError, SimulationError
from sim.motion.ik import TILTED_MARGIN_RAD
from sim.motion.joint_trajectory import JointTrajectory, summed
from sim.motion.trajectory import ToolPose
from sim.perception.sensors import DIAGONAL, ObjectPose
from sim.simulation.workcell import Workcell
from sim.skills.skill import SkillError
from sim.world.grasps import GraspPose, grasps
from sim.world.shapes import about_z

HOVER_HEIGHT_M = 0.12
"""Height of the tool above a grasp or a placement, before and after it, m: a held block clears another one."""

TRANSFER_CLEARANCE_M = 0.03
"""Least vertical clearance between objects at rest and the hand, or its load, as it passes over them."""

CLOSING_CHECKS = 4
"""Number of gripper widths checked for collision while closing: a finger, 11 mm thick on the Panda, cannot pass through
a wall between two checks."""

FINGER_CLEARANCE_M = 0.0015
"""Least clearance of the fingers from other bodies: the tracking error of the arm at rest is below 1 mm."""

FORESEEN_CLEARANCE_M = 0.003
"""Least clearance of a tilted hand that will place an object not held yet, m: its pose in the hand will differ."""

DRAWN_BACK_M = 0.08
"""Distance along the hand's axis from a tilted grasp back to the pre-grasp pose tried after the one above it, m."""

MIN_LIFT_M = 0.02
"""Least height of this pre-grasp pose above the grasp, m: that of a level hand would be 0."""

APPROACH_STEPS = 4
"""Number of IK steps along a straight approach."""

MAX_APPROACH_STEP_RAD = 0.3
"""Greatest turn of a joint in one IK step of an approach, rad; a greater one counts as a change of configuration."""

FINE_STEPS = 16
"""Number of IK steps if `APPROACH_STEPS` are too few: near the base, joints turn fast, but do not jump."""

FORESEEN_MARGIN_RAD = 0.15
"""Margin to the joints' position limits when a tilted hand will place an object that is not held yet, rad.

Each of these three margins leaves a reserve for the next one: a pose that is measured again differs a little."""

CHOSEN_MARGIN_RAD = 0.12
"""Margin to the joints' position limits when a tilted hand grasps, rad."""

PLACING_MARGIN_RAD = 0.09
"""Margin to the joints' position limits when a tilted hand places a held object, and at goals of `travel`, rad."""

PATH_CLEARANCE_M = 0.006
"""Least clearance of the arm and its load from obstacles along a path (the arm deviates from it by at most 2 mm)."""

PLANNING_CLEARANCE_M = 0.008
"""Least clearance of planned paths at their samples; in between it may be less, but not below `PATH_CLEARANCE_M`."""

OPEN_DURATION_S = 0.25
"""Duration of opening the hand."""

LIFT_M = 0.005
"""Height by which a heavy object is lifted slowly at first, and lowered slowly at the end, m."""

LIFT_DURATION_S = 0.8
"""Least duration of this slow movement, s: the arm begins to compensate for the weight meanwhile. On a suction cup,
torque rates then reach 58 % of their limit instead of 112 %."""

SIDEWAYS = np.array([[np.cos(yaw), np.sin(yaw), 0.0] for yaw in np.radians(np.arange(0, 360, 22.5))])
"""(16, 3) horizontal directions in which an object is moved away from bodies beside it."""

RECONFIGURED = "the arm would have to change its configuration on the way"
"""Why the hand cannot move straight from one pose to another."""

BLEND_M = 0.02
"""Distance of the tool from its goal at which the next movement may begin."""


def move_tool(
    cell: Workcell,
    goal: ToolPose,
    *,
    within: float = 0.0,
    seconds: float = 0.0,
    watch: Callable[[], None] = lambda: None,
    touching: bool = True,
) -> None:
    """Move the tool along a straight line to a pose nearby.

    The next movement may begin when the tool is nearer than `within` to its goal, m; 0 to come to rest there. `seconds`
    is the least duration, s. If `watch`, called repeatedly, raises an error, the arm brakes. `touching` is whether the
    fingers may hold or touch the handled object.

    Raises:
        BlockedError: bodies are on the path.
        SimulationError: the arm does not reach the pose, or an error of `watch`.
    """
    movement = straight_move(cell, goal, seconds=seconds)
    check_path(cell, movement, clearance=FINGER_CLEARANCE_M, touching=touching)
    cell.follow(movement, within=within, watch=watch)


def check_path(cell: Workcell, movement: JointTrajectory, *, clearance: float, touching: bool = True) -> None:
    """Check a movement from the current configuration for collisions, including those between the robot's own links.

    Bodies nearer than the clearance, m, count as in collision (`CollisionChecker.blockers`). `touching` is whether the
    fingers may hold or touch the handled object even if it is not attached.

    Raises:
        BlockedError: there is a collision.
    """
    held = cell.held() if touching or cell.attached else None
    touched = cell.contacts.handled if touching else None
    width = cell.width if held is None else None
    checker = cell.collision_checker(touching=touched, held=held or cell.attached, width=width)
    path = np.vstack([cell.angles, summed(movement.references, cell.ending)])
    met = checker.blockers(path, clearance=clearance)
    if met:
        raise BlockedError.on_the_way(met, load=held or cell.attached)


def straight_move(cell: Workcell, goal: ToolPose, *, seconds: float) -> JointTrajectory:
    """Return the straight movement to a pose nearby that `move_tool` follows.

    Raises:
        SimulationError: the arm does not reach the pose.
    """
    now = cell.arm.tool(cell.reference)
    # IK in small steps keeps the elbow's configuration; from a distant seed, a joint may end at its limit.
    for steps in (APPROACH_STEPS, FINE_STEPS):
        with contextlib.suppress(SimulationError):
            q = _followed(cell, cell.reference, now, goal, margin=TILTED_MARGIN_RAD, steps=steps)[-1]
            break
    else:
        q, _ = cell.arm.reach([goal], near=cell.reference)
    return cell.arm.move(cell.reference, q, goal, seconds=seconds, ending=cell.ending, load=cell.load)


def pregrasps(pose: ToolPose) -> tuple[ToolPose, ...]:
    """Return pre-grasp poses, from which the hand moves straight to a pose: above it and, if tilted, behind it."""
    above = pose.shifted([0.0, 0.0, HOVER_HEIGHT_M])
    if pose.points_down:
        return (above,)
    back = -DRAWN_BACK_M * pose.rotation[:, 2]
    back[2] = max(back[2], MIN_LIFT_M)
    return above, pose.shifted(back)


def free_pose(
    cell: Workcell,
    goals: Sequence[ToolPose],
    grasp: GraspPose,
    obj: str,
    *,
    near: np.ndarray | None = None,
    margin: float = CHOSEN_MARGIN_RAD,
    clearance: float = FINGER_CLEARANCE_M,
    briefly: bool = False,
) -> tuple[ToolPose, ToolPose]:
    """Return one of several poses at which the hand can open and close for a grasp without a collision.

    Args:
        cell: the running simulation.
        goals: acceptable poses.
        grasp: how wide the hand opens and closes.
        obj: the object between the fingers, which they may touch and which is not checked for collisions.
        near: (n,) joint angles from which the arm comes, rad; None if they do not matter.
        margin: distance from the joints' position limits if the hand is tilted, rad.
        clearance: least distance from other bodies if the hand is tilted, m.
        briefly: whether errors may leave out some bodies in the way, which saves time.

    Returns:
        The pre-grasp pose, and the pose, to which the hand can move straight from there.

    Raises:
        BlockedError: bodies are in the way of the hand.
        SimulationError: the arm reaches none of the poses.
    """
    goals = cell.arm.within_reach(goals)
    collisions: list[set[str]] = []
    for options in zip(*map(pregrasps, goals), strict=True):
        postures, at_hand = list[tuple[int, set[str]]](), dict[int, set[str]]()
        for q, k in cell.arm.configurations(options, near=near, margin=margin, without=at_hand):
            met = set[tuple[str, str]]()
            try:
                for touches in _touches(cell, q, options[k], goals[k], grasp, obj, margin=margin, clearance=clearance):
                    met.update(pair for pair in touches if pair[1] != obj)
                    if met and briefly:
                        break
            except SimulationError:
                continue
            if not met:
                return options[k], goals[k]
            postures.append((k, {other for _, other in met}))
            if hindering := {pair[1] for pair in met if cell.touches_hand(pair)}:
                at_hand[k] = hindering  # no other elbow position avoids this
        collisions += [*at_hand.values(), *(bodies for k, bodies in postures if k not in at_hand)]
    if collisions:
        raise BlockedError.beside_fingers(collisions, movable=cell.scene.model.movable)
    cell.arm.reach(options, near=near, margin=margin)  # raises if none is in reach
    raise SimulationError(RECONFIGURED)


def _touches(
    cell: Workcell,
    q: np.ndarray,
    before: ToolPose,
    pose: ToolPose,
    grasp: GraspPose,
    obj: str,
    *,
    margin: float,
    clearance: float,
) -> Iterator[frozenset[tuple[str, str]]]:
    """Yield the collisions at each step as the hand moves straight from `before` to a pose and closes (`_followed`)."""
    beside, afar = (FINGER_CLEARANCE_M,) * 2 if pose.points_down else (clearance, PLANNING_CLEARANCE_M)
    yield cell.touches(q, touching=obj, width=grasp.opening, clearance=afar)
    path = _followed(cell, q, before, pose, margin=margin)
    for there in path[:-1]:
        yield cell.touches(there, touching=obj, width=grasp.opening, clearance=beside)
    for width in np.linspace(grasp.opening, grasp.width, CLOSING_CHECKS):
        yield cell.touches(path[-1], touching=obj, width=float(width), clearance=beside)


def _followed(
    cell: Workcell,
    q: np.ndarray,
    before: ToolPose,
    pose: ToolPose,
    *,
    margin: float = PLACING_MARGIN_RAD,
    steps: int = APPROACH_STEPS,
) -> list[np.ndarray]:
    """Return (n,) joint angles, rad, along the straight path from the pose `before`, reached at `q`, to another pose.

    If the hand is tilted, all keep a margin from the joints' position limits, rad. Raises `SimulationError` where the
    arm would have to change its configuration.
    """
    path = [q]
    for share in np.linspace(0, 1, steps + 1)[1:]:
        step = ToolPose(before.position + share * (pose.position - before.position), pose.rotation)
        there = cell.arm.nearby(step, path[-1], margin)
        if there is None or np.abs(there - path[-1]).max() > MAX_APPROACH_STEP_RAD:
            raise SimulationError(RECONFIGURED)
        path.append(there)
    return path[1:]


def check_approach(cell: Workcell, q: np.ndarray, before: ToolPose, pose: ToolPose) -> None:
    """Check that the hand can move straight from the pose `before`, reached at (n,) joint angles `q`, rad, to another.

    Raises:
        BlockedError: bodies other than the handled object are in the way.
        SimulationError: the arm would have to change its configuration on the way.
    """
    # An empty hand may still be opening or closing on its way to `before`.
    obj, width = cell.contacts.handled, cell.width if cell.held() is None else None
    checker = cell.collision_checker(touching=obj, held=cell.attached, width=width)
    steps = _followed(cell, q, before, pose)
    touches = itertools.chain.from_iterable(checker.touches(q, clearance=FINGER_CLEARANCE_M) for q in steps)
    met = {other for one, other in touches if obj not in (one, other)}
    if met:
        raise BlockedError.on_the_way(met)


def transfer_height(cell: Workcell, objects: Iterable[str], *, held: str | None = None) -> float:
    """Return the height of the tool, m, at which the hand and the held object pass over some objects at rest."""
    tops = [cell.observe(obj).top for obj in objects if obj != held]
    below = cell.scene.robot.gripper.fingertip_m
    if held:
        pose = cell.observe(held)
        hanging = float(cell.arm.tool(cell.angles).position[2] - pose.position[2]) + pose.below
        below = max(float(pose.shape.half[2]), pose.below, hanging)
    return max(tops, default=0.0) + below + TRANSFER_CLEARANCE_M


def frame_of(pose: ObjectPose, yaw: float) -> np.ndarray:
    """Return the (3, 3) axes of an object, chosen among those in which it looks the same.

    If it stands, they have the heading nearest to `yaw`, rad. Otherwise they are the most upright ones, and the x axis
    of a round object is level.
    """
    shape = pose.shape
    if pose.is_upright:
        return about_z(shape.yaw_near(pose.yaw, yaw))
    frame = shape.most_upright(pose.rotation)
    return shape.heading_to(frame, np.cross([0.0, 0.0, 1.0], frame[:, 2]))


def held_grasp(cell: Workcell, obj: str, *, leaning: bool = False) -> GraspPose:
    """Return the grasp in which the hand holds an object, with the width of the most similar grasp of its shape.

    A standing object is assumed to be exactly upright; with `leaning`, so is one that leans.
    """
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


def most_central(shifts: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return (3,) shifts of equal length, sorted by their angle to the mean of all, the smallest first."""
    middle = np.sum(shifts, axis=0)
    return sorted(shifts, key=lambda shift: -float(shift @ middle))


def check_held(cell: Workcell, obj: str) -> None:
    """Check that the hand holds an object; wait until it is observed, since it may have slipped unseen.

    Raises:
        SkillError: it is not held.
        ObservationTimeoutError: it is not observed for too long.
    """
    cell.observe(obj)
    if cell.held() != obj:
        raise SkillError(f"no contact force on both finger pads: {obj} is not held")
