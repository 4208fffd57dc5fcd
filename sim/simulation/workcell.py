"""The running simulation: it drives the actuators, keeps watch and records what happens."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import mujoco
import numpy as np

from sim.motion.collision import Foresight
from sim.motion.kinematics import CONTROL_PERIOD, Arm
from sim.perception.sensors import (
    OBSERVATION_TIMEOUT_S,
    ExactSensor,
    ObjectPose,
    Sensor,
    SightError,
    mean_pose,
    object_pose,
    on_table,
)
from sim.perception.touch import Watch
from sim.robots.panda import ARM_JOINTS, GRIPPER, TCP
from sim.simulation.effort import EffortMeter
from sim.simulation.recorder import Recorder
from sim.simulation.rollout import Event
from sim.world.scene import Scene
from sim.world.shapes import Shape

ACTUATOR_LAG_S = 0.1
"""By how much the arm trails a moving command, s: kv / kp of its actuators, so that commands lead by as much."""

CONTACT_FLICKER_S = 0.18
"""Pads that lose an object for less than this still hold it, s: contacts flicker."""

BRAKING_TIME_S = 0.25
"""How long the arm takes to stop when it has lost what it carries, s."""

HOLD_OFFSET_M = 0.03
"""A held object's centre is this near to the point between the pads, m: beyond, the pads only brush it."""

CONTACT_EPISODE_S = 0.5
"""Touches of the same two bodies within this time are one event, s."""


class Workcell:
    """A scene in motion.

    Attributes:
        scene: what is simulated.
        data: the MuJoCo state.
        arm: kinematics of the arm.
        watch: keeps an eye on contacts.
        recorder: what is kept of every frame.
        meter: adds up the arm's effort.
        reference: (7,) joint reference last sent, rad.
        events: what was worth telling, in order of time.
        glowing: index of the marking location at work now, or -1.
        sensor: sees the objects.
        blind_until: before this time nothing is seen, s.
        misses: how many grasps from now on close on nothing.
        disturb: called before every control period is simulated.
    """

    def __init__(self, scene: Scene, data: mujoco.MjData, *, sensor: Sensor | None = None) -> None:
        """Take over a state in which the arm rests; objects are seen exactly unless a sensor is given."""
        model = scene.mujoco
        self._qpos = [int(model.joint(name).qposadr[0]) for name in ARM_JOINTS]
        self._motors = [model.actuator(name).id for name in ARM_JOINTS]
        self._gripper = model.actuator(GRIPPER).id
        self._substeps = round(CONTROL_PERIOD / model.opt.timestep)
        self._touched: dict[tuple[str, str], float] = {}
        self.scene, self.data, self.arm, self.watch = scene, data, Arm(scene.robot), Watch(scene)
        self._foresight = Foresight(scene, self.watch)
        self.meter = EffortMeter(model, data)
        self.reference = data.qpos[self._qpos].copy()
        self.events: list[Event] = []
        self.recorder = Recorder(scene)
        self.glowing = -1
        self.sensor: Sensor = sensor or ExactSensor()
        self.blind_until, self.misses = -np.inf, 0
        self.disturb: Callable[[], None] = lambda: None
        self._seen = {obj: object_pose(scene, data, obj) for obj in scene.shapes}
        self.recorder.record(data, glow=self.glowing)

    def tell(self, kind: str, **detail: Any) -> None:
        """Add an event at the present time."""
        self.events.append(Event(float(self.data.time), kind, detail))

    @property
    def gripping(self) -> float:
        """The commanded width between the pads, m; narrower than what they hold by what makes them press it."""
        return float(self.data.ctrl[self._gripper])

    @gripping.setter
    def gripping(self, width: float) -> None:
        self.data.ctrl[self._gripper] = width

    @property
    def shapes(self) -> dict[str, Shape]:
        """The shapes of the objects that are there: those of the model, and others that are seen on the table."""
        known = {obj.name for obj in self.scene.model.objects}
        shapes = self.scene.shapes.items()
        return {obj: shape for obj, shape in shapes if obj in known or on_table(self.glimpse(obj))}

    def glimpse(self, obj: str) -> ObjectPose | None:
        """Return where an object is seen now, or None."""
        if self.data.time < self.blind_until:
            return None
        pose = self.sensor.look(self.scene, self.data, obj)
        if pose is not None:
            self._seen[obj] = pose
        return pose

    def see(self, obj: str) -> ObjectPose:
        """Return where an object is seen, waiting for that if need be.

        Raises:
            SightError: it is not seen for `OBSERVATION_TIMEOUT_S`.
        """
        patience = round(OBSERVATION_TIMEOUT_S / CONTROL_PERIOD)
        while (pose := self.glimpse(obj)) is None:
            if patience == 0:
                raise SightError(f"nothing has been seen of {obj} for {OBSERVATION_TIMEOUT_S:g} s")
            patience -= 1
            self._tick()
        return pose

    def measure(self, obj: str) -> ObjectPose:
        """Return where an object at rest is, as well as the sensor can tell; that takes a noisy one some time.

        Raises:
            SightError: as in `see`.
        """
        return self.survey([obj])[obj]

    def survey(self, objects: Iterable[str]) -> dict[str, ObjectPose]:
        """Return where objects at rest are, as well as the sensor can tell.

        Raises:
            SightError: as in `see`.
        """
        looks: dict[str, list[ObjectPose]] = {obj: [self.see(obj)] for obj in objects}
        for _ in range(self.sensor.looks - 1):
            self._tick()
            for obj, poses in looks.items():
                poses.append(self.see(obj))
        return {obj: mean_pose(self.scene.shapes[obj], poses) for obj, poses in looks.items()}

    def held(self) -> str | None:
        """Return the object that both pads press, but for a flicker, and have between them, or None."""
        obj = self.watch.handled
        if obj is None or self.data.time - self.watch.pressed > CONTACT_FLICKER_S:
            return None
        pose = self.glimpse(obj)
        if pose is None:
            return obj
        offset = pose.position - self.data.site(TCP).xpos
        return obj if np.linalg.norm(offset) < HOLD_OFFSET_M else None

    @property
    def in_doubt(self) -> bool:
        """Whether the pads have lost what they handle just now, so that they may be about to press it again or not."""
        return self.watch.handled is not None and 0 < self.data.time - self.watch.pressed <= CONTACT_FLICKER_S

    def follow(self, references: np.ndarray) -> None:
        """Drive the arm along joint references; it stops on the way if it loses what it carries aloft.

        Args:
            references: (N, 7) rad, every `CONTROL_PERIOD`.
        """
        points = np.vstack([self.reference, references])
        carried = self.held() if self.watch.aloft else None
        for done, tick in enumerate(_commands(points, self._substeps).reshape(len(references), self._substeps, 7), 1):
            self._tick(tick)
            if carried and self.held() is None and done < len(references):
                self.tell("lost", object=carried)
                self.watch.handle(carried)
                points = _braking(points, done)
                for last in _commands(points, self._substeps, moving=True).reshape(len(points) - 1, self._substeps, 7):
                    self._tick(last)
                break
        self.reference = points[-1]
        self.data.ctrl[self._motors] = self.reference

    def grip(self, width: float, seconds: float) -> None:
        """Bring the commanded width between the pads evenly to `width`, m, while the arm rests."""
        ticks = max(1, round(seconds / CONTROL_PERIOD))
        for command in np.linspace(self.gripping, width, ticks + 1)[1:]:
            self.gripping = float(command)
            self._tick()

    def wait(self, seconds: float) -> None:
        """Let time pass while the arm rests."""
        for _ in range(round(seconds / CONTROL_PERIOD)):
            self._tick()

    def foresee(self, q: np.ndarray, *, width: float | None = None, clearance: float = 0.0) -> list[str]:
        """Return what the robot, and what it carries, would touch at (7,) joint angles, rad: see `Foresight`."""
        for obj in self.scene.shapes:
            self.glimpse(obj)
        return self._foresight.touches(self.data, self._seen, q, width=width, clearance=clearance)

    def _tick(self, commands: np.ndarray | None = None) -> None:
        """Simulate one control period; record the frames that fall into it.

        Args:
            commands: (substeps, 7) rad, of the arm's motors; None to leave them as they are.
        """
        data = self.data
        self.disturb()
        for substep in range(self._substeps):
            if commands is not None:
                data.ctrl[self._motors] = commands[substep]
            mujoco.mj_step(self.scene.mujoco, data)
            self.recorder.feel(data)
            if self.recorder.is_due(data):
                self.recorder.record(data, glow=self.glowing)
        self.meter.look(data)
        for pair in self.watch.look(data):
            if data.time - self._touched.get(pair, -np.inf) > CONTACT_EPISODE_S:
                self.tell("contact", moving=pair[0], other=pair[1])
            self._touched[pair] = data.time


