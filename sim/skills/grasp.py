"""Grasp: take the object below the hand."""

from __future__ import annotations

import numpy as np

from prefplan.models.manipulation.action import Action
from prefplan.models.manipulation.operators import Grasp
from sim.errors import BlockedError
from sim.motion.trajectory import CONTROL_PERIOD_S
from sim.perception.grounding import hand_over
from sim.perception.sensors import ObjectPose, Posture
from sim.simulation.workcell import Workcell
from sim.skills.hand import BLEND_M, HOVER_HEIGHT_M, OPEN_DURATION_S, check_held, free_closing_line, move_tool
from sim.skills.skill import Skill, SkillError
from sim.world.places import AT_RADIUS_M, Slot
from sim.world.shapes import Grip

CLOSING_DISTANCE_M = 0.015
"""Distance of the tool from its goal at which the hand begins to close."""

NEARLY_CLOSED_M = 0.008
"""By how much the hand is wider than the object when the arm has come to rest."""

CLOSE_DURATION_S, SQUEEZE_DURATION_S = 0.2, 0.45
"""Durations of closing the hand so far, and of closing it on the object: a pad that comes first pushes it gently. In
0.3 s, torque rates of the arm reached 121 % of their limit when it pushed the object against the other pad."""

FIRM_DURATION_S = 0.1
"""How long a grip must stay firm."""

GRIP_TIMEOUT_S = 0.6
"""How long to wait for a firm grip once the hand should have closed."""

MOTION_THRESHOLD_M = 0.008
"""An object observed farther than this from its measured position is moving; sensor noise of 1 mm stays below."""


class GraspSkill(Grasp, Skill):
    """Lower the hand on the object below it, close it until both pads press the object firmly, and raise it."""

    def perform(self, cell: Workcell, action: Action) -> None:
        """See `Skill.perform`."""
        obj = action.obj
        slot, shape = _slot_below(cell, obj), cell.scene.shapes[obj]
        pose = cell.measure(obj)
        if pose.posture == Posture.LYING:
            raise BlockedError(f"{obj} fell over", ())
        cell.contacts.handle(obj)
        yaw = shape.yaw_near(pose.yaw, slot.yaw)
        line, grip = free_closing_line(cell, pose.position, [(yaw + grip.turn, grip) for grip in shape.grip_variants])
        target, above = self.closing_position(cell, obj, pose, grip), pose.position + [0.0, 0.0, HOVER_HEIGHT_M]
        cell.set_width(grip.opening, OPEN_DURATION_S)
        yaw = move_tool(cell, above, [line, line + np.pi], within=BLEND_M)
        move_tool(cell, target, [yaw], within=CLOSING_DISTANCE_M, watch=lambda: _check_still(cell, obj, pose))
        cell.grip(grip.width + NEARLY_CLOSED_M, CLOSE_DURATION_S)
        cell.settle()
        cell.set_width(grip.width - cell.scene.robot.gripper.squeeze_m, SQUEEZE_DURATION_S)
        forces = _await_firm_grip(cell)
        if forces is None:
            cell.grip(grip.opening, OPEN_DURATION_S)
        move_tool(cell, above, [yaw], within=BLEND_M)
        if forces is None:
            raise SkillError(f"the fingers closed without a firm grip on {obj}")
        check_held(cell, obj)
        cell.log_event("grasped", object=obj, force=[round(float(force), 2) for force in forces])

    def closing_position(self, cell: Workcell, obj: str, pose: ObjectPose, grip: Grip) -> np.ndarray:
        """Return the (3,) position of the tool, m, at which the fingers close on an object."""
        return pose.position + [0.0, 0.0, grip.lift]


def _slot_below(cell: Workcell, obj: str) -> Slot:
    """Return the slot at the hand's location where an object rests."""
    position = cell.observe(obj).position - [0.0, 0.0, cell.scene.shapes[obj].half[2]]
    slots = [slot for row in cell.scene.slots.values() for slot in row]
    slot = min(slots, key=lambda slot: float(np.linalg.norm(position - slot.position)))
    if np.hypot(*(position - slot.position)[:2]) > AT_RADIUS_M or not hand_over(cell.scene, cell.data, slot.location):
        raise SkillError(f"{obj} is not below the hand")
    return slot


def _check_still(cell: Workcell, obj: str, pose: ObjectPose) -> None:
    """Raise SkillError if an object is not where it was measured."""
    if np.linalg.norm(cell.observe(obj).position - pose.position) > MOTION_THRESHOLD_M:
        raise SkillError(f"{obj} does not lie still")


def _await_firm_grip(cell: Workcell) -> np.ndarray | None:
    """Wait until the grip is firm; return the pads' contact forces in N, or None after a timeout."""
    periods = 0
    for _ in range(round((SQUEEZE_DURATION_S + GRIP_TIMEOUT_S) / CONTROL_PERIOD_S)):
        cell.wait(CONTROL_PERIOD_S)
        periods = periods + 1 if cell.contacts.pad_forces.min() > cell.scene.robot.gripper.firm_force_n else 0
        if periods >= FIRM_DURATION_S / CONTROL_PERIOD_S:
            return cell.contacts.pad_forces
    return None
