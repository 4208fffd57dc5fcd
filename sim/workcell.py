"""The running simulation: it drives the actuators, records what happens and watches limits and contacts."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np

from sim.grounding import HOLD_FORCE, HOLD_OFFSET, object_pose, pad_forces
from sim.motion import CONTROL_PERIOD, Arm
from sim.panda import ARM_JOINTS, FINGER_JOINTS, GRIPPER, PADS, TCP, VELOCITY_LIMITS
from sim.rollout import FRAME_RATE, Event
from sim.scene import Scene

LAG = 0.1
"""By how much the arm trails a moving command, s: kv / kp of its actuators, so that commands lead by as much."""

FLICKER = 0.2
"""Pads that lose an object for less than this still hold it, s: contacts flicker."""

EPISODE = 0.5
"""Touches of the same two bodies within this time are one event, s."""


class Workcell:
    """A scene in motion.

    Attributes:
        scene: what is simulated.
        data: the MuJoCo state.
        arm: kinematics of the arm.
        reference: (7,) joint reference last sent, rad.
        events: what was worth telling, in order of time.
        times: when each recorded frame was taken, s.
        frames: recorded positions, each (nq,).
        glow: for each frame, index of the marking location at work or -1.
        glowing: the one at work now.
        speed_share: (7,) greatest joint speeds so far, in shares of their limits.
        torque_share: (7,) greatest joint torques so far, in shares of their limits.
    """

    def __init__(self, scene: Scene, data: mujoco.MjData) -> None:
        """Take over a state with the arm at rest."""
        model = scene.mujoco
        self.scene, self.data, self.arm = scene, data, Arm()
        self._qpos = [int(model.joint(name).qposadr[0]) for name in ARM_JOINTS]
        self._dofs = [int(model.joint(name).dofadr[0]) for name in ARM_JOINTS]
        self._fingers = [int(model.joint(name).qposadr[0]) for name in FINGER_JOINTS]
        self._motors = [model.actuator(name).id for name in ARM_JOINTS]
        self._gripper = model.actuator(GRIPPER).id
        self._pads = [model.geom(name).id for name in PADS]
        self._torque_limits = model.actuator_forcerange[self._motors, 1]
        self._robot = _below(model, "link0")
        self._moving = self._robot
        self._target = -1
        self._pressed = -np.inf
        self._touched: dict[tuple[str, str], float] = {}
        self._scratch = mujoco.MjData(model)
        self.reference = data.qpos[self._qpos].copy()
        self.events: list[Event] = []
        self.times: list[float] = []
        self.frames: list[np.ndarray] = []
        self.glow: list[int] = []
        self.glowing = -1
        self.speed_share, self.torque_share = np.zeros(7), np.zeros(7)
        self._record()

    def tell(self, kind: str, **detail: Any) -> None:
        """Add an event at the present time."""
        self.events.append(Event(float(self.data.time), kind, detail))

    def follow(self, references: np.ndarray) -> None:
        """Drive the arm along joint references.

        Args:
            references: (N, 7) rad, every `CONTROL_PERIOD`.
        """
        for reference in references:
            self.data.ctrl[self._motors] = reference + LAG * (reference - self.reference) / CONTROL_PERIOD
            self.reference = reference
            self._tick()
        self.data.ctrl[self._motors] = self.reference

    def grip(self, width: float, seconds: float) -> None:
        """Bring the commanded width between the pads evenly to `width`, m, while the arm rests."""
        for command in np.linspace(self.data.ctrl[self._gripper], width, round(seconds / CONTROL_PERIOD) + 1)[1:]:
            self.data.ctrl[self._gripper] = command
            self._tick()

    def wait(self, seconds: float) -> None:
        """Let time pass while the arm rests."""
        for _ in range(round(seconds / CONTROL_PERIOD)):
            self._tick()

    @contextmanager
    def handling(self, thing: str, *, aloft: bool = False) -> Iterator[None]:
        """Allow the pads to touch an object, for the time of a `with` block.

        Args:
            thing: the object.
            aloft: it hangs in the air: it counts as part of the robot, which may touch nothing.
        """
        self._target = self.scene.mujoco.body(thing).id
        self._pressed = self.data.time if aloft else -np.inf
        if aloft:
            self._moving = self._robot.copy()
            self._moving[self._target] = True
        try:
            yield
        finally:
            self._target, self._moving = -1, self._robot

    def holds(self, thing: str) -> bool:
        """Return whether both pads press an object, but for a flicker, and have it between them."""
        if self.scene.mujoco.body(thing).id == self._target:
            pressed = self.data.time - self._pressed < FLICKER
        else:
            pressed = bool(pad_forces(self.scene, self.data, thing).min() > HOLD_FORCE)
        offset = object_pose(self.scene, self.data, thing).position - self.data.site(TCP).xpos
        return pressed and bool(np.linalg.norm(offset) < HOLD_OFFSET)

    def _tick(self) -> None:
        model, data = self.scene.mujoco, self.data
        steps = round(CONTROL_PERIOD / model.opt.timestep)
        due = round((len(self.times) / FRAME_RATE - data.time) / model.opt.timestep)
        if due <= steps:
            mujoco.mj_step(model, data, nstep=due)
            self._record()
            steps -= due
        mujoco.mj_step(model, data, nstep=steps)
        self._watch()

    def _record(self) -> None:
        self.times.append(float(self.data.time))
        self.frames.append(self.data.qpos.copy())
        self.glow.append(self.glowing)

    def _watch(self) -> None:
        """Note the greatest speeds and torques, whether the pads press, and every touch nobody asked for."""
        data = self.data
        speeds = np.abs(data.qvel[self._dofs]) / VELOCITY_LIMITS
        # The real arm's motors carry its weight too, which here `gravcomp` does beside the actuators.
        torques = np.abs(data.qfrc_actuator[self._dofs] + data.qfrc_gravcomp[self._dofs]) / self._torque_limits
        np.maximum(self.speed_share, speeds, out=self.speed_share)
        np.maximum(self.torque_share, torques, out=self.torque_share)
        geoms = data.contact.geom
        bodies = self.scene.mujoco.geom_bodyid[geoms]
        moving = self._moving[bodies]
        for i in np.flatnonzero(moving[:, 0] != moving[:, 1]):
            pad, other = (0, 1) if moving[i, 0] else (1, 0)
            if geoms[i, pad] in self._pads and bodies[i, other] == self._target:
                continue
            self._touch(int(bodies[i, pad]), int(bodies[i, other]))
        if self._target >= 0 and self._pads_press():
            self._pressed = data.time

    def _pads_press(self) -> bool:
        name = self.scene.mujoco.body(self._target).name
        return bool(pad_forces(self.scene, self.data, name).min() > HOLD_FORCE)

    def _touch(self, moving: int, other: int) -> None:
        pair = (self.scene.mujoco.body(moving).name, self.scene.mujoco.body(other).name)
        if self.data.time - self._touched.get(pair, -np.inf) > EPISODE:
            self.tell("contact", moving=pair[0], other=pair[1])
        self._touched[pair] = self.data.time


def _below(model: mujoco.MjModel, name: str) -> np.ndarray:
    """Return (nbody,) bool: the body of that name and all that hang from it."""
    root = model.body(name).id
    inside = np.zeros(model.nbody, dtype=bool)
    for body in range(model.nbody):
        inside[body] = body == root or (body > 0 and inside[model.body_parentid[body]])
    return inside
