"""Transit: bring the empty hand over a location."""

from __future__ import annotations

import itertools
from contextlib import suppress

import numpy as np

from prefplan.models.manipulation.action import Action
from prefplan.models.manipulation.operators import Transit
from sim.errors import BlockedError, SimulationError
from sim.geometry.mjcf import first_met
from sim.motion.trajectory import ToolPose
from sim.simulation.workcell import Workcell
from sim.skills.grasp_choice import find_grasp
from sim.skills.hand import HOVER_HEIGHT_M, PLANNING_CLEARANCE_M, transfer_height
from sim.skills.skill import Skill
from sim.skills.transfer import travel
from sim.world.shapes import extent

TRANSFER_RADIUS_M = 0.2
"""Distance within which the hand over a location passes over other objects, too: more than its own width."""

RAISES_M, TURNS_RAD = (0.0, 0.1, 0.2), np.radians([0, 90, 45, -45])
"""How much higher the hand is over a location beside which something is in its way, m, and how far it is turned there,
to try in turn."""

PILE_HEIGHT_M = 0.2
"""Height over a location's floor to which objects belong to it, m: those on a board above it do not."""

ROOF_HEIGHT_M = 0.05
"""Height over a location's floor from which on what is fixed there is a roof, m: a bin's walls are lower."""


class TransitSkill(Transit, Skill):
    """Bring the empty hand over a location and whatever is piled up there, or to what is there from where it can."""

    def perform(self, cell: Workcell, action: Action) -> None:
        """See `Skill.perform`."""
        cell.contacts.handle(None)
        slots = cell.scene.slots[action.location]
        centre = np.mean([slot.position for slot in slots], axis=0)
        middle = extent(cell.scene.shapes.values()).high / 2
        reach = TRANSFER_RADIUS_M + float(np.hypot(*(slots[-1].position - centre)[:2]))
        piled = [obj for obj in cell.shapes if np.hypot(*(cell.observe(obj).position - centre)[:2]) < reach]
        height = max(centre[2] + middle + HOVER_HEIGHT_M, transfer_height(cell, piled))
        pose = ToolPose.down(np.array([*centre[:2], height]), slots[0].yaw)
        height = transfer_height(cell, cell.shapes)
        try:
            _check_open(cell, pose, float(centre[2]))
            travel(cell, pose.symmetric_poses(), height=height)
        except SimulationError:
            # Where the hand cannot be above, it comes to what is there as it will take it.
            found = _tilted_grasp(cell, action.location)
            if found is not None:
                before, tool = found
                travel(cell, [before], height=height, onward=tool)
                return
            other = _clear_pose(cell, pose, float(centre[2]))
            if other is None:
                raise
            travel(cell, other.symmetric_poses(), height=height)


def _clear_pose(cell: Workcell, pose: ToolPose, floor: float) -> ToolPose | None:
    """Return the hand over the same place and its floor, m, but higher or turned, where nothing is in its way; or None.

    Where it is free as it is, something is on the way to it, and nothing is gained.
    """
    for raised, turn in itertools.product(RAISES_M, TURNS_RAD):
        other = ToolPose.down(pose.position + [0.0, 0.0, raised], pose.yaw + turn)
        with suppress(SimulationError):
            _check_open(cell, other, floor)
            q, _ = cell.arm.reach(other.symmetric_poses())
            if not cell.collisions(q, clearance=PLANNING_CLEARANCE_M):
                return other if raised or turn else None
    return None


def _check_open(cell: Workcell, pose: ToolPose, floor: float) -> None:
    """Raise BlockedError if what does not move, such as a shelf's board, is between the hand and the floor, m, below.

    The first body below the hand tells: objects lie on the floor, or on what is between.
    """
    model, below = cell.scene.mujoco, pose.position - [0.0, 0.0, cell.scene.robot.gripper.fingertip_m]
    geom, distance = first_met(model, cell.data, below, np.array([0.0, 0.0, -1.0]))
    body = int(model.geom_bodyid[geom])
    if geom >= 0 and below[2] - distance > floor + ROOF_HEIGHT_M and not model.body_weldid[body]:
        raise BlockedError.on_the_way({str(model.body(body).name)})


def _tilted_grasp(cell: Workcell, location: str) -> tuple[ToolPose, ToolPose] | None:
    """Return from where a tilted hand comes to an object at a location, and where it takes it; None if it cannot."""
    poses = {obj: cell.observe(obj) for obj in cell.shapes}
    for slot in cell.scene.slots[location]:
        offsets = {obj: pose.position - slot.position for obj, pose in poses.items()}
        there = [obj for obj, off in offsets.items() if np.hypot(*off[:2]) < slot.radius and 0 < off[2] < PILE_HEIGHT_M]
        for obj in sorted(there, key=lambda obj: -float(poses[obj].position[2])):
            with cell.contacts.handling(obj):
                found = find_grasp(cell, obj, poses[obj], slot.yaw, tilted=True)
            if found is not None:
                return found[1:]
    return None
