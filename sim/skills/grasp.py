"""Grasp: close the hand on the object below it and raise it."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np

from prefplan.models.manipulation.operators import Grasp
from prefplan.models.manipulation.symbolic import Action
from sim.errors import BlockedError, SimulationError
from sim.motion.trajectory import CONTROL_PERIOD_S, ToolPose
from sim.perception.grounding import hand_over
from sim.perception.sensors import ObjectPose
from sim.simulation.workcell import Workcell
from sim.skills.drag import drag_free, find_drag
from sim.skills.grasp_choice import ChosenGrasp, choose_grasp, find_grasp
from sim.skills.hand import (
    BLEND_M,
    LIFT_DURATION_S,
    LIFT_M,
    OPEN_DURATION_S,
    PLANNING_CLEARANCE_M,
    SIDEWAYS,
    check_held,
    most_central,
    move_tool,
    pregrasps,
)
from sim.skills.regrasp import find_regrasp, set_down
from sim.skills.skill import Skill, SkillError, next_release
from sim.skills.transfer import travel
from sim.world.places import AT_RADIUS_M, Slot

CLOSING_DISTANCE_M = 0.015
"""Distance of the tool from its goal at which the hand begins to close."""

NEARLY_CLOSED_M = 0.008
"""By how much the open hand is wider than the object when the arm has stopped at the grasp, m."""

CLOSE_DURATION_S = 0.2
"""Duration of closing the hand until it is `NEARLY_CLOSED_M` wider than the object, s."""

SQUEEZE_DURATION_S = 0.45
"""Duration of then closing the hand on the object, s: the first pad that touches the object pushes it gently."""

FIRM_DURATION_S = 0.1
"""How long a grip must stay firm."""

OFF_GROUND_M = 0.006
"""Height to which an object is raised in a check for what is beside it, so that its support does not count, m."""

RUBBING_M = 0.003
"""Distance within which the object may rub on what is beside it, m."""

OFF_WALL_M = (0.015, 0.012)
"""How far the object is moved away from what is beside it, to the side and up, m."""

RUBBING_LIFT_S = 1.5
"""Least duration of moving an object away from a body beside it, such as a bin's wall on which it leans, or of raising
it along this body, s: it sticks and slips. In 0.5 s, torque rates reach 124 % of their limit, in 1.5 s 50 %."""

GRIP_TIMEOUT_S = 0.6
"""How long to wait for a firm grip once the hand should have closed."""

MORE_GRASPS = 3
"""Number of other grasps, with a tilted hand, that are tried if the approach to one, or the retreat, is blocked."""

LET_GO_WAIT_S = 0.5
"""How long to wait after an object was let go: it may roll, and pads count as pressed for a moment."""

MOTION_THRESHOLD_M = 0.008
"""An object observed farther than this from its measured position is moving; sensor noise of 1 mm stays below."""


@dataclass(frozen=True)
class GraspSkill(Grasp, Skill):
    """Lower the hand on the object below it, close it until both pads press the object firmly, and raise it.

    Attributes:
        max_preparations: how often at most an object is dragged free or regrasped before it is grasped.
        briefly: whether errors may leave out why there is no grasp; finding this takes as long as finding no grasp.
    """

    max_preparations: int = 2
    briefly: bool = False

    def perform(self, cell: Workcell, action: Action, ahead: Sequence[Action] = ()) -> None:
        """See `Skill.perform`; the grasp is one in which the object can be put down where it is released next."""
        try:
            self._take(cell, action.obj, next_release(action.obj, ahead))
        except BlockedError as error:
            if error.by != (action.obj,):
                raise
            raise SkillError(f"{action.obj} itself is in the way") from None

    def _take(self, cell: Workcell, obj: str, destination: str | None) -> None:
        slot = _slot_below(cell, obj)
        cell.touch(obj)
        for tries_left in reversed(range(self.max_preparations + 1)):
            pose = cell.measure(obj)
            try:
                forces = self._lift(cell, obj, pose, slot.yaw, destination)
                break
            except SimulationError as error:
                if not tries_left or not self._prepare(cell, obj, pose, destination, error):
                    raise
        cell.log_event("grasped", object=obj, force=[round(float(force), 2) for force in forces])

    def _prepare(
        self, cell: Workcell, obj: str, pose: ObjectPose, destination: str | None, error: SimulationError
    ) -> bool:
        """Drag free or regrasp an object that cannot be grasped because of an error; return whether that was done."""
        if isinstance(error, SkillError):
            return False
        if isinstance(error, BlockedError):
            walled_in = not any(name in cell.scene.shapes for name in error.by)
            shift = find_drag(cell, obj, pose) if walled_in else None
            if shift is not None:
                drag_free(cell, obj, shift)
            return shift is not None
        regrasp = find_regrasp(cell, obj, pose, destination)
        if regrasp is not None:
            self._pick_up(cell, obj, pose, regrasp.taken)
            set_down(cell, obj, regrasp)
        return regrasp is not None

    def _lift(self, cell: Workcell, obj: str, pose: ObjectPose, yaw: float, destination: str | None) -> np.ndarray:
        """Grasp an object with the first suitable grasp and raise it; return the pads' contact forces, (pads,) N."""
        here, tried = cell.arm.tool(cell.reference), list[ToolPose]()
        failure: BlockedError | None = None
        # If the hand is tilted, as after a release in a shelf, paths to grasps from other directions may be blocked.
        first = None
        if not here.points_down:
            suiting = partial(find_grasp, cell, obj, pose, yaw, destination=destination, certain=True)
            first = suiting(like=here) or (suiting() if destination else None)
        for tilted in (not here.points_down, *[True] * MORE_GRASPS):
            try:
                choice = first or choose_grasp(
                    cell, obj, pose, yaw, destination, tilted=tilted, unlike=tried, briefly=self.briefly
                )
            except SimulationError as error:
                raise failure or error from None
            first = None
            try:
                return self._pick_up(cell, obj, pose, choice)
            except BlockedError as error:
                # The path straight down may be blocked though the hand is free at its end: tilted grasps are next.
                if not choice.tool.points_down:
                    failure = failure or error
                    tried.append(choice.tool)
                    pose = cell.measure(obj)
            except SkillError as error:
                raise failure or error from None
        assert failure is not None
        raise failure

    def _pick_up(self, cell: Workcell, obj: str, pose: ObjectPose, choice: ChosenGrasp) -> np.ndarray:
        """Open the hand, close it on an object and raise it; return the pads' contact forces, (pads,) N.

        Raises `SkillError` without a firm grip, or if the object is lost; `BlockedError` if bodies are in the way. If
        they are in the way of raising the object, it is let go first.
        """
        grasp, before, target = choice
        cell.set_width(grasp.opening, OPEN_DURATION_S)
        travel(cell, [before], height=float(before.position[2]), onward=target)
        _check_still(cell, obj, pose)
        move_tool(cell, target, within=CLOSING_DISTANCE_M, watch=lambda: _check_still(cell, obj, pose))
        cell.grip(grasp.width + NEARLY_CLOSED_M, CLOSE_DURATION_S)
        cell.settle()
        pressing = cell.scene.robot.gripper.pressing(grasp.width, cell.scene.shapes[obj].mass)
        cell.set_width(pressing, SQUEEZE_DURATION_S)
        forces = _await_firm_grip(cell)
        blocked: BlockedError | None = None
        if forces is not None:
            try:
                _raise(cell, obj, before)
            except BlockedError as error:
                blocked = error
        if forces is None or blocked is not None:
            cell.unload()
            cell.grip(grasp.opening, OPEN_DURATION_S)
            cell.wait(LET_GO_WAIT_S)
            move_tool(cell, before, within=BLEND_M)
            raise blocked or SkillError(f"the fingers closed without a firm grip on {obj}")
        check_held(cell, obj)
        return forces


