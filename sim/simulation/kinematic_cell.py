"""A workcell without physics: the arm is at its goal at once, and a held object moves with the hand."""

from collections.abc import Callable, Hashable

import mujoco
import numpy as np

from sim.motion.joint_trajectory import JointTrajectory
from sim.motion.kinematics import Arm
from sim.motion.trajectory import CONTROL_PERIOD_S, ToolPose
from sim.robots.gripper import SuctionGripper
from sim.simulation.collision import CollisionChecker
from sim.simulation.workcell import Workcell
from sim.world.scene import Scene

Followed = tuple[np.ndarray, float, tuple[str, np.ndarray] | None]
"""A movement: its (N, n) joint angles, rad, the width between the pads, m, and the held object, if any, with its (3,)
position in the hand, m."""

CONTACT_M = 0.002
"""The hand counts as closed if its commanded width is less than the object's by more than this, m."""

PRESSED_N = 12.5
"""Force on each pad while its tip presses on an object, N: the skill's target force (`sim.skills.drag`). With it, the
Panda's fingers drag a quarter of a kilogram."""

PARALLEL = 0.99
"""Least cosine of the angle between the closing directions of the hand and of the pair of surfaces that it holds."""


class KinematicCell(Workcell):
    """A workcell in which skills are tried out: they plan and check the same motions as in a run, and nothing slips.

    `begin` sets its state, in which some objects of the scene may be missing.

    Attributes:
        followed: the movements since `begin`.
    """

    def __init__(self, scene: Scene, data: mujoco.MjData, *, arm: Arm | None = None) -> None:
        """See `Workcell`. Paths need not be short, so a path is searched for only once."""
        super().__init__(scene, data, arm=arm, searches=1)
        self._finger_qpos = [int(scene.mujoco.joint(name).qposadr[0]) for name in scene.robot.gripper.joints]
        self._in_hand: tuple[np.ndarray, np.ndarray] | None = None
        self._foreseen: tuple[str | None] | None = None
        self._answers: dict[Hashable, dict[Hashable, bool]] = {}
        self.followed: list[Followed] = []

    def begin(self, scene: Scene, qpos: np.ndarray) -> None:
        """Start at rest at (nq,) positions, in a scene of the same MuJoCo model that has only the objects present."""
        self.scene, self._in_hand, self._foreseen, self.followed = scene, None, None, []
        self.touch(None)
        self.contacts.pressed = -np.inf
        self._payload.shift(0.0)
        self.set_width(scene.robot.gripper.opening_m, 0.0)
        self.data.qpos[:] = qpos
        self.reference = self.angles.copy()
        mujoco.mj_kinematics(scene.mujoco, self.data)
        self._seen = {}
        for obj in scene.shapes:
            self.latest_pose(obj)

    def follow(
        self, movement: JointTrajectory, *, within: float = 0.0, watch: Callable[[], None] = lambda: None
    ) -> None:
        """Put the arm at the end of a movement; if the hand is closed but empty, step along it, as it may drag."""
        self.step()
        rows, obj = movement.references, self.contacts.handled
        load = None if obj is None or self._in_hand is None else (obj, self._in_hand[0])
        self.followed.append((np.vstack([self.angles, rows]), self.width, load))
        for q in rows if self._is_closed() and self._in_hand is None else rows[-1:]:
            self._go(q)
            watch()

    def _go(self, q: np.ndarray) -> None:
        """Put the arm at (n,) joint angles, rad, with the object that it holds or drags."""
        obj, pressed, before = self.contacts.handled, self._presses(), self._tool().position
        self.reference = q
        self.data.qpos[self._qpos] = q
        mujoco.mj_kinematics(self.scene.mujoco, self.data)
        if pressed:
            self.data.joint(obj).qpos[:2] += (self._tool().position - before)[:2]
        self._carry()
        self.step()

    def touches(
        self, q: np.ndarray, *, touching: str | None = None, width: float | None = None, clearance: float = 0.0
    ) -> frozenset[tuple[str, str]]:
        """See `Workcell.touches`; with a given width, objects are observed again only after something has moved."""
        if width is None:
            self._foreseen = None
        self._foresee(touching)
        return self._checker.touches(q, width=width, clearance=clearance)

    def hand_is_inside(self, tool: ToolPose, *, touching: str, width: float) -> bool:
        """See `Workcell.hand_is_inside`."""
        self._foresee(touching)
        return self._checker.hand_is_inside(tool, width=width)

    def answers(self, obj: str) -> dict[Hashable, bool]:
        """See `Workcell.answers`."""
        others = tuple((name, self.data.joint(name).qpos.tobytes()) for name in self.scene.shapes if name != obj)
        return self._answers.setdefault((obj, others), {})

    def _foresee(self, touching: str | None) -> None:
        """Observe the objects again if something has moved, or if the fingers may touch another object."""
        if self._foreseen != (touching,):
            self.collision_checker(touching=touching)
            self._foreseen = (touching,)

    def collision_checker(
        self, *, touching: str | None = None, held: str | None = None, width: float | None = None
    ) -> CollisionChecker:
        """See `Workcell.collision_checker`."""
        self._foreseen = None
        return super().collision_checker(touching=touching, held=held, width=width)

    def step(self) -> None:
        """Close or open the hand as commanded, and let a control period pass."""
        self._widths.clear()
        self._foreseen = None
        self.data.time += CONTROL_PERIOD_S
        obj, gripper = self.contacts.handled, self.scene.robot.gripper
        width = self.width
        if obj is not None and self._is_closed() and (self._in_hand or self._is_between_pads(obj)):
            if self._in_hand is None:
                tool, pose = self._tool(), self.data.body(obj)
                turn = tool.rotation.T
                self._in_hand = turn @ (pose.xpos - tool.position), turn @ pose.xmat.reshape(3, 3)
            self.contacts.pad_forces[:] = 2 * gripper.firm_force_n
            self.contacts.pressed, width = float(self.data.time), self._extent(obj)
        else:
            # A released object is not held from now on: there is no contact flicker to bridge (`CONTACT_FLICKER_S`).
            self._in_hand, self.contacts.pressed = None, -np.inf
            self.contacts.pad_forces[:] = PRESSED_N if self._presses() else 0.0
        self.data.qpos[self._finger_qpos] = gripper.positions(max(width, 0.0))
        mujoco.mj_kinematics(self.scene.mujoco, self.data)

    def _is_closed(self) -> bool:
        """Return whether the commanded width is less than that of the handled object."""
        obj = self.contacts.handled
        return obj is not None and self.width < self._extent(obj) - CONTACT_M

    def _presses(self) -> bool:
        """Return whether the fingertips of the closed hand press on the top of the handled object."""
        obj = self.contacts.handled
        if obj is None or self._in_hand is not None or not self._is_closed():
            return False
        tips = self._tool().ahead(self.scene.robot.gripper.fingertip_m)
        half, off = self.scene.shapes[obj].half, tips - self.data.body(obj).xpos
        return bool(off[2] < half[2] and np.hypot(*off[:2]) < half[:2].max())

    def _carry(self) -> None:
        """Move the held object with the hand."""
        obj = self.contacts.handled
        if obj is None or self._in_hand is None:
            return
        tool, (offset, rotation) = self._tool(), self._in_hand
        pose = self.data.joint(obj).qpos
        pose[:3] = tool.position + tool.rotation @ offset
        mujoco.mju_mat2Quat(pose[3:], (tool.rotation @ rotation).ravel())
        mujoco.mj_kinematics(self.scene.mujoco, self.data)

    def _tool(self) -> ToolPose:
        """Return the tool's pose."""
        site = self.data.site(self.scene.robot.tool)
        return ToolPose(site.xpos.copy(), site.xmat.reshape(3, 3).copy())

    def _extent(self, obj: str) -> float:
        """Return the width of an object along the closing direction, m; 0 for a suction cup, which has no width."""
        if isinstance(self.scene.robot.gripper, SuctionGripper):
            return 0.0
        shape, turn = self.scene.shapes[obj], self.data.body(obj).xmat.reshape(3, 3)
        tool = self._tool()
        closing, position = turn.T @ tool.rotation[:, 1], turn.T @ (tool.position - self.data.body(obj).xpos)
        # A mesh may be held by a part, such as a handle.
        pairs = [pair for pair in shape.pairs if abs(pair.direction @ closing) > PARALLEL]
        if pairs:
            return min(pairs, key=lambda pair: float(np.linalg.norm(pair.position - position))).width
        return 2 * shape.support(closing)
