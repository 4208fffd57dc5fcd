"""The plant: the simulated world, its actuators and its recorder. Only its `step` advances the time."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import mujoco
import numpy as np

from sim.errors import UnstableError
from sim.motion.joint_trajectory import JointTrajectory
from sim.motion.trajectory import CONTROL_PERIOD_S, STEPS
from sim.perception.touch import ContactMonitor
from sim.simulation.payload import SHIFT_DURATION_S, Payload
from sim.simulation.recorder import Recorder
from sim.simulation.run import Effort, Event
from sim.world.scene import Scene

CONTACT_FLICKER_S = 0.18
"""Pads that lose contact for less than this still count as holding their object: simulated contacts flicker."""

CONTACT_EPISODE_S = 0.5
"""Contacts of the same two bodies within this time are one event."""


class Observer:
    """Called before and after each control period of a plant that has it in its `observers`.

    It may read or disturb the world, or raise an error, which stops the run.
    """

    def before_period(self, cell: Plant) -> None:
        """Do something before a control period is simulated."""

    def after_period(self, cell: Plant) -> None:
        """Do something after a control period was simulated."""


class Plant:
    """A running simulation of a scene; `step` simulates a control period, in which movements under way continue.

    Attributes:
        scene: the simulated scene.
        data: the MuJoCo state.
        contacts: monitors contacts.
        recorder: records every frame.
        reference: (n,) joint angles at which the arm rests, or will rest when its movement ends, rad.
        events: in order of time.
        glowing: index of the location that marks an object now, or -1.
        width: commanded width between the pads at the end of their movement, m; less than that of a held object, so
            that they press it.
        gripper: maps a commanded width to the one that is sent to the hand, m; faults wrap it.
        observers: called before and after every control period.
    """

    def __init__(self, scene: Scene, data: mujoco.MjData) -> None:
        """Begin in a state in which the arm is at rest."""
        model = scene.mujoco
        self.scene, self.data, self.contacts = scene, data, ContactMonitor(scene)
        self._motors = np.array([model.actuator(name).id for name in scene.robot.joints])
        self._fingers = model.actuator(scene.robot.gripper.actuator).id
        self.width = scene.robot.gripper.width(float(data.ctrl[self._fingers]))
        self.gripper: Callable[[float], float] = float
        # A position actuator of gains kp and kv lags behind a moving command by kv / kp, s.
        stiffness, damping = -model.actuator_biasprm[self._motors, 1:3].T
        self._lag, self._payload = damping / stiffness, Payload(scene, stiffness)
        # Commands delayed by the latency, one per simulation step.
        self._delayed = np.repeat(data.ctrl[None], round(scene.latency / model.opt.timestep), axis=0)
        self._touched: dict[tuple[str, str], float] = {}
        self._qpos = scene.robot.qpos(model)
        self.reference = data.qpos[self._qpos].copy()
        self._begin(JointTrajectory(*np.zeros((2, 0, len(self.reference)))))
        self._widths: list[float] = []
        self.events: list[Event] = []
        self.glowing, self._dark = -1, np.inf
        self.observers: list[Observer] = []
        self.recorder = Recorder(scene)
        self.recorder.record(data, glow=self.glowing)

    def step(self) -> None:
        """Simulate one control period, in which the arm and the fingers continue their movements.

        Raises:
            UnstableError: the simulation diverged.
        """
        data = self.data
        for observer in tuple(self.observers):  # one may remove itself
            observer.before_period(self)
        model, recorder, control = self.scene.mujoco, self.recorder, data.ctrl
        for command in recorder.begin_period(data, self._next_commands()):
            control[:], before = command, data.time
            mujoco.mj_step(model, data)
            if data.time <= before:  # MuJoCo reset a state that is not finite
                raise UnstableError(before)
            if recorder.feel(data):
                recorder.record(data, glow=self.glowing)
        recorder.end_period(data)
        if data.time >= self._dark:
            self.glowing = -1
        self._log_contacts(self.contacts.update(data))
        for observer in tuple(self.observers):
            observer.after_period(self)

    def _log_contacts(self, touches: Iterable[tuple[str, str]]) -> None:
        """Log unwanted contacts as events, one for each episode."""
        now = self.data.time
        for moving, other in touches:
            if now - self._touched.get((moving, other), -np.inf) > CONTACT_EPISODE_S:
                self.log_event("contact", moving=moving, other=other)
            self._touched[moving, other] = now

    def _next_commands(self) -> np.ndarray:
        """Return the (STEPS, nu) commands of the actuators in the next control period."""
        commands = np.repeat(self.data.ctrl[None], STEPS, axis=0)
        width = self.gripper(self._widths.pop(0) if self._widths else self.width)
        if self._samples_left:
            samples = slice(self._passed, self._passed + STEPS)
            self._passed += STEPS
            commands[:, self._motors] = self._leading[samples]
        else:
            commands[:, self._motors] = self.reference
        commands[:, self._fingers] = self.scene.robot.gripper.command(width)
        if self._payload.is_borne:
            if self._payload.mass and self.lost_contact:
                self._payload.shift(0.0)
            commands[:, self._motors] += self._payload.offsets(self.data, STEPS)
        waiting = np.vstack([self._delayed, commands])
        self._delayed = waiting[STEPS:]
        return waiting[:STEPS]

    def log_event(self, kind: str, **detail: Any) -> None:
        """Add an event at the current time."""
        self.events.append(Event(float(self.data.time), kind, detail))

    @property
    def effort(self) -> Effort:
        """Effort of the arm so far."""
        return self.recorder.effort

    @property
    def angles(self) -> np.ndarray:
        """(n,) joint angles of the arm now, rad."""
        return np.asarray(self.data.qpos[self._qpos])

    @property
    def ending(self) -> np.ndarray:
        """(M, n) offsets of the rest of the movement from `reference`, rad, per control period; no rows at rest."""
        return self._movement.positions[self._passed + STEPS - 1 :: STEPS] - self.reference

    def settle(self) -> None:
        """Wait until the arm has ended its movement."""
        while self._samples_left:
            self.step()

    def set_width(self, width: float, seconds: float) -> None:
        """Begin to change the commanded width between the pads linearly to `width`, m, in some seconds."""
        now = self._widths[0] if self._widths else self.width
        self._widths = np.linspace(now, width, max(1, round(seconds / CONTROL_PERIOD_S)) + 1)[1:].tolist()
        self.width = width

    def grip(self, width: float, seconds: float) -> None:
        """Change the commanded width between the pads linearly to `width`, m, and wait until that is done."""
        self.set_width(width, seconds)
        while self._widths:
            self.step()

    @property
    def load(self) -> float:
        """Mass of the held object whose weight is compensated, kg; 0 for none."""
        return self._payload.mass

    def bear(self, obj: str) -> None:
        """Begin to compensate for the weight of an object (`Payload`) until `unload`, or until the pads lose it."""
        self._payload.shift(self.scene.shapes[obj].mass)

    def unload(self) -> None:
        """End the weight compensation, if there is any, and wait until the support carries the object."""
        if self._payload.mass:
            self._payload.shift(0.0)
            self.wait(SHIFT_DURATION_S)

    def glow(self, location: str, seconds: float) -> None:
        """Let a location that marks objects glow for some seconds."""
        self.glowing, self._dark = list(self.scene.slots).index(location), self.data.time + seconds

    def wait(self, seconds: float) -> None:
        """Let time pass, during which a movement continues."""
        for _ in range(round(seconds / CONTROL_PERIOD_S)):
            self.step()

    @property
    def lost_contact(self) -> bool:
        """Whether the pads have pressed nothing for longer than `CONTACT_FLICKER_S`."""
        return bool(self.data.time - self.contacts.pressed > CONTACT_FLICKER_S)

    def _begin(self, movement: JointTrajectory) -> None:
        """Begin to follow a movement instead of the rest of the previous one."""
        self._movement, self._passed = movement, 0
        self._leading = movement.positions + self._lag * movement.velocities

    @property
    def _samples_left(self) -> int:
        """Number of samples of the movement that are left."""
        return len(self._leading) - self._passed