def _raise(cell: Workcell, obj: str, before: ToolPose) -> None:
    """Raise the hand with an object, a heavy one slowly at first, to the pre-grasp pose `before`.

    An object that leans on another body is first moved away from it. If the path is blocked, the hand moves straight to
    a pre-grasp pose of its current pose (up or, if it is tilted, back along its axis), or else halfway to `before`.
    """
    if cell.scene.shapes[obj].is_heavy:
        cell.bear(obj)
        move_tool(cell, cell.arm.tool(cell.reference).shifted([0.0, 0.0, LIFT_M]), seconds=LIFT_DURATION_S)
    slow = 0.0
    if _leans(cell, obj, before):
        shift, slow = _shift_off(cell, obj), RUBBING_LIFT_S
        if shift is not None:
            with suppress(BlockedError):
                move_tool(cell, cell.arm.tool(cell.reference).shifted(shift), seconds=slow)
                before, slow = before.shifted(shift * [1.0, 1.0, 0.0]), 0.0
    try:
        move_tool(cell, before, within=BLEND_M, seconds=slow)
    except BlockedError:
        here = cell.arm.tool(cell.reference)
        for pose in (*pregrasps(here), here.shifted((before.position - here.position) / 2)):
            with suppress(SimulationError):
                move_tool(cell, pose, within=BLEND_M, seconds=slow)
                return
        raise


