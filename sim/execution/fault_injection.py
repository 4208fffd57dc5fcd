"""Fault injection: faults in a running simulation, scheduled or triggered by a user; a seed determines them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, MutableMapping, Sequence

import mujoco
import numpy as np

from sim.execution.faults import Fault
from sim.execution.faulty_devices import DropoutSensor, MissingGrasp, slipping
from sim.geometry.mjcf import solid_geoms, yaw_quat
from sim.geometry.rectangle import Rectangle, overlap
from sim.perception.sensors import ObjectPose, object_pose, stored
from sim.simulation.workcell import CONTACT_FLICKER_S, Workcell
from sim.skills.placing import is_carried
from sim.skills.skill import Skill
from sim.world.places import Slot
from sim.world.shapes import about_z

STREAM = 2
"""Number of the random stream for faults, so that a seed gives the same start poses with and without faults."""

LIFTED_HEIGHT_M = 0.01
"""An object counts as lifted when it is this much higher than where it was gripped."""

SLIP_DELAY_S = 1.0
"""Greatest delay of a slip after the first moment at which it can happen."""

SLIP_DURATION_S = 0.25
"""How long the hand is open when an object slips from it."""

SLIP_GAP_M = 0.02
"""By how much the hand opens then."""

RELOCATION_PROBABILITY = 0.3
"""Probability that an object is moved to a free location rather than to anywhere on the table."""

BETWEEN_FINGERS_M = 0.0275
"""An object nearer than this to the point between the pads counts as between the fingers."""

MAX_DISTANCE_M, MAX_BEARING_RAD = 0.64, np.radians(65)
"""Greatest distance from the base and angle from straight ahead at which a moved object is put down, the same for every
robot: those that ship reach 0.78 m there."""

MAX_SLOT_OFFSET = np.array([0.005, 0.005, np.radians(5)])
"""Greatest offset along x, along y and about z of an object that is moved into a slot: m, m and rad."""

PUSH_SPEEDS_M_S, TOSS_SPEED_M_S = (0.25, 0.6), 0.6
"""Range of an object's horizontal speed when it is knocked over, and its upward speed."""

TUMBLE_SPEEDS_RAD_S = (8.0, 14.0)
"""Range of its rotational speed then."""

PULL_RATE_RAD_S = 15.0
"""Natural frequency of the critically damped spring by which a user pulls an object."""

MAX_PULL_N = 8.0
"""Greatest force of that spring: less than a third of the hand's gripping force."""

MAX_DRAWS = 500
"""Number of poses drawn for a moved object at most, until one is free."""


