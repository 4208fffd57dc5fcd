"""The running simulation: it drives the actuators, monitors contacts and records states and events."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import mujoco
import numpy as np

from sim.motion.kinematics import Arm
from sim.motion.trajectory import CONTROL_PERIOD_S
from sim.perception.sensors import (
    OBSERVATION_TIMEOUT_S,
    ExactSensor,
    ObjectPose,
    ObservationTimeoutError,
    Sensor,
    mean_pose,
    object_pose,
    on_table,
)
from sim.perception.touch import ContactMonitor
from sim.simulation.collision import CollisionChecker
from sim.simulation.recorder import Recorder
from sim.simulation.rollout import Effort, Event
from sim.world.scene import Scene
from sim.world.shapes import ObjectShape

CONTACT_FLICKER_S = 0.18
"""Pads that lose contact for less than this still hold their object: simulated contacts flicker."""

BRAKING_TIME_S = 0.25
"""Time in which the arm stops when it has lost its load."""

HOLD_OFFSET_M = 0.03
"""Greatest distance of a held object's centre from the point between the pads: beyond, they only brush it."""

CONTACT_EPISODE_S = 0.5
"""Contacts of the same two bodies within this time are one event."""


class Workcell:
    """A scene in motion.

    Attributes:
        scene: what is simulated.
        data: the MuJoCo state.
        arm: kinematics of the arm.
        contacts: monitors contacts.
        recorder: records every frame.
        effort: what the simulation took of the arm so far.
        reference: (n,) joint reference last sent, rad.
        events: in order of time.
        glowing: index of the marking location at work now, or -1.
        sensor: observes the objects.
        width: commanded between the pads, m; less than that of a held object, so that they press it.
        gripper: maps this width to the one that its actuator is sent; faults wrap it.
        disturb: called before every control period is simulated.
    """

    def __init__(self, scene: Scene, data: mujoco.MjData, *, sensor: Sensor | None = None) -> None:
        """Begin in a state in which the arm is at rest; the sensor is exact unless one is given."""
        model = scene.mujoco
        self._motors = [model.actuator(name).id for name in scene.robot.joints]
        self._fingers = model.actuator(scene.robot.gripper.actuator).id
        self.width = float(data.ctrl[self._fingers])
        self.gripper: Callable[[float], float] = float
        # A position actuator of gains kp and kv lags behind a moving command by kv / kp, s.
        self._lag = model.actuator_biasprm[self._motors, 2] / model.actuator_biasprm[self._motors, 1]
        self._substeps = round(CONTROL_PERIOD_S / model.opt.timestep)
        self._touched: dict[tuple[str, str], float] = {}
        self.scene, self.data, self.arm, self.contacts = scene, data, Arm(scene.robot), ContactMonitor(scene)
        self._collision_checker = CollisionChecker(scene, self.contacts)
        self.effort, self._dofs = Effort(), scene.robot.dofs(model)
        self.reference = data.qpos[scene.robot.qpos(model)].copy()
        self.events: list[Event] = []
        self.recorder = Recorder(scene)
        self.glowing = -1
        self.sensor: Sensor = sensor or ExactSensor()
        self.disturb: Callable[[], None] = lambda: None
        self._seen = {obj: object_pose(scene, data, obj) for obj in scene.shapes}
        self.recorder.record(data, glow=self.glowing)

    def log_event(self, kind: str, **detail: Any) -> None:
        """Add an event at the present time."""
        self.events.append(Event(float(self.data.time), kind, detail))

    @property
    def shapes(self) -> dict[str, ObjectShape]:
        """The shapes of the model's objects, and of others that are observed on the table."""
        known = {obj.name for obj in self.scene.model.objects}
        shapes = self.scene.shapes.items()
        return {obj: shape for obj, shape in shapes if obj in known or on_table(self.latest_pose(obj))}

    def latest_pose(self, obj: str) -> ObjectPose | None:
        """Return the pose of an object as observed now, or None if it is not."""
        pose = self.sensor.observe(self.scene, self.data, obj)
        if pose is not None:
            self._seen[obj] = pose
        return pose

    def observe(self, obj: str) -> ObjectPose:
        """Return the observed pose of an object; wait for an observation if there is none now.

        Raises:
            ObservationTimeoutError: it is not observed for `OBSERVATION_TIMEOUT_S`.
        """
        periods_left = round(OBSERVATION_TIMEOUT_S / CONTROL_PERIOD_S)
        while (pose := self.latest_pose(obj)) is None:
            if periods_left == 0:
                raise ObservationTimeoutError(f"nothing has been seen of {obj} for {OBSERVATION_TIMEOUT_S:g} s")
            periods_left -= 1
            self._tick()
        return pose

    def measure(self, obj: str) -> ObjectPose:
        """Return the pose of an object at rest, averaged over the observations that its sensor needs.

        Raises:
            ObservationTimeoutError: as in `observe`.
        """
        return self.survey([obj])[obj]

    def survey(self, objects: Iterable[str]) -> dict[str, ObjectPose]:
        """Return the poses of objects at rest, as `measure` does."""
        samples: dict[str, list[ObjectPose]] = {obj: [self.observe(obj)] for obj in objects}
        for _ in range(self.sensor.samples - 1):
            self._tick()
            for obj, poses in samples.items():
                poses.append(self.observe(obj))
        return {obj: mean_pose(self.scene.shapes[obj], poses) for obj, poses in samples.items()}

    def held(self) -> str | None:
        """Return the object between the pads that both press, short losses of contact aside, or None."""
        obj = self.contacts.handled
        if obj is None or self.data.time - self.contacts.pressed > CONTACT_FLICKER_S:
            return None
        pose = self.latest_pose(obj)
        if pose is None:
            return obj
        offset = pose.position - self.data.site(self.scene.robot.tool).xpos
        return obj if np.linalg.norm(offset) < HOLD_OFFSET_M else None

    @property
    def in_doubt(self) -> bool:
        """Whether the pads have just lost contact with the handled object, and may regain it."""
        return self.contacts.handled is not None and 0 < self.data.time - self.contacts.pressed <= CONTACT_FLICKER_S

    def follow(self, references: np.ndarray) -> None:
        """Drive the arm along (N, n) references, rad, one a control period; it brakes early if it loses its load."""
        points = np.vstack([self.reference, references])
        carried = self.held() if self.contacts.aloft else None
        for done, tick in enumerate(_commands(points, self._substeps, self._lag), 1):
            self._tick(tick)
            if carried and self.held() is None and done < len(references):
                self.log_event("lost", object=carried)
                self.contacts.handle(carried)
                points = _braking(points, done)
                for last in _commands(points, self._substeps, self._lag, moving=True):
                    self._tick(last)
                break
        self.reference = points[-1]
        self.data.ctrl[self._motors] = self.reference

    def grip(self, width: float, seconds: float) -> None:
        """Bring the commanded width between the pads evenly to `width`, m, while the arm rests."""
        ticks = max(1, round(seconds / CONTROL_PERIOD_S))
        for command in np.linspace(self.width, width, ticks + 1)[1:]:
            self.width = float(command)
            self._tick()

    def wait(self, seconds: float) -> None:
        """Let time pass while the arm rests."""
        for _ in range(round(seconds / CONTROL_PERIOD_S)):
            self._tick()

    def collisions(self, q: np.ndarray, *, width: float | None = None, clearance: float = 0.0) -> list[str]:
        """Return the bodies in collision with the robot or its load at (n,) joint angles, rad (`CollisionChecker`)."""
        for obj in self.scene.shapes:
            self.latest_pose(obj)
        return self._collision_checker.touches(self.data, self._seen, q, width=width, clearance=clearance)

    def _tick(self, commands: np.ndarray | None = None) -> None:
        """Simulate one control period, with (substeps, n) commands of the arm's motors, rad, or those it has."""
        data = self.data
        self.disturb()
        data.ctrl[self._fingers] = self.gripper(self.width)
        controls = np.array([data.ctrl] * self._substeps)
        if commands is not None:
            controls[:, self._motors] = commands
        for control in self.recorder.begin_period(data, controls):
            data.ctrl[:] = control
            mujoco.mj_step(self.scene.mujoco, data)
            self.recorder.feel(data)
            if self.recorder.is_due(data):
                self.recorder.record(data, glow=self.glowing)
        self.recorder.end_period(data)
        speeds, torques = data.qvel[self._dofs], data.qfrc_actuator[self._dofs]
        self.effort += Effort(
            CONTROL_PERIOD_S,
            CONTROL_PERIOD_S * float(np.abs(speeds).sum()),
            CONTROL_PERIOD_S * float(np.abs(torques * speeds).sum()),
        )
        for pair in self.contacts.update(data):
            if data.time - self._touched.get(pair, -np.inf) > CONTACT_EPISODE_S:
                self.log_event("contact", moving=pair[0], other=pair[1])
            self._touched[pair] = data.time


