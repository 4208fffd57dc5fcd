"""Why the arm cannot grasp an object: by how much its location is too far away, or the obstacle above it too low."""

import copy
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import mujoco
import numpy as np

from sim.capability.rehearsal import Rehearsal
from sim.errors import BlockedError, SimulationError
from sim.geometry.mjcf import first_met, is_solid, opaque
from sim.robots.import_mjcf import PREFIX
from sim.simulation.kinematic_cell import KinematicCell
from sim.skills.grasp import GraspSkill
from sim.skills.hand import frame_of
from sim.skills.skill import Skill, SkillError
from sim.world.fixtures import body_name
from sim.world.grasps import ranked
from sim.world.places import under
from sim.world.scene import Scene, initial_state

MOST_CM = 32
"""Greatest trial shift of a location, or of the obstacle above it, cm."""

MOST_APART_MM = 100
"""Greatest trial shift of a location away from an object, mm."""

ROOF_START_M = 0.002
"""Height above an object from which an obstacle above it is searched for, m."""

GRASPS_TRIED = 12
"""Number of grasps for which the missing joint angles are computed."""


class FailureDiagnosis:
    """Finds the least change of a scene after which a rehearsal would succeed with no object dragged or turned."""

    def __init__(self, scene: Scene, cell: KinematicCell, skills: Mapping[str, Skill]) -> None:
        """Take a scene, a cell in which changes of it are tried out, and skills by kind of action."""
        self._scene, self._cell = scene, cell
        grasp = skills["grasp"]
        # Dragging and turning take long to search for, and a greater change lets the hand grasp without them.
        direct = replace(grasp, max_preparations=0, briefly=True) if isinstance(grasp, GraspSkill) else grasp
        self._skills = {**skills, "grasp": direct}
        model = scene.mujoco
        self._fixtures = opaque(model, is_solid(model) & (model.body_weldid[model.geom_bodyid] == 0))

    def reason(self, refused: Rehearsal, error: SimulationError) -> str:
        """Return why a rehearsal that grasps an object at its location fails."""
        if isinstance(error, SkillError):
            return str(error)
        roof, blocked = self._roof(refused), isinstance(error, BlockedError)
        reason, most = None, MOST_CM
        if roof is not None or not blocked:
            below = f" below {self._name(roof)}" if roof is not None and blocked else ""
            to_base = self._scene.robot.position - self._scene.slots[refused.location][0].position
            near = float(np.hypot(*to_base[:2])) < self._scene.robot.nearest_m
            words = "too near to the robot's base" if near else "out of reach"
            shifted = partial(self._moved, refused, -to_base if near else to_base, 0.01)
            if change := _least(shifted, most):
                # If both would help as much, a hand that is blocked lacks height.
                reason, most = f"{words}{below} by {change} cm", change if blocked else change - 1
        if roof is not None:
            # The greatest change first: if it does not help, as is usual, none does.
            change = _least(partial(self._raised, refused, roof), most, first=most)
            reason = f"{self._name(roof)} above too low for the hand by {change} cm" if change else reason
        if reason is None and isinstance(error, BlockedError):
            reason = self._too_close(refused, error)
        return reason or (not blocked and self._joint_limit(refused)) or str(error)

    def _name(self, geom: int) -> str:
        """Return the name of the fixture, or of the body of the user's scene, to which a geom belongs."""
        body = str(self._scene.mujoco.body(int(self._scene.mujoco.geom_bodyid[geom])).name)
        own = next((one.name for one in self._scene.model.fixtures if body_name(one.name) == body), body)
        return own if self._scene.model.scene is None else own.removeprefix(f"{Path(self._scene.model.scene).stem}/")

    def _too_close(self, refused: Rehearsal, error: BlockedError) -> str | None:
        """Return by how much the object in the way is too close; None if moving the location away does not help."""
        refused.arrange(self._cell, self._scene)
        centre = self._scene.slots[refused.location][0].position
        beside = {other: self._cell.observe(other).position - centre for other in error.by if other in refused.places}
        if not beside:
            return None
        nearest = min(beside, key=lambda other: float(np.hypot(*beside[other][:2])))
        helps = partial(self._moved, refused, -beside[nearest], 0.001)
        millimetres = _least(helps, MOST_APART_MM)
        return None if millimetres is None else f"{error}, {millimetres / 10:.1f} cm too close"

    def _moved(self, refused: Rehearsal, direction: np.ndarray, unit: float, count: int) -> bool:
        """Return whether the rehearsal would succeed with the location and its supports shifted by `count` units, m.

        The shift is the horizontal part of `direction`, a (3,) vector.
        """
        level = direction * [1.0, 1.0, 0.0]
        shift = count * unit * level / max(float(np.linalg.norm(level)), 1e-9)
        moved = {refused.location, *under(self._scene.model, refused.location)}
        slots = {
            name: tuple(replace(slot, position=slot.position + shift) for slot in row) if name in moved else row
            for name, row in self._scene.slots.items()
        }
        return refused.run(self._cell, replace(self._scene, slots=slots), self._skills)[1] is None

    def _roof(self, refused: Rehearsal) -> int | None:
        """Return the lowest geom of a fixture above the object; None if there is none."""
        refused.arrange(self._cell, self._scene)
        pose = self._cell.observe(refused.obj)
        top = pose.position + [0.0, 0.0, self._scene.shapes[refused.obj].half[2] + ROOF_START_M]
        geom, _ = first_met(self._fixtures, self._cell.data, top, np.array([0.0, 0.0, 1.0]))
        return geom if geom >= 0 else None

    def _raised(self, refused: Rehearsal, roof: int, centimetres: int) -> bool:
        """Return whether the rehearsal would succeed with the geom above, and what lies on it, raised by some cm."""
        shift = np.array([0.0, 0.0, centimetres / 100])
        model = copy.copy(self._scene.mujoco)
        body = int(model.geom_bodyid[roof])
        underside = float(self._cell.data.geom_xpos[roof, 2])
        model.geom_pos[roof] += self._cell.data.xmat[body].reshape(3, 3).T @ shift
        # The bounding box of the whole body grows as well; those of its parts are switched off.
        model.bvh_aabb[model.body_bvhadr[body], 3:] += shift.max()
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_MIDPHASE
        slots = {
            name: tuple(replace(slot, position=slot.position + shift * (slot.position[2] > underside)) for slot in row)
            for name, row in self._scene.slots.items()
        }
        scene = replace(self._scene, mujoco=model, slots=slots)
        cell = KinematicCell(scene, initial_state(scene), arm=self._cell.arm)
        return refused.run(cell, scene, self._skills)[1] is None

    def _joint_limit(self, refused: Rehearsal) -> str | None:
        """Return which joints would have to move how much farther; None if that would not suffice."""
        refused.arrange(self._cell, self._scene)
        cell, obj = self._cell, refused.obj
        pose = cell.observe(obj)
        frame = frame_of(pose, pose.yaw)
        grasps = list(ranked(pose.shape, cell.scene.robot.gripper, frame))[:GRASPS_TRIED]
        goals = (goal for grasp in grasps for goal in grasp.at(pose.position, frame).symmetric_poses())
        missing = [turns for goal in goals if (turns := cell.arm.missing_turns(goal))]
        if not missing:
            return None
        least = min(missing, key=lambda turns: sum(turns.values()))
        robot = self._scene.robot
        wrist = set(least) <= set(robot.joints[len(robot.joints) - robot.wrist_joints :])
        what = " and ".join(self._lacking(name, excess) for name, excess in least.items())
        return f"{'wrist' if wrist else 'joint'} limit: {what}"

    def _lacking(self, joint: str, excess: float) -> str:
        """Return by how much, rad or m, a joint would have to move farther, in words."""
        slides = self._scene.mujoco.joint(joint).type == mujoco.mjtJoint.mjJNT_SLIDE
        amount = f"{100 * excess:.0f} cm" if slides else f"{np.degrees(excess):.0f} degrees"
        return f"{joint.removeprefix(PREFIX)} lacks {amount}"


def _least(helps: Callable[[int], bool], most: int, *, first: int = 1) -> int | None:
    """Return the least change up to `most` that helps, if greater changes help as well; None if none does.

    `first` is tried first.
    """
    low, high, guess = 0, most + 1, min(first, most)
    while high - low > 1:
        low, high = (low, guess) if helps(guess) else (guess, high)
        guess = min(2 * low, most) if high > most else (low + high) // 2
    return high if high <= most else None