class FaultInjector:
    """Injects faults into a running simulation when they fall due, or at once.

    Attributes:
        happened: simulated time of each fault that has happened, s, by its index.
    """

    def __init__(
        self, cell: Workcell, skills: MutableMapping[str, Skill], faults: Sequence[Fault], *, seed: int | None
    ) -> None:
        """Inject faults into a simulation and its skills, some of which are wrapped; without a seed it is 0."""
        self._cell, self._skills, self._action, self._seed = cell, skills, 0, seed or 0
        self._faults = list(enumerate(faults))
        self._spares: Iterator[str] = iter(cell.scene.spares)
        self._hanging = {i: _HangingTime(cell) for i, fault in self._faults if fault.kind == "slip"}
        self._rng = [self._generator(i) for i, _ in self._faults]
        self._delays = [float(rng.uniform(0, SLIP_DELAY_S)) for rng in self._rng]
        self._pulled: tuple[str, np.ndarray] | None = None
        self.happened: dict[int, float] = {}
        self._faults_by_kind: dict[str, Callable[[int, Fault], dict[str, str] | None]] = {
            "slip": self._slip,
            "move": self._move,
            "knock": self._knock,
            "miss": self._miss,
            "foreign": self._foreign,
            "blind": self._blind,
        }
        cell.disturb = self._tick

    def begin(self, action: int) -> None:
        """Start the faults that fall due with an executed action, numbered from 1."""
        self._action = action
        self._tick()

    def end(self) -> None:
        """Log the faults that have not happened by the end of the run, and why."""
        for i, fault in self._faults:
            if i in self.happened:
                continue
            ended = f"after action {self._action}" if self._action else "before its first action"
            late = fault.action > self._action
            reason = f"the run ended first, {ended}" if late else "it was never possible before the run ended"
            self._cell.log_event("not injected", fault=str(fault), reason=reason)

    def inject(self, fault: Fault) -> bool:
        """Let a fault happen now if it can, whatever its action; return whether it does."""
        i = len(self._rng)
        self._rng.append(self._generator(i))
        self._delays.append(0.0)
        self._hanging[i] = _HangingTime(self._cell)
        return self._happens(i, fault)

    def pull(self, obj: str, target: np.ndarray) -> None:
        """Pull an object towards a (3,) point, m, by a spring, until the next call or `let_go`."""
        if self._pulled is None or self._pulled[0] != obj:
            self.let_go()
            self._cell.log_event("fault", fault=f"pull:{obj}@{self._action}", object=obj)
        self._pulled = obj, target

    def let_go(self) -> None:
        """Stop pulling."""
        if self._pulled is not None:
            self._cell.data.body(self._pulled[0]).xfrc_applied[:] = 0.0
        self._pulled = None

    def _generator(self, i: int) -> np.random.Generator:
        return np.random.default_rng([self._seed, STREAM, i])

    def _tick(self) -> None:
        for i, fault in self._faults:
            if i not in self.happened and fault.action <= self._action:
                self._happens(i, fault)
        if self._pulled is not None:
            obj, target = self._pulled
            body, joint = self._cell.scene.mujoco.body(obj), self._cell.data.joint(obj)
            mass, weight = float(body.mass[0]), -float(body.mass[0]) * self._cell.scene.mujoco.opt.gravity
            spring = PULL_RATE_RAD_S**2 * (target - joint.qpos[:3]) - 2 * PULL_RATE_RAD_S * joint.qvel[:3]
            force = weight + mass * spring
            force *= min(1.0, MAX_PULL_N / float(np.linalg.norm(force)))
            self._cell.data.body(obj).xfrc_applied[:3] = force

    def _happens(self, i: int, fault: Fault) -> bool:
        """Let a fault happen if it can, and return whether it does."""
        detail = self._faults_by_kind[fault.kind](i, fault)
        if detail is None:
            return False
        self.happened[i] = float(self._cell.data.time)
        self._cell.log_event("fault", fault=str(fault), **detail)
        mujoco.mj_forward(self._cell.scene.mujoco, self._cell.data)
        return True

    def _slip(self, i: int, fault: Fault) -> dict[str, str] | None:
        hanging, now = self._hanging[i].seconds(), float(self._cell.data.time)
        if hanging is None or hanging < self._delays[i]:
            return None
        gripper = self._cell.scene.robot.gripper
        fingers = np.array([self._cell.data.joint(finger).qpos[0] for finger in gripper.joints])
        open_width = gripper.opened(fingers) + SLIP_GAP_M
        until = now + SLIP_DURATION_S
        self._cell.gripper = slipping(self._cell.gripper, self._cell.data, least_width=open_width, until=until)
        return {"object": str(self._cell.contacts.handled)}

    def _miss(self, i: int, fault: Fault) -> dict[str, str] | None:
        self._skills["grasp"] = MissingGrasp(self._skills["grasp"], misses=int(fault.amount))
        return {}

    def _blind(self, i: int, fault: Fault) -> dict[str, str] | None:
        cell = self._cell
        cell.sensor = DropoutSensor(cell.sensor, until=float(cell.data.time) + fault.amount)
        return {}

    def _knock(self, i: int, fault: Fault) -> dict[str, str] | None:
        if self._in_hand(fault.target):
            return None
        rng, velocity = self._rng[i], self._cell.data.joint(fault.target).qvel
        heading = rng.uniform(-np.pi, np.pi)
        direction = np.array([np.cos(heading), np.sin(heading), 0.0])
        velocity[:3] = direction * rng.uniform(*PUSH_SPEEDS_M_S) + [0.0, 0.0, TOSS_SPEED_M_S]
        axes = self._cell.data.body(fault.target).xmat.reshape(3, 3)
        velocity[3:] = axes.T @ np.cross([0.0, 0.0, 1.0], direction) * rng.uniform(*TUMBLE_SPEEDS_RAD_S)
        return {"object": fault.target}

    def _move(self, i: int, fault: Fault) -> dict[str, str] | None:
        if self._in_hand(fault.target):
            return None
        rng, obj = self._rng[i], fault.target
        if rng.random() < RELOCATION_PROBABILITY:
            slots = [slot for row in self._cell.scene.slots.values() for slot in row if self._is_free(slot)]
            if slots:
                self._put_into(rng, obj, slots[rng.integers(len(slots))])
                return {"object": obj}
        height = float(self._cell.scene.shapes[obj].half[2])
        robot = self._cell.scene.robot
        nearest = robot.nearest_m
        for _ in range(MAX_DRAWS):
            far, bearing, yaw = rng.uniform(
                [nearest, -MAX_BEARING_RAD, -np.pi], [MAX_DISTANCE_M, MAX_BEARING_RAD, np.pi]
            )
            heading, (x, y) = robot.yaw + bearing, robot.position[:2]
            position = np.array([x + far * np.cos(heading), y + far * np.sin(heading), height + 0.001])
            if self._fits(obj, position, yaw):
                self._put(obj, position, yaw)
                return {"object": obj}
        return None

    def _foreign(self, i: int, fault: Fault) -> dict[str, str] | None:
        slots = [slot for slot in self._cell.scene.slots[fault.target] if self._is_free(slot)]
        if not slots:
            return None
        obj = next(self._spares)
        self._put_into(self._rng[i], obj, slots[0])
        return {"object": obj}

    def _in_hand(self, obj: str) -> bool:
        """Return whether an object is in the hand or between its open fingers, where it cannot be moved."""
        contacts, data = self._cell.contacts, self._cell.data
        if contacts.handled == obj and data.time - contacts.pressed < CONTACT_FLICKER_S:
            return True
        tool, body = data.site(self._cell.scene.robot.tool).xpos, data.body(obj)
        beside = body.xmat.reshape(3, 3).T @ (tool - body.xpos)
        return self._cell.scene.shapes[obj].distance(beside) < BETWEEN_FINGERS_M

    def _is_free(self, slot: Slot) -> bool:
        """Return whether any object could be placed in a slot without contact; False on objects and where one fell."""
        scene, data = self._cell.scene, self._cell.data
        if scene.model.location(slot.location).on or scene.model.location(slot.location).closed:
            return False
        half = max(float(scene.shapes[obj].half[:2].max()) for obj in scene.shapes)
        place = Rectangle(slot.position[:2], np.full(2, half + MAX_SLOT_OFFSET[0]), slot.yaw)
        poses = [object_pose(scene, data, obj) for obj in scene.shapes if not stored(scene, data, obj)]
        return not any(overlap(place, pose.footprint) for pose in poses)

    def _put_into(self, rng: np.random.Generator, obj: str, slot: Slot) -> None:
        off = rng.uniform(-1, 1, 3) * MAX_SLOT_OFFSET
        height = float(self._cell.scene.shapes[obj].half[2]) + 0.001
        self._put(obj, slot.position + [off[0], off[1], height], slot.yaw + off[2])

    def _put(self, obj: str, position: np.ndarray, yaw: float) -> None:
        joint = self._cell.data.joint(obj)
        joint.qpos[:3], joint.qpos[3:], joint.qvel[:] = position, yaw_quat(yaw), 0.0

    def _fits(self, obj: str, position: np.ndarray, yaw: float) -> bool:
        """Return whether an object at a pose is supported from below, and without contact just above the support."""
        if not is_carried(self._cell, obj, ObjectPose(self._cell.scene.shapes[obj], position, about_z(yaw))):
            return False
        scratch = mujoco.MjData(self._cell.scene.mujoco)
        scratch.qpos[:] = self._cell.data.qpos
        pose = scratch.joint(obj).qpos
        pose[:3], pose[3:] = position, yaw_quat(yaw)
        mujoco.mj_kinematics(self._cell.scene.mujoco, scratch)
        mujoco.mj_collision(self._cell.scene.mujoco, scratch)
        own = solid_geoms(self._cell.scene.mujoco, obj)
        return not np.isin(scratch.contact.geom[: scratch.ncon], own).any()


class _HangingTime:
    """How long an object has hung in the hand; `seconds` must be called in every control period."""

    def __init__(self, cell: Workcell) -> None:
        self._cell = cell
        self._gripped: tuple[str, float] | None = None
        self._since: float | None = None

    def seconds(self) -> float | None:
        """Return for how long something has hung in the hand, s; None if nothing does."""
        cell, now = self._cell, float(self._cell.data.time)
        obj = cell.contacts.handled
        if obj is None or now - cell.contacts.pressed > CONTACT_FLICKER_S:
            self._gripped = self._since = None
            return None
        height = float(cell.data.body(obj).xpos[2])
        if self._gripped is None or self._gripped[0] != obj:
            self._gripped = (obj, height)
        if not cell.contacts.aloft and height - self._gripped[1] < LIFTED_HEIGHT_M:
            return None
        if self._since is None:
            self._since = now
        return now - self._since