def _braking(points: np.ndarray, done: int) -> np.ndarray:
    """Return references that continue from one of several, brake, and stop before the last.

    They begin with the reference that was reached.
    """
    ticks = np.arange(1, round(BRAKING_TIME_S / CONTROL_PERIOD_S) + 1)
    ahead = np.minimum(done + ticks - ticks**2 / (2 * len(ticks)), len(points) - 1)
    low = np.floor(ahead).astype(int)
    high = np.minimum(low + 1, len(points) - 1)
    part = (ahead - low)[:, None]
    return np.vstack([points[done], (1 - part) * points[low] + part * points[high]])


def _commands(points: np.ndarray, substeps: int, lag: np.ndarray, *, moving: bool = False) -> np.ndarray:
    """Return the motor commands at every step of the simulation that track joint references.

    A reference held for a whole control period would jerk the wrist with all its torque, kp times the angle
    covered meanwhile; a smooth curve through them does not.

    Args:
        points: (N + 1, n) rad, the present reference and those to follow.
        substeps: steps of the simulation in a control period.
        lag: (n,) of the motors behind a moving command, s; commands lead by as much.
        moving: whether the arm moves already at the first.

    Returns:
        (N, substeps, n) rad.
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
    return curve + lag / CONTROL_PERIOD_S * slope
