"""Regrasping: an object that no single grasp sets upright is first set down on another face, or elsewhere."""

import itertools
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from sim.errors import SimulationError
from sim.motion.trajectory import ToolPose
from sim.perception.sensors import ObjectPose
from sim.simulation.workcell import Workcell
from sim.skills.grasp_choice import ChosenGrasp, find_grasp, freely
from sim.skills.hand import check_held, frame_of, free_pose, transfer_height
from sim.skills.placing import is_carried, obstacles
from sim.skills.release import DROP_HEIGHT_M, TILTED_DURATIONS_S, lower
from sim.skills.transfer import leave, travel
from sim.world.grasps import GraspPose, grasps, ranked, tilt_of
from sim.world.shapes import about_z

QUARTERS = (0, 1, -1, 2)
"""Quarter turns about the closing direction, to try in turn; 0 to set an object down on the same face."""

HEADINGS_RAD = np.radians([0, 45, -45, 90, -90, 135, -135, 180])
"""Turns about the vertical with which an object may be set down; `free_pose` chooses one."""

SHIFTS_M = 0.1 * np.array([[0, 0], [-1, 0], [0, 1], [0, -1], [1, 0]])
"""(K, 2) shifts from where an object lies to where it is set down, to try in turn, m."""


@dataclass(frozen=True)
class Regrasp:
    """How an object is grasped and set down on another face, or on the same face elsewhere.

    Attributes:
        taken: the grasp with which it is picked up.
        above: the pose from which the hand moves straight to the placement.
        placing: the pose of the tool in which the fingers open.
        pose: pose of the object after it is set down.
        over: whether the object is turned over onto another face.
    """

    taken: ChosenGrasp
    above: ToolPose
    placing: ToolPose
    pose: ObjectPose
    over: bool


def find_regrasp(cell: Workcell, obj: str, pose: ObjectPose, destination: str | None) -> Regrasp | None:
    """Return how to set an object down so that it can then be grasped and set upright; None if no way is found.

    `destination` is the location at which it is put down after that; None if it is not known.
    """
    frame = frame_of(pose, pose.yaw)

    @cache
    def reached(grasp: GraspPose) -> ChosenGrasp | None:
        with suppress(SimulationError):
            return freely(cell, obj, pose, frame, grasp)
        return None

    for grasp, turned in _options(cell, obj, frame):
        taken = reached(grasp)
        if taken is None:
            continue
        held = taken.grasp
        for centre in _centres(cell, obj, pose, turned):
            poses = tuple(held.at(centre, about_z(heading) @ turned) for heading in HEADINGS_RAD)
            try:
                above, placing = free_pose(cell, poses, held, obj, near=cell.reference)
            except SimulationError:
                continue
            rotation = placing.rotation @ held.rotation.T
            rests = replace(pose, position=centre, rotation=rotation)
            if find_grasp(cell, obj, rests, pose.yaw, destination=destination, certain=True) is not None:
                over = not np.allclose(turned, frame)
                return Regrasp(taken, above, placing, rests, over)
    return None


def set_down(cell: Workcell, obj: str, regrasp: Regrasp) -> None:
    """Set the held object down, let go and raise the hand; errors as of `travel`, or `SkillError` if it is lost."""
    cell.attach(obj)
    travel(cell, [regrasp.above], height=transfer_height(cell, cell.shapes, held=obj))
    cell.settle()
    held, tool, shape = cell.measure(obj), cell.arm.tool(cell.angles), cell.scene.shapes[obj]
    rotation = regrasp.placing.rotation @ tool.rotation.T
    centre = regrasp.pose.position.copy()
    centre[2] += shape.depth(rotation @ held.rotation) - shape.depth(regrasp.pose.rotation) + DROP_HEIGHT_M
    placing = ToolPose(centre - rotation @ (held.position - tool.position), regrasp.placing.rotation)
    check_held(cell, obj)
    cell.detach()
    lower(cell, obj, placing, watch=lambda: check_held(cell, obj))
    cell.unload()
    opening, rising = TILTED_DURATIONS_S
    cell.set_width(regrasp.taken.grasp.opening, opening)
    cell.wait(rising)
    leave(cell, regrasp.above)
    cell.settle()
    cell.log_event("turned over" if regrasp.over else "set aside", object=obj)


def _options(cell: Workcell, obj: str, frame: np.ndarray) -> Iterator[tuple[GraspPose, np.ndarray]]:
    """Yield grasps of an object with (3, 3) axes `frame`, each with the (3, 3) axes in which it sets the object down.

    The least tilt of the hand comes first. From each new orientation, some grasp can set the object upright.
    """
    shape, gripper = cell.scene.shapes[obj], cell.scene.robot.gripper
    options: list[tuple[int, GraspPose, np.ndarray]] = []
    for grasp, quarters in itertools.product(grasps(shape, gripper), QUARTERS):
        if grasp.clearance is not None and quarters:
            continue  # narrow openings are for tight spaces, which are no reason to turn it over
        turned = frame @ Rotation.from_rotvec(quarters * np.pi / 2 * grasp.rotation[:, 1]).as_matrix()
        tilt = max(tilt_of(frame @ grasp.rotation), tilt_of(turned @ grasp.rotation))
        if np.isfinite(tilt):
            options.append((round(np.degrees(tilt)), grasp, turned))
    for _, grasp, turned in sorted(options, key=lambda option: option[0]):
        if next(ranked(shape, gripper, turned), None) is not None:
            yield grasp, turned


def _centres(cell: Workcell, obj: str, pose: ObjectPose, turned: np.ndarray) -> Iterator[np.ndarray]:
    """Yield collision-free (3,) centres, m, of an object with (3, 3) axes `turned`: where it is, then around that."""
    meets = obstacles(cell, obj)
    height = pose.underside[2] + pose.shape.depth(turned)
    for shift in SHIFTS_M:
        centre = np.array([*pose.position[:2] + shift, height])
        there = replace(pose, position=centre, rotation=turned)
        if meets(there):
            continue
        if not shift.any() or is_carried(cell, obj, there):
            yield centre
