"""Recording of a running simulation.

States frame by frame with the greatest loads between frames, and everything that is needed to simulate the run again
bit by bit: the commands of every step, and every state that was set by something other than a step of the simulation.
"""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from scipy.linalg import solve_banded

from sim.simulation.run import FRAME_RATE_HZ, Effort
from sim.world.scene import Scene

COMMANDS_PER_UNIT = 2**24
"""Resolution of the commands sent to the actuators, a power of two: 6e-8 rad or m, as integers in the log."""

STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION) & ~int(mujoco.mjtState.mjSTATE_CTRL)
"""The state on which a step of MuJoCo depends besides the commands."""

MISSED_STEPS = 2
"""Greatest number of steps for which MuJoCo misses a contact of a pad, mostly with a cylinder."""

RECOVERY_STEPS = 3
"""Number of steps that the arm needs to recover from a missed contact."""

TORQUE_CUTOFF_HZ = 100.0
"""Cutoff of the first-order low-pass filter of commanded torques, libfranka's default (`lowpass_filter.h`). Without it
a contact that the simulation misses for a single step counts as a jump of the torque."""


class Recorder:
    """Records frames of a simulation, `FRAME_RATE_HZ` per second; loads are sampled at every step between them.

    Accelerations and rates are differences between two steps. MuJoCo's own accelerations are not used: the implicit
    integrator overstates them.

    Attributes:
        frames: what was recorded so far, each frame by the names in `Run`.
    """

    def __init__(self, scene: Scene) -> None:
        """Begin without frames."""
        self._model = model = scene.mujoco
        self._dofs, self._period = scene.robot.dofs(model), float(model.opt.timestep)
        motor = model.actuator(scene.robot.gripper.actuator).id
        self._cup = motor if model.actuator_trntype[motor] == mujoco.mjtTrn.mjTRN_BODY else None
        self._pads = {model.geom(name).id: i for i, name in enumerate(scene.robot.gripper.pads)}
        self.frames: list[dict[str, Any]] = []
        self._felt: list[int] = []
        # Loads of all joints at every step.
        self._speeds, self._torques = list[np.ndarray](), list[np.ndarray]()
        self._touching = list[int]()  # number of pads that touch something, at every step
        self._constraints = -1
        self._motors = [model.actuator(name).id for name in scene.robot.joints]
        self._steps, self._controls = 0, [np.zeros((0, model.nu))]
        self._interventions: list[np.ndarray] = []
        self._left, self._found = np.full((2, mujoco.mj_stateSize(model, STATE)), np.nan)
        self._due, self._effort, self._summed = 0.0, Effort(), 0

    def begin_period(self, data: mujoco.MjData, controls: np.ndarray) -> np.ndarray:
        """Record the commands of a control period, and the state if it differs from the end of the last period.

        Returns the (steps, nu) commands to send, rounded to their resolution.
        """
        mujoco.mj_getState(self._model, data, self._found, STATE)
        if self._found.tobytes() != self._left.tobytes():
            self._interventions.append(np.array([self._steps, *self._found]))
        rounded = np.rint(controls * COMMANDS_PER_UNIT)
        self._controls.append(rounded)
        self._steps += len(rounded)
        return rounded / COMMANDS_PER_UNIT

    def end_period(self, data: mujoco.MjData) -> None:
        """Record the state in which a control period ends."""
        mujoco.mj_getState(self._model, data, self._left, STATE)

    def feel(self, data: mujoco.MjData) -> bool:
        """Record the loads of a step that was just simulated; return whether a frame is due."""
        torques = data.qfrc_actuator.copy()
        if self._cup is not None:
            torques -= self._pull(data, self._cup)
        self._speeds.append(data.qvel.copy())
        self._torques.append(torques)
        self._touching.append(self._pads_touching(data))
        return bool(data.time >= self._due)

    def _pads_touching(self, data: mujoco.MjData) -> int:
        """Return how many pads touch something; count them again only if the number of constraints has changed."""
        if data.nefc == self._constraints:
            return self._touching[-1]
        self._constraints = data.nefc
        return len(self._pads.keys() & set(data.contact.geom.ravel().tolist()))

    def _pull(self, data: mujoco.MjData, cup: int) -> np.ndarray:
        """Return the (nv,) torques of a suction cup: MuJoCo counts them, although the cup's contact balances them."""
        pull = np.zeros(self._model.nv)
        first = data.moment_rowadr[cup]
        row = slice(first, first + data.moment_rownnz[cup])
        pull[data.moment_colind[row]] = data.actuator_moment[row] * data.actuator_force[cup]
        return pull

    def record(self, data: mujoco.MjData, *, glow: int) -> None:
        """Add a frame; `glow` is the index of the location that marks an object now, -1 for none."""
        frame = {
            "times": float(data.time),
            "qpos": data.qpos.copy(),
            "qvel": data.qvel.copy(),
            "glow": glow,
            "pad_forces": self._press(data),
        }
        self.frames.append(frame)
        self._felt.append(len(self._speeds))
        self._due = (len(self.frames) - 1e-6) / FRAME_RATE_HZ

    @property
    def effort(self) -> Effort:
        """Effort of the arm so far."""
        speeds, torques = (self._of_arm(rows[self._summed :]) for rows in (self._speeds, self._torques))
        travel, energy = (self._period * float(np.abs(rates).sum()) for rates in (speeds, speeds * torques))
        self._effort += Effort(self._period * len(speeds), travel, energy)
        self._summed += len(speeds)
        return self._effort

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """The recorded arrays by their names in `Run`; the last frame has the loads up to now as well."""
        arrays = {name: np.array([frame[name] for frame in self.frames]) for name in self.frames[0]}
        missed = missed_contacts(np.array(self._touching), len(self._pads))
        speeds, torques = (bridged(self._of_arm(rows), missed) for rows in (self._speeds, self._torques))
        controls = np.vstack(self._controls)
        samples = {
            "speeds": (speeds, 0),
            "accelerations": (speeds, 1),
            "jerks": (self._references(controls[:, self._motors] / COMMANDS_PER_UNIT), 3),
            "torques": (torques, 0),
            "torque_rates": (self._filtered(torques), 1),
        }
        arrays |= {name: self._greatest(rows, rate) for name, (rows, rate) in samples.items()}
        arrays["controls"] = controls.astype(np.int64)
        arrays["interventions"] = np.array(self._interventions).reshape(-1, 1 + len(self._left))
        return arrays

    def _of_arm(self, rows: Sequence[np.ndarray]) -> np.ndarray:
        """Return the (K, n) values of the arm's joints from those of all joints, at K steps."""
        return np.array(rows).reshape(len(rows), self._model.nv)[:, self._dofs]

    def _references(self, commands: np.ndarray) -> np.ndarray:
        """Return the (S, n) references from which the commands of the arm's joints were computed, rad or m.

        A command is the reference r plus the actuator's lag times its rate; the trapezoidal rule gives r.
        """
        stiffness, damping = -self._model.actuator_biasprm[self._motors, 1:3].T
        offsets = commands - commands[:1]
        driven = offsets + np.vstack([np.zeros_like(offsets[:1]), offsets[:-1]])
        references = commands.copy()
        for joint, share in enumerate(self._period * stiffness / (2 * damping)):
            references[:, joint] += _recursive(1 + share, share - 1, share * driven[:, joint]) - offsets[:, joint]
        return references

    def _filtered(self, torques: np.ndarray) -> np.ndarray:
        """Return (K, n) torques, N m, after the low-pass filter of the arm's controller."""
        gain = self._period / (self._period + 1 / (2 * np.pi * TORQUE_CUTOFF_HZ))
        return _recursive(1.0, gain - 1, gain * (torques - torques[:1])) + torques[:1]

    def _greatest(self, rows: np.ndarray, rate: int) -> np.ndarray:
        """Return the (T, n) greatest absolute rate-th derivatives of the samples since the frame before."""
        greatest = np.zeros((len(self.frames), len(self._dofs)))
        if len(rows):
            # Before the first step all values are constant.
            rows = np.vstack([np.repeat(rows[:1], rate, axis=0), rows])
            loads = np.abs(np.diff(rows, rate, axis=0)) / self._period**rate
            greatest[1:] = np.maximum.reduceat(loads, self._felt[:-1])
        return greatest

    def _press(self, data: mujoco.MjData) -> np.ndarray:
        """Return the contact force on each of the gripper's pads, N."""
        pairs, forces = data.contact.geom, np.zeros(len(self._pads))
        for pad, i in self._pads.items():
            # The first row of an elliptic cone is the normal force.
            forces[i] = data.efc_force[data.contact.efc_address[(pairs == pad).any(axis=1)]].sum()
        return forces


