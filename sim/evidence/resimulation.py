"""A logged run simulated again from the start that its seed gives, by its commands, and compared with the log.

Two simulations of the same commands are equal bit by bit if they have the same scene, the same version of MuJoCo and
the same kind of machine; then every recorded digit must be reproduced. Otherwise they would drift apart. So each frame
is simulated from the recorded one before it, and must agree within tolerances, alone and summed over the run.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np

from prefplan.claims import Check
from sim.evidence.log import DECIMALS, Log, versions
from sim.evidence.replay import RecordedWorld
from sim.evidence.touch_checks import Touches
from sim.geometry.mjcf import columns, joint_at
from sim.motion.trajectory import STEPS
from sim.simulation.recorder import COMMANDS_PER_UNIT, STATE, Recorder
from sim.simulation.run import FRAME_RATE_HZ

EXACT = {"times": 1e-6, "qpos": 0.6 * 10**-DECIMALS, "qvel": 0.6 * 10**-DECIMALS}
"""Arrays that are compared, and the greatest difference due to rounding."""

FRAME_TOLERANCE = 0.001
"""Greatest difference of a recorded position from the one simulated from the frame before it, m or rad."""

FRAME_TURN = 0.005
"""Greatest such difference of an entry of a quaternion: pies and jars that stand on their rims tremble."""

MAX_DRIFT = 5
"""Greatest sum of these differences from the start of a run to any frame, in multiples of the greatest single one: 5 mm
and 3 degrees. The sums of honest runs reach 0.007."""

IMPACT_M_S = 0.5
"""An object whose velocity changes by more than this in a frame, m/s, was hit: its weight does not do that."""

LEVER_M = 0.1
"""Lever at which the change of velocity beyond `IMPACT_M_S` turns a hit object, m."""

IMPACT_SHARE = 0.1
"""Share of a hit object's change of velocity by which its motion may differ: a bounce depends on unrecorded digits."""

SPIN_SHARE = 0.5
"""Share of a free object's change of angular velocity in a frame by which its rotation may differ."""

SPEED_TOLERANCE = 0.05
"""Greatest change of a velocity from outside that is ignored where frames are not reproduced exactly, m/s or rad/s."""

ENVIRONMENT = ("mujoco", "machine")
"""Two simulations with the same versions of these are equal bit by bit."""

FREELY_SET = int(mujoco.mjtState.mjSTATE_QPOS | mujoco.mjtState.mjSTATE_QVEL | mujoco.mjtState.mjSTATE_WARMSTART)
"""The part of the state that a fault may set; the rest, e.g. forces from outside, follows from the steps before."""


class Change(NamedTuple):
    """A joint whose position or velocity was set from outside before a step.

    Attributes:
        time: of the step, s.
        joint: its name.
        far: distance by which it moved, m or rad.
    """

    time: float
    joint: str
    far: float


@dataclass(frozen=True)
class Resimulation:
    """The comparison of a log with a simulation of its commands.

    Attributes:
        check: whether they agree.
        equal: whether every digit agrees, in an equal environment.
        changes: the changes from outside, in order of time.
        arrays: the recorder's arrays of the simulation, by their names in `sim.simulation.run.Run`.
    """

    check: Check
    equal: bool
    changes: list[Change]
    arrays: dict[str, np.ndarray]


def resimulate(log: Log, world: RecordedWorld, touches: Touches) -> Resimulation:
    """Compare a log with a simulation of its commands, as this module's docstring explains.

    Contacts are checked in every frame, and at the end of every control period.
    """
    here, there = versions(), log.about.versions
    other = [
        f"{part} {there.get(part)} then, {here[part]} now" for part in ENVIRONMENT if there.get(part) != here[part]
    ]
    arrays, changes, forced = _simulated(log, world, touches, frame_by_frame=bool(other))
    objection = _objection(log, world.mujoco, arrays, exact=not other) or forced
    words = f"{len(log.times)} frames, every digit equal"
    if other:
        words = (
            f"{len(log.times)} frames, each within {FRAME_TOLERANCE * 1000:g} mm of what follows from the one before, "
            f"and within {MAX_DRIFT * FRAME_TOLERANCE * 1000:g} mm in all ({'; '.join(other)}); "
            "smaller forgeries are not excluded"
        )
    check = Check("simulated again", objection is None, objection or words)
    return Resimulation(check, check.holds and not other, changes, arrays)


def _simulated(
    log: Log, world: RecordedWorld, touches: Touches, *, frame_by_frame: bool
) -> tuple[dict[str, np.ndarray], list[Change], str | None]:
    """Simulate the commands of a log; with `frame_by_frame`, every frame begins from the recorded one.

    Returns:
        The recorder's arrays of the frames, the changes from outside, and an objection if no fault makes one of them.
    """
    data, recorder = mujoco.MjData(world.mujoco), Recorder(world.scene)
    changes, forced = list[Change](), None
    # The start is a few digits off on another machine; later states are exact, or follow from a recorded frame.
    first = EXACT["qpos"], EXACT["qvel"]
    slack = (_slack(world.mujoco), SPEED_TOLERANCE) if frame_by_frame else (0.0, 0.0)
    interventions = {int(row[0]): row[1:] for row in log.interventions}
    controls = log.controls / COMMANDS_PER_UNIT
    data.qpos[:] = world.start
    recorder.begin_period(data, controls)
    recorder.record(data, glow=-1)
    touches.look(data, 0, recorded=True)
    frames = 1
    for step in range(len(controls)):
        if step in interventions:
            moved = _intervene(data, interventions[step], *(slack if step else first))
            if moved is None:
                forced = forced or f"a force or a time is set from outside at {data.time:.2f} s"
            changes += moved or ()
        data.ctrl[:] = controls[step]
        mujoco.mj_step(world.mujoco, data)
        if due := recorder.feel(data):
            recorder.record(data, glow=-1)
            if frame_by_frame and frames < len(log.times):
                data.qpos[:], data.qvel[:] = log.qpos[frames], log.qvel[frames]
            frames += 1
        if frames <= len(log.times) and (due or (step + 1) % STEPS == 0):
            touches.look(data, frames - 1, recorded=due)
    return {name: rows[: len(log.times)] for name, rows in recorder.arrays.items()}, changes, forced


