"""The running simulation: it drives the actuators, keeps watch and records what happens."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from sim.effort import EffortMeter
from sim.foresight import Foresight
from sim.grounding import ObjectPose, object_pose
from sim.motion import CONTROL_PERIOD, Arm
from sim.panda import ARM_JOINTS, GRIPPER, TCP
from sim.recorder import Recorder
from sim.rollout import Event
from sim.scene import Scene
from sim.watch import Watch

LAG = 0.1
"""By how much the arm trails a moving command, s: kv / kp of its actuators, so that commands lead by as much."""

FLICKER = 0.2
"""Pads that lose an object for less than this still hold it, s: contacts flicker."""

HOLD_OFFSET = 0.03
"""A held object's centre is this near to the point between the pads, m: beyond, the pads only brush it."""

EPISODE = 0.5
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
    """

    def __init__(self, scene: Scene, data: mujoco.MjData) -> None:
        """Take over a state in which the arm rests."""
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
        self.recorder.record(data, glow=self.glowing)

    def tell(self, kind: str, **detail: Any) -> None:
        """Add an event at the present time."""
        self.events.append(Event(float(self.data.time), kind, detail))

    def see(self, thing: str) -> ObjectPose:
        """Return where an object is, as far as the skills know."""
        return object_pose(self.scene, self.data, thing)

    def held(self) -> str | None:
        """Return the object that both pads press, but for a flicker, and have between them, or None."""
        thing = self.watch.handled
        if thing is None or self.data.time - self.watch.pressed > FLICKER:
            return None
        offset = self.see(thing).position - self.data.site(TCP).xpos
        return thing if np.linalg.norm(offset) < HOLD_OFFSET else None

    def follow(self, references: np.ndarray) -> None:
        """Drive the arm along joint references.

        Args:
            references: (N, 7) rad, every `CONTROL_PERIOD`.
        """
        commands = _commands(self.reference, references, self._substeps)
        for tick in commands.reshape(len(references), self._substeps, 7):
            self._tick(tick)
        self.reference = references[-1]
        self.data.ctrl[self._motors] = self.reference

    def grip(self, width: float, seconds: float) -> None:
        """Bring the commanded width between the pads evenly to `width`, m, while the arm rests."""
        ticks = max(1, round(seconds / CONTROL_PERIOD))
        for command in np.linspace(self.data.ctrl[self._gripper], width, ticks + 1)[1:]:
            self.data.ctrl[self._gripper] = command
            self._tick()

    def wait(self, seconds: float) -> None:
        """Let time pass while the arm rests."""
        for _ in range(round(seconds / CONTROL_PERIOD)):
            self._tick()

    def foresee(self, q: np.ndarray, *, width: float | None = None, clearance: float = 0.0) -> list[str]:
        """Return what the robot, and what it carries, would touch at (7,) joint angles, rad: see `Foresight`."""
        return self._foresight.touches(self.data, q, width=width, clearance=clearance)

    def _tick(self, commands: np.ndarray | None = None) -> None:
        """Simulate one control period; record the frames that fall into it.

        Args:
            commands: (substeps, 7) rad, of the arm's motors; None to leave them as they are.
        """
        data = self.data
        for substep in range(self._substeps):
            if commands is not None:
                data.ctrl[self._motors] = commands[substep]
            mujoco.mj_step(self.scene.mujoco, data)
            self.recorder.feel(data)
            if self.recorder.is_due(data):
                self.recorder.record(data, glow=self.glowing)
        self.meter.look(data)
        for pair in self.watch.look(data):
            if data.time - self._touched.get(pair, -np.inf) > EPISODE:
                self.tell("contact", moving=pair[0], other=pair[1])
            self._touched[pair] = data.time


def _commands(start: np.ndarray, references: np.ndarray, substeps: int) -> np.ndarray:
    """Return what the motors are told at every step of the simulation to keep to joint references.

    A reference held for a whole control period would jerk the wrist with all its torque, kp times the angle
    covered meanwhile; a smooth curve through them does not.

    Returns:
        (N * substeps, 7) rad.
    """
    points = np.vstack([start, references])
    slopes = np.gradient(points, axis=0)
    slopes[[0, -1]] = 0.0
    u = (np.arange(1, substeps + 1) / substeps)[:, None]
    p0, p1, m0, m1 = (x[:, None, :] for x in (points[:-1], points[1:], slopes[:-1], slopes[1:]))
    square, cube = 3 * (p1 - p0) - 2 * m0 - m1, m0 + m1 - 2 * (p1 - p0)
    curve = p0 + u * m0 + u**2 * square + u**3 * cube
    slope = m0 + 2 * u * square + 3 * u**2 * cube
    return (curve + LAG / CONTROL_PERIOD * slope).reshape(-1, 7)