def _recursive(now: float, before: float, driven: np.ndarray) -> np.ndarray:
    """Return y with `now` y[k] + `before` y[k - 1] = driven[k] and y[-1] = 0.

    `scipy.signal` can do this, but takes half a second to import.
    """
    if not len(driven):
        return driven
    return np.asarray(solve_banded((1, 0), np.tile([[now], [before]], len(driven)), driven, check_finite=False))


def missed_contacts(touching: np.ndarray, pads: int) -> np.ndarray:
    """Return (K,) bool, which steps are affected by contacts of a pad that MuJoCo misses.

    A contact that one of several pads loses and finds again within `MISSED_STEPS` was missed. `touching` has the (K,)
    numbers of pads that touch something in each step; `pads` is the number of pads.
    """
    missed = np.zeros(len(touching), dtype=bool)
    for steps in range(1, MISSED_STEPS + 1):
        after = touching[steps + 1 :]
        before, *within = (touching[k : k + len(after)] for k in range(steps + 1))
        lost = ((0 < np.array(within)) & (np.array(within) < pads)).all(axis=0)
        for first in np.flatnonzero((before == pads) & lost & (after == pads)) + 1:
            missed[first : first + steps + RECOVERY_STEPS] = True
    return missed


def bridged(rows: np.ndarray, missed: np.ndarray) -> np.ndarray:
    """Return (K, n) loads, linearly interpolated over the steps that a missed contact affects; `missed` is (K,)."""
    if not missed.any():
        return rows
    steps, kept = np.arange(len(rows)), ~missed
    return np.stack([np.interp(steps, steps[kept], column[kept]) for column in rows.T], axis=1)
