"""Transit: bring the empty hand over a location."""

import itertools
from collections.abc import Iterator, Sequence
from contextlib import suppress

import numpy as np

from prefplan.models.manipulation.operators import Transit
from prefplan.models.manipulation.symbolic import Action
from sim.errors import BlockedError, SimulationError
from sim.geometry.mjcf import first_met
from sim.motion.trajectory import ToolPose
from sim.simulation.workcell import Workcell
from sim.skills.grasp import MORE_GRASPS
from sim.skills.grasp_choice import ChosenGrasp, find_grasp
from sim.skills.hand import HOVER_HEIGHT_M, PLANNING_CLEARANCE_M, transfer_height
from sim.skills.skill import Skill, next_release
from sim.skills.transfer import travel
from sim.world.places import AT_RADIUS_M, extent, lowest_under

TRANSFER_RADIUS_M = 0.2
"""Distance from a location within which the hand must clear all objects, m: more than the width of the hand."""

RAISES_M = (0.0, 0.1, 0.2)
"""Additional heights of the hand over a location, to try in turn, m."""

TURNS_RAD = np.radians([0, 90, 45, -45])
"""Turns of the hand about the vertical, to try in turn at each height, rad."""

PILE_HEIGHT_M = 0.2
"""Height above the lowest location's floor up to which objects are in its pile, m: not those on a board above it."""

PASSED_M = 1e-4
"""Distance behind a surface at which the search for the next surface starts, m."""

ROOF_HEIGHT_M = 0.05
"""Height above a location's floor from which a fixture counts as a roof: a bin's walls are lower."""


class TransitSkill(Transit, Skill):
    """Bring the empty hand over a location and any pile there, or else to a tilted pre-grasp pose of an object."""

    def perform(self, cell: Workcell, action: Action, ahead: Sequence[Action] = ()) -> None:
        """See `Skill.perform`."""
        cell.touch(None)
        slots = cell.scene.slots[action.location]
        height = max(_lowest(cell, action.location), transfer_height(cell, _near(cell, action.location)))
        pose = ToolPose.down(np.array([*_middle(cell, action.location)[:2], height]), slots[0].yaw)
        height = transfer_height(cell, cell.shapes)
        floor = float(cell.scene.slots[lowest_under(cell.scene.model, action.location)][0].position[2])
        try:
            _check_open(cell, pose, floor)
            travel(cell, pose.symmetric_poses(), height=height)
        except SimulationError:
            # If the hand cannot be above the location, it goes to the pre-grasp pose of an object there.
            failure: SimulationError | None = None
            for found in _tilted_grasps(cell, action.location, floor, ahead):
                try:
                    travel(cell, [found.before], height=height, onward=found.tool)
                    return
                except SimulationError as error:
                    failure = failure or error
            if failure is not None:
                raise failure from None
            other = _clear_pose(cell, pose, floor)
            if other is None:
                raise
            travel(cell, other.symmetric_poses(), height=height)


def raised_by(cell: Workcell, location: str) -> list[str]:
    """Return the objects at a location, and those near it that are so high that the hand must be raised over it."""
    lowest = _lowest(cell, location)
    there = _near(cell, location, AT_RADIUS_M)
    return [obj for obj in _near(cell, location) if obj in there or transfer_height(cell, [obj]) > lowest]


def _lowest(cell: Workcell, location: str) -> float:
    """Return the height of the hand over a location without objects, m."""
    return float(_middle(cell, location)[2] + extent(cell.scene.shapes.values()).high / 2 + HOVER_HEIGHT_M)


def _near(cell: Workcell, location: str, radius: float = TRANSFER_RADIUS_M) -> list[str]:
    """Return the objects within a radius, m, of a location's row of slots."""
    middle = _middle(cell, location)[:2]
    radius += float(np.hypot(*(cell.scene.slots[location][-1].position[:2] - middle)))
    return [obj for obj in cell.shapes if np.hypot(*(cell.observe(obj).position[:2] - middle)) < radius]


def _middle(cell: Workcell, location: str) -> np.ndarray:
    """Return the (3,) middle of a location's slots, m."""
    return np.mean([slot.position for slot in cell.scene.slots[location]], axis=0)


def _clear_pose(cell: Workcell, pose: ToolPose, floor: float) -> ToolPose | None:
    """Return a collision-free pose of the hand above a floor, m, at the same position but higher or turned; or None.

    None, too, if the pose itself is free: then the way to it is blocked, and another pose would not help.
    """
    for raised, turn in itertools.product(RAISES_M, TURNS_RAD):
        other = ToolPose.down(pose.position + [0.0, 0.0, raised], pose.yaw + turn)
        with suppress(SimulationError):
            _check_open(cell, other, floor)
            q, _ = cell.arm.reach(other.symmetric_poses())
            if not cell.touches(q, clearance=PLANNING_CLEARANCE_M):
                return other if raised or turn else None
    return None


def _check_open(cell: Workcell, pose: ToolPose, floor: float) -> None:
    """Raise BlockedError if a fixture, such as a shelf's board, is between the hand and the floor below it, m."""
    model, below = cell.scene.mujoco, pose.position - [0.0, 0.0, cell.scene.robot.gripper.fingertip_m]
    down = np.array([0.0, 0.0, -1.0])
    geom, distance = first_met(model, cell.data, below, down)
    while geom >= 0 and model.body_weldid[model.geom_bodyid[geom]]:  # an object, or the arm where it is now
        below = below + (distance + PASSED_M) * down
        geom, distance = first_met(model, cell.data, below, down)
    if geom >= 0 and below[2] - distance > floor + ROOF_HEIGHT_M:
        raise BlockedError.on_the_way({str(model.body(int(model.geom_bodyid[geom])).name)})


def _tilted_grasps(cell: Workcell, location: str, floor: float, ahead: Sequence[Action]) -> Iterator[ChosenGrasp]:
    """Yield tilted grasps of one object at a location above a floor, m: in a slot, the highest one that has any."""
    poses = {obj: cell.observe(obj) for obj in cell.shapes}
    for slot in cell.scene.slots[location]:
        offsets = {obj: pose.position - [*slot.position[:2], floor] for obj, pose in poses.items()}
        there = [obj for obj, off in offsets.items() if np.hypot(*off[:2]) < slot.radius and 0 < off[2] < PILE_HEIGHT_M]
        for obj in sorted(there, key=lambda obj: -float(poses[obj].position[2])):
            destination, tried = next_release(obj, ahead), list[ToolPose]()
            for _ in range(1 + MORE_GRASPS):
                found = find_grasp(cell, obj, poses[obj], slot.yaw, destination=destination, tilted=True, unlike=tried)
                if found is None:
                    break
                yield found
                tried.append(found.tool)
            if tried:
                return
