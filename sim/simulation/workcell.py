"""The running simulation: it drives the actuators, monitors contacts and records states and events."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import mujoco
import numpy as np

from sim.errors import SimulationError
from sim.motion.joint_trajectory import JointTrajectory, through
from sim.motion.kinematics import Arm
from sim.motion.planning import SEARCHES, MotionPlanner
from sim.motion.timing import braking_time, summed
from sim.motion.trajectory import CONTROL_PERIOD_S, ToolPose
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
from sim.simulation.observer import Observer
from sim.simulation.payload import SHIFT_DURATION_S, Payload
from sim.simulation.recorder import Recorder
from sim.simulation.rollout import Effort, Event
from sim.world.scene import Scene
from sim.world.shapes import ObjectShape

CONTACT_FLICKER_S = 0.18
"""Pads that lose contact for less than this still count as holding their object: simulated contacts flicker."""

WATCH_PERIOD_S = 0.05
"""Time between two checks during a movement."""

BLEND_TIME_S = 0.3
"""Longest part of a movement that is blended with the next one."""

HOLD_DISTANCE_M = 0.0085
"""Greatest distance of a held object from the point between the pads. The Panda's pads reach 9.2 mm beyond it; a load
of 3 kg, which creeps down by 1 mm/s, hangs between them until then. What their tips press into, by up to 0.3 mm, is
farther away."""

OBSERVATION_ERRORS = 3
"""Tolerance of that distance for sensor noise, in standard deviations of an observed position."""

CONTACT_EPISODE_S = 0.5
"""Contacts of the same two bodies within this time are one event."""


class Workcell:
    """A running simulation of a scene, with the interface that skills use.

    Attributes:
        scene: the simulated scene.
        data: the MuJoCo state.
        arm: kinematics of the arm.
        planner: plans paths of the arm.
        contacts: monitors contacts.
        recorder: records every frame.
        reference: (n,) joint angles at which the arm rests, or will rest when its movement ends, rad.
        events: in order of time.
        glowing: index of the location that marks an object now, or -1.
        sensor: observes the objects.
        width: commanded width between the pads at the end of their movement, m; less than that of a held object, so
            that they press it.
        gripper: maps this width to the one that is sent to the hand; faults wrap it.
        observers: called before and after every control period.
        destination: location at which the object that is grasped next will be put down; None if that is not known.
    """

    def __init__(
        self,
        scene: Scene,
        data: mujoco.MjData,
        *,
        sensor: Sensor | None = None,
        seed: int = 0,
        arm: Arm | None = None,
        searches: int = SEARCHES,
    ) -> None:
        """Begin in a state in which the arm is at rest; the sensor is exact unless one is given.

        Args:
            scene: the scene to simulate.
            data: its state.
            sensor: observes the objects.
            seed: of the search for paths.
            arm: kinematics of the same robot, whose cache of solutions is reused; None for new ones.
            searches: number of searches for a path.
        """
        model = scene.mujoco
        self._motors = np.array([model.actuator(name).id for name in scene.robot.joints])
        self._fingers = model.actuator(scene.robot.gripper.actuator).id
        self.width = scene.robot.gripper.width(float(data.ctrl[self._fingers]))
        self.gripper: Callable[[float], float] = float
        # A position actuator of gains kp and kv lags behind a moving command by kv / kp, s.
        stiffness, damping = -model.actuator_biasprm[self._motors, 1:3].T
        self._lag, self._payload = damping / stiffness, Payload(scene, stiffness)
        self._substeps = round(CONTROL_PERIOD_S / model.opt.timestep)
        # Commands of the last control period, one per simulation step, and those delayed by the latency.
        self._commands = np.repeat(data.ctrl[None], self._substeps, axis=0)
        self._delayed = np.repeat(data.ctrl[None], round(scene.latency / model.opt.timestep), axis=0)
        self._touched: dict[tuple[str, str], float] = {}
        self.scene, self.data, self.arm, self.contacts = scene, data, arm or Arm(scene.robot), ContactMonitor(scene)
        self._checker = CollisionChecker(scene)
        self.planner = MotionPlanner(scene.robot.ranges(model), self._checker.levers, seed=seed, searches=searches)
        self._qpos = scene.robot.qpos(model)
        self.reference = data.qpos[self._qpos].copy()
        self._begin(JointTrajectory(*np.zeros((2, 0, len(self.reference)))))
        self._widths: list[float] = []
        self.events: list[Event] = []
        self.recorder = Recorder(scene)
        self.glowing, self._dark = -1, np.inf
        self.sensor: Sensor = sensor or ExactSensor()
        self.observers: list[Observer] = []
        self.destination: str | None = None
        self._seen = {obj: object_pose(scene, data, obj) for obj in scene.shapes}
        self.recorder.record(data, glow=self.glowing)

    def log_event(self, kind: str, **detail: Any) -> None:
        """Add an event at the current time."""
        self.events.append(Event(float(self.data.time), kind, detail))

    @property
    def effort(self) -> Effort:
        """Effort of the arm so far."""
        return self.recorder.effort

    @property
    def shapes(self) -> dict[str, ObjectShape]:
        """The shapes of the model's objects, and of other objects observed on the table."""
        known = {obj.name for obj in self.scene.model.objects}
        shapes = self.scene.shapes.items()
        return {obj: shape for obj, shape in shapes if obj in known or on_table(self.latest_pose(obj))}

    def latest_pose(self, obj: str) -> ObjectPose | None:
        """Return the pose of an object as observed now, or None if it is not observed."""
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
        """Return the object that both pads press, with short losses of contact ignored, or None."""
        obj = self.contacts.handled
        if obj is None or self._lost_contact:
            return None
        return obj if self._is_between_pads(obj) else None

    @property
    def _lost_contact(self) -> bool:
        """Whether the pads have pressed nothing for longer than `CONTACT_FLICKER_S`."""
        return bool(self.data.time - self.contacts.pressed > CONTACT_FLICKER_S)

    def _is_between_pads(self, obj: str) -> bool:
        """Return whether an object is near enough to the pads to be held; True if it is not observed now."""
        pose = self.latest_pose(obj)
        if pose is None:
            return True
        tool = self.data.site(self.scene.robot.tool)
        distance = self.scene.shapes[obj].distance(pose.rotation.T @ (tool.xpos - pose.position))
        # `sensor.error` is that of a mean of `samples` observations; this is a single one.
        return distance < HOLD_DISTANCE_M + OBSERVATION_ERRORS * np.sqrt(self.sensor.samples) * self.sensor.error

    @property
    def in_doubt(self) -> bool:
        """Whether the pads have just lost contact with the handled object and may regain it."""
        return self.contacts.handled is not None and 0 < self.data.time - self.contacts.pressed <= CONTACT_FLICKER_S

    @property
    def angles(self) -> np.ndarray:
        """(n,) joint angles of the arm now, rad."""
        return np.asarray(self.data.qpos[self._qpos])

    @property
    def ending(self) -> np.ndarray:
        """(M, n) offsets of the rest of the movement from `reference`, rad, per control period; no rows at rest."""
        return self._movement.positions[self._passed + self._substeps - 1 :: self._substeps] - self.reference

    def blended(self, references: np.ndarray) -> np.ndarray:
        """Return (N, n) references, rad, with the rest of the previous movement added, as the arm will follow them."""
        return summed(references, self.ending)

    def follow(self, references: np.ndarray, *, within: float = 0.0, watch: Callable[[], None] = lambda: None) -> None:
        """Drive the arm along (N, n) references, rad, one per control period; it brakes if it loses its load.

        They begin at `reference`. The rest of the previous movement is added to them, so that the arm need not stop in
        between (`JointTrajectory.out_of`).

        Args:
            references: joint angles, rad.
            within: return once the tool is this near to its goal, m, at most `BLEND_TIME_S` before the end: the arm
                continues to its goal as time passes. 0 to return when the arm is at rest.
            watch: called every `WATCH_PERIOD_S`; if it raises an error, the arm brakes.
        """
        movement = through(np.vstack([self.reference, references]), self._substeps)
        self._begin(movement.out_of(self._movement.after(self._passed), self.reference))
        self.reference = references[-1]
        left = self._substeps * self._periods_within(within)
        watched = self._substeps * round(WATCH_PERIOD_S / CONTROL_PERIOD_S)
        carried = self.held() if self.contacts.aloft else None
        while self._samples_left > left:
            self._tick()
            if self._samples_left % watched:
                continue
            if carried and self._samples_left and self.held() is None:
                self.log_event("lost", object=carried)
                self.contacts.handle(carried)
                self.brake()
            try:
                watch()
            except SimulationError:
                self.brake()
                raise

    def brake(self) -> None:
        """Stop the arm on its path, within its limits."""
        if self._samples_left:
            ending = self._movement.after(self._passed)
            periods = np.ceil(braking_time(self.scene.robot, ending.velocities[0]) / CONTROL_PERIOD_S)
            self._begin(ending.braked(int(periods) * self._substeps))
            self.reference = self._movement.positions[-1]
            self.settle()

    def settle(self) -> None:
        """Wait until the arm has ended its movement."""
        while self._samples_left:
            self._tick()

    def set_width(self, width: float, seconds: float) -> None:
        """Begin to change the commanded width between the pads linearly to `width`, m, in some seconds."""
        now = self._widths[0] if self._widths else self.width
        self._widths = np.linspace(now, width, max(1, round(seconds / CONTROL_PERIOD_S)) + 1)[1:].tolist()
        self.width = width

    def grip(self, width: float, seconds: float) -> None:
        """Change the commanded width between the pads linearly to `width`, m, and wait until that is done."""
        self.set_width(width, seconds)
        while self._widths:
            self._tick()

    @property
    def load(self) -> float:
        """Mass of the heavy object that the arm bears, kg; 0 for none."""
        return self._payload.mass

    def bear(self, obj: str) -> None:
        """Begin to compensate for the weight of an object (`Payload`) until `unload`, or until the pads lose it."""
        self._payload.shift(self.scene.shapes[obj].mass)

    def unload(self) -> None:
        """End the compensation for a weight, if there is any, and wait until the support carries it."""
        if self._payload.mass:
            self._payload.shift(0.0)
            self.wait(SHIFT_DURATION_S)

    def glow(self, location: str, seconds: float) -> None:
        """Let the lamp of a location that marks objects glow for some seconds."""
        self.glowing, self._dark = list(self.scene.slots).index(location), self.data.time + seconds

    def wait(self, seconds: float) -> None:
        """Let time pass, during which a movement continues."""
        for _ in range(round(seconds / CONTROL_PERIOD_S)):
            self._tick()

    def collisions(self, q: np.ndarray, *, width: float | None = None, clearance: float = 0.0) -> list[str]:
        """Return the bodies in collision with the robot or its load at (n,) joint angles, rad (`CollisionChecker`)."""
        return sorted({other for _, other in self.touches(q, width=width, clearance=clearance)})

    def touches(
        self, q: np.ndarray, *, width: float | None = None, clearance: float = 0.0
    ) -> frozenset[tuple[str, str]]:
        """Return the collisions at (n,) joint angles, rad; see `CollisionChecker.touches`."""
        return self.collision_checker().touches(q, width=width, clearance=clearance)

    def touches_hand(self, collision: tuple[str, str]) -> bool:
        """Return whether a collision is one of the hand with what is not of the robot: no elbow would avoid it."""
        return self._checker.touches_hand(collision)

    def hand_is_inside(self, tool: ToolPose, *, width: float) -> bool:
        """Return False: in a run, where each check needs another observation, only reachable poses are checked.

        `KinematicCell` rejects poses of the hand before inverse kinematics.
        """
        return False

    def collision_checker(
        self, *, held: bool = False, width: float | None = None, touching: bool = True
    ) -> CollisionChecker:
        """Observe all objects; return the checker of what would be in collision from now on.

        Args:
            held: the handled object moves with the hand though it is not aloft yet, or no more.
            width: between the pads, m; None for the present one.
            touching: whether the fingers may touch the handled object though it does not move with the hand.
        """
        seen = {obj: self.latest_pose(obj) for obj in self.scene.shapes}
        handled = self.contacts.handled
        carried = (held or self.contacts.aloft) and handled is not None and seen[handled] is not None
        touched = handled if touching or carried else None
        self._checker.see(self.data, self._seen, handled=touched, held=carried, width=width)
        return self._checker

    def _periods_within(self, distance: float) -> int:
        """Return the number of final control periods of the movement in which the tool is this near to its goal, m."""
        goal = self.arm.tool(self.reference).position
        ending = self.ending[-round(BLEND_TIME_S / CONTROL_PERIOD_S) - 1 : -1] if distance else self.ending[:0]
        for periods, offset in enumerate(ending[::-1]):
            if np.linalg.norm(self.arm.tool(self.reference + offset).position - goal) > distance:
                return periods
        return len(ending)

    def _begin(self, movement: JointTrajectory) -> None:
        """Begin to follow a movement instead of the rest of the previous one."""
        self._movement, self._passed = movement, 0
        self._leading = movement.positions + self._lag * movement.velocities

    @property
    def _samples_left(self) -> int:
        """Number of samples of the movement that are left."""
        return len(self._leading) - self._passed

    def _tick(self) -> None:
        """Simulate one control period, in which the arm and the fingers continue their movements."""
        data, commands, steps = self.data, self._commands, self._substeps
        for observer in self.observers:
            observer.before_period(self)
        width = self.gripper(self._widths.pop(0) if self._widths else self.width)
        if self._samples_left:
            samples = slice(self._passed, self._passed + steps)
            self._passed += steps
            references = self._movement.positions[samples]
            commands[:, self._motors] = self._leading[samples]
        else:
            references = self.reference[None].repeat(steps, axis=0)
            commands[:] = commands[-1]
        commands[:, self._fingers] = self.scene.robot.gripper.command(width)
        if self._payload.is_borne:
            if self._payload.mass and self._lost_contact:
                self._payload.shift(0.0)
            commands = commands.copy()
            commands[:, self._motors] += self._payload.offsets(data, steps)
        if len(self._delayed):
            waiting = np.vstack([self._delayed, commands])
            commands, self._delayed = waiting[:steps], waiting[steps:]
        model, recorder, control = self.scene.mujoco, self.recorder, data.ctrl
        for command in recorder.begin_period(data, commands, references):
            control[:] = command
            mujoco.mj_step(model, data)
            if recorder.feel(data):
                recorder.record(data, glow=self.glowing)
        recorder.end_period(data)
        if data.time >= self._dark:
            self.glowing = -1
        for pair in self.contacts.update(data):
            if data.time - self._touched.get(pair, -np.inf) > CONTACT_EPISODE_S:
                self.log_event("contact", moving=pair[0], other=pair[1])
            self._touched[pair] = data.time
        for observer in self.observers:
            observer.after_period(self)