def _intervene(
    data: mujoco.MjData, state: np.ndarray, qpos_slack: float | np.ndarray, qvel_slack: float
) -> list[Change] | None:
    """Set a state, and return the changes that exceed some slack; None if it sets what no fault may set."""
    model = data.model
    qpos, qvel, rest = data.qpos.copy(), data.qvel.copy(), _rest(data)
    mujoco.mj_setState(model, data, state, STATE)
    if not np.allclose(_rest(data), rest, rtol=0, atol=1e-9):
        return None
    off = data.qpos - qpos
    dofs = np.flatnonzero(np.abs(data.qvel - qvel) > qvel_slack)
    joints = {joint_at(model, place) for place in np.flatnonzero(np.abs(off) > qpos_slack).tolist()}
    joints |= {model.joint(int(model.dof_jntid[dof])).name for dof in dofs}
    far = {joint: float(np.linalg.norm(off[columns(model, joint)[0]][:3])) for joint in sorted(joints)}
    return [Change(float(data.time), joint, far[joint]) for joint in far]


def _rest(data: mujoco.MjData) -> np.ndarray:
    """Return the part of the state that no fault may set."""
    rest = np.empty(mujoco.mj_stateSize(data.model, STATE & ~FREELY_SET))
    mujoco.mj_getState(data.model, data, rest, STATE & ~FREELY_SET)
    return rest


def _objection(log: Log, model: mujoco.MjModel, found: Mapping[str, np.ndarray], *, exact: bool) -> str | None:
    """Return where a log first differs from what was simulated again, in a sentence, or None."""
    count = len(log.times)
    if len(found["times"]) < count:
        return f"the commands last {found['times'][-1]:.2f} s, the frames {log.times[-1]:.2f} s"
    off = {name: (getattr(log, name) - found[name]).reshape(count, -1) for name in EXACT}
    if exact:
        return _difference(log, model, off, EXACT)
    drift, slack = off["qpos"], _slack(model)
    drift = np.sign(drift) * (np.abs(drift) - _allowed_by_impacts(log, model)).clip(min=0.0)
    far = _difference(log, model, {"qpos": np.cumsum(drift, axis=0)}, {"qpos": MAX_DRIFT * slack})
    each = _difference(log, model, off | {"qpos": drift}, {"times": EXACT["times"], "qpos": slack})
    return each or (far and f"{far}, by many small differences")


def _difference(
    log: Log,
    model: mujoco.MjModel,
    off: Mapping[str, np.ndarray],
    tolerances: Mapping[str, float | np.ndarray],
) -> str | None:
    """Return where (T, ...) differences first exceed a tolerance, in words, or None."""
    firsts = list[tuple[int, str]]()
    for name, tolerance in tolerances.items():
        # Values that are not finite count as different.
        frames = np.flatnonzero(~(np.abs(off[name]) <= tolerance).all(axis=1))
        firsts += [(int(frame), name) for frame in frames[:1]]
    if not firsts:
        return None
    frame, name = min(firsts)
    differences = np.abs(off[name][frame])
    what = joint_at(model, int(differences.argmax())) if name == "qpos" else f"one of the {name}"
    when = f"first at {log.times[frame]:.2f} s"
    return f"{what} is {differences.max():.2g} (m, rad, s) from where the commands lead, {when}"


def _allowed_by_impacts(log: Log, model: mujoco.MjModel) -> np.ndarray:
    """Return (T, nq) differences that are allowed where an object was hit in a frame."""
    allowed = np.zeros_like(log.qpos)
    for joint in np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE):
        place, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        change = np.diff(log.qvel[:, dof : dof + 6], axis=0, prepend=0.0)
        hit = (np.linalg.norm(change[:, :3], axis=1) - IMPACT_M_S).clip(min=0.0)
        spin = hit / LEVER_M + np.linalg.norm(change[:, 3:], axis=1)
        allowed[:, place : place + 3] = IMPACT_SHARE * hit[:, None] / FRAME_RATE_HZ
        allowed[:, place + 3 : place + 7] = SPIN_SHARE * spin[:, None] / (2 * FRAME_RATE_HZ)
    return allowed


def _slack(model: mujoco.MjModel) -> np.ndarray:
    """Return (nq,) tolerances of the positions in a frame that is simulated from the one before it."""
    slack = np.full(model.nq, FRAME_TOLERANCE)
    for first in model.jnt_qposadr[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE]:
        slack[first + 3 : first + 7] = FRAME_TURN
    return slack
