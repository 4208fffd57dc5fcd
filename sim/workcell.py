"""The running simulation: it drives the actuators, records what happens and watches limits and contacts."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np

from sim.grounding import HOLD_FORCE, HOLD_OFFSET, ObjectPose, object_pose, pad_forces
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
        self._substeps = round(CONTROL_PERIOD / model.opt.timestep)
        self._torque_limits = model.actuator_forcerange[self._motors, 1]
        self._robot = _below(model, "link0")
        self._moving = self._robot
        self._target, self._aloft = -1, False
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

    def see(self, thing: str) -> ObjectPose:
        """Return where an object is, as far as the skills know."""
        return object_pose(self.scene, self.data, thing)

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

    @contextmanager
    def handling(self, thing: str, *, aloft: bool = False) -> Iterator[None]:
        """Allow the pads to touch an object, for the time of a `with` block.

        Args:
            thing: the object.
            aloft: it hangs in the air: it counts as part of the robot, which may touch nothing.
        """
        self._target = self.scene.mujoco.body(thing).id
        self._pressed = self.data.time if aloft else -np.inf
        self._aloft = aloft
        if aloft:
            self._moving = self._robot.copy()
            self._moving[self._target] = True
        try:
            yield
        finally:
            self._target, self._aloft, self._moving = -1, False, self._robot

    def holds(self, thing: str) -> bool:
        """Return whether both pads press an object, but for a flicker, and have it between them."""
        if self.scene.mujoco.body(thing).id == self._target:
            pressed = self.data.time - self._pressed < FLICKER
        else:
            pressed = bool(pad_forces(self.scene, self.data, thing).min() > HOLD_FORCE)
        offset = self.see(thing).position - self.data.site(TCP).xpos
        return pressed and bool(np.linalg.norm(offset) < HOLD_OFFSET)

    def foresee(self, q: np.ndarray, *, width: float | None = None) -> list[str]:
        """Return the names of the bodies that the robot, and what it carries aloft, would touch.

        The object being handled is left out.

        Args:
            q: (7,) rad, joint angles to judge.
            width: between the pads, m; None for the present one.
        """
        model, scratch = self.scene.mujoco, self._scratch
        scratch.qpos[:] = self.data.qpos
        scratch.qpos[self._qpos] = q
        if width is not None:
            scratch.qpos[self._fingers] = width / 2
        mujoco.mj_kinematics(model, scratch)
        if self._aloft:
            self._carry(scratch)
        mujoco.mj_collision(model, scratch)
        bodies = model.geom_bodyid[scratch.contact.geom]
        robot = self._moving[bodies]
        free = (robot[:, 0] != robot[:, 1]) & (self._aloft | (bodies != self._target).all(axis=1))
        return sorted({model.body(body).name for body in bodies[free][~robot[free]]})

    def _tick(self, commands: np.ndarray | None = None) -> None:
        """Simulate one control period; record the frames that fall into it.

        Args:
            commands: (substeps, 7) rad, of the arm's motors; None to leave them as they are.
        """
        model, data = self.scene.mujoco, self.data
        for substep in range(self._substeps):
            if commands is not None:
                data.ctrl[self._motors] = commands[substep]
            mujoco.mj_step(model, data)
            if data.time * FRAME_RATE >= len(self.times) - 1e-6:
                self._record()
        self._watch()

    def _carry(self, scratch: mujoco.MjData) -> None:
        """Move the handled object in `scratch` as the hand moves it."""
        model, data = self.scene.mujoco, self.data
        now, then = data.site(TCP), scratch.site(TCP)
        turn = then.xmat.reshape(3, 3) @ now.xmat.reshape(3, 3).T
        body, start = self._target, int(model.jnt_qposadr[model.body_jntadr[self._target]])
        scratch.qpos[start : start + 3] = then.xpos + turn @ (data.xpos[body] - now.xpos)
        mujoco.mju_mat2Quat(scratch.qpos[start + 3 : start + 7], (turn @ data.xmat[body].reshape(3, 3)).ravel())
        mujoco.mj_kinematics(model, scratch)

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


def _commands(start: np.ndarray, references: np.ndarray, substeps: int) -> np.ndarray:
    """Return what the motors are told at every step of the simulation to keep to joint references.

    References held for a whole control period would jerk the wrist with all its torque (kp times the distance
    covered); a smooth curve through them does not.

    Returns:
        (N * substeps, 7) rad.
    """
    points = np.vstack([start, references])
    slopes = np.gradient(points, axis=0)
    slopes[[0, -1]] = 0.0
    u = (np.arange(1, substeps + 1) / substeps)[:, None]
    p0, p1, m0, m1 = (x[:, None, :] for x in (points[:-1], points[1:], slopes[:-1], slopes[1:]))
    curve = p0 + u * m0 + u**2 * (3 * (p1 - p0) - 2 * m0 - m1) + u**3 * (m0 + m1 - 2 * (p1 - p0))
    slope = m0 + 2 * u * (3 * (p1 - p0) - 2 * m0 - m1) + 3 * u**2 * (m0 + m1 - 2 * (p1 - p0))
    return (curve + LAG / CONTROL_PERIOD * slope).reshape(-1, 7)


def _below(model: mujoco.MjModel, name: str) -> np.ndarray:
    """Return (nbody,) bool: the body of that name and all that hang from it."""
    root = model.body(name).id
    inside = np.zeros(model.nbody, dtype=bool)
    for body in range(model.nbody):
        inside[body] = body == root or (body > 0 and inside[model.body_parentid[body]])
    return inside