def _leans(cell: Workcell, obj: str, before: ToolPose) -> bool:
    """Return whether the held object would still be near another body if it were raised a little towards `before`."""
    here = cell.arm.tool(cell.reference)
    rise = before.position - here.position
    return _is_beside(cell, obj, here.shifted(OFF_GROUND_M / max(rise[2], OFF_GROUND_M) * rise), RUBBING_M)


def _shift_off(cell: Workcell, obj: str) -> np.ndarray | None:
    """Return the most central (3,) shift, m, that frees the held object from what is beside it; None if none does."""
    here, shifts = cell.arm.tool(cell.reference), OFF_WALL_M[0] * SIDEWAYS + [0.0, 0.0, OFF_WALL_M[1]]
    free = [shift for shift in shifts if not _is_beside(cell, obj, here.shifted(shift), PLANNING_CLEARANCE_M)]
    return next(iter(most_central(free)), None)


def _is_beside(cell: Workcell, obj: str, tool: ToolPose, clearance: float) -> bool:
    """Return whether the held object would be within a clearance, m, of a body at a tool pose; True if out of reach."""
    try:
        q, _ = cell.arm.reach([tool], near=cell.reference)
    except SimulationError:
        return True
    return any(one == obj for one, _ in cell.collision_checker(held=obj).touches(q, clearance=clearance))


def _slot_below(cell: Workcell, obj: str) -> Slot:
    """Return the slot nearest to an object; raise `SkillError` unless the object is in it and the hand over it."""
    pose = cell.observe(obj)
    position = pose.underside
    slots = [slot for row in cell.scene.slots.values() for slot in row]
    slot = min(slots, key=lambda slot: float(np.linalg.norm(position - slot.position)))
    if np.hypot(*(position - slot.position)[:2]) > AT_RADIUS_M or not hand_over(cell.scene, cell.data, slot.location):
        raise SkillError(f"{obj} is not below the hand")
    return slot


def _check_still(cell: Workcell, obj: str, pose: ObjectPose) -> None:
    """Raise SkillError if an object has moved from its measured pose."""
    if np.linalg.norm(cell.observe(obj).position - pose.position) > MOTION_THRESHOLD_M:
        raise SkillError(f"{obj} does not lie still")


def _await_firm_grip(cell: Workcell) -> np.ndarray | None:
    """Wait until the grip is firm; return the pads' contact forces, (pads,) N, or None after a timeout."""
    periods = 0
    for _ in range(round((SQUEEZE_DURATION_S + GRIP_TIMEOUT_S) / CONTROL_PERIOD_S)):
        cell.wait(CONTROL_PERIOD_S)
        periods = periods + 1 if cell.contacts.pad_forces.min() > cell.scene.robot.gripper.firm_force_n else 0
        if periods >= FIRM_DURATION_S / CONTROL_PERIOD_S:
            return cell.contacts.pad_forces
    return None