def _braking(points: np.ndarray, done: int) -> np.ndarray:
    """Return references that go on from one of several, slower and slower, and stop on the way to the last.

    They begin with the reference that was reached.
    """
    ticks = np.arange(1, round(BRAKING_TIME_S / CONTROL_PERIOD) + 1)
    ahead = np.minimum(done + ticks - ticks**2 / (2 * len(ticks)), len(points) - 1)
    low = np.floor(ahead).astype(int)
    high = np.minimum(low + 1, len(points) - 1)
    part = (ahead - low)[:, None]
    return np.vstack([points[done], (1 - part) * points[low] + part * points[high]])


def _commands(points: np.ndarray, substeps: int, *, moving: bool = False) -> np.ndarray:
    """Return what the motors are told at every step of the simulation to keep to joint references.

    A reference held for a whole control period would jerk the wrist with all its torque, kp times the angle
    covered meanwhile; a smooth curve through them does not.

    Args:
        points: (N + 1, 7) rad, the present reference and those to follow.
        substeps: steps of the simulation in a control period.
        moving: whether the arm moves already at the first.

    Returns:
        (N * substeps, 7) rad.
    """
    slopes = np.gradient(points, axis=0)
    slopes[-1] = 0.0
    if not moving:
        slopes[0] = 0.0
    u = (np.arange(1, substeps + 1) / substeps)[:, None]
    p0, p1, m0, m1 = (x[:, None, :] for x in (points[:-1], points[1:], slopes[:-1], slopes[1:]))
    square, cube = 3 * (p1 - p0) - 2 * m0 - m1, m0 + m1 - 2 * (p1 - p0)
    curve = p0 + u * m0 + u**2 * square + u**3 * cube
    slope = m0 + 2 * u * square + 3 * u**2 * cube
    return (curve + ACTUATOR_LAG_S / CONTROL_PERIOD * slope).reshape(-1, 7)
