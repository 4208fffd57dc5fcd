"""A logged run simulated again from its first state and its commands, and compared with what was recorded."""

from __future__ import annotations

import mujoco
import numpy as np

from prefplan.claims import Check
from sim.evidence.log import DECIMALS, RATE_DECIMALS, Log, versions
from sim.evidence.replay import RecordedWorld
from sim.geometry.mjcf import columns, joint_at
from sim.simulation.recorder import COMMANDS_PER_UNIT, STATE, Recorder

NAME = "simulated again"

COMPARED = dict.fromkeys(("times", "qpos", "qvel", "speeds", "torques", "pad_forces"), 0.6 * 10**-DECIMALS)
COMPARED |= dict.fromkeys(("accelerations", "torque_rates"), 0.6 * 10**-RATE_DECIMALS)
"""Arrays that a simulation produces, and the greatest difference due to rounding."""

FRAME_TOLERANCE = 0.001
"""Greatest difference of a recorded position from the one simulated from the frame before it, m or rad."""

EXACT = ("mujoco", "machine")
"""Two simulations with the same versions of these are equal bit by bit."""


def resimulate(log: Log, world: RecordedWorld) -> Check:
    """Check a log against a simulation of its commands, from its start and from each of its interventions.

    With the log's version of MuJoCo on its kind of machine, every recorded digit must be reproduced. Otherwise two
    simulations would drift apart, so each frame is simulated from the one before it, and its positions must agree
    within `FRAME_TOLERANCE`.
    """
    objection = _objection(log, world)
    if objection:
        return Check(NAME, False, objection)
    here, there = versions(), log.about.versions
    other = [f"{part} {there.get(part)} then, {here[part]} now" for part in EXACT if there.get(part) != here[part]]
    if world.scene.dressed != log.about.meshes:
        other.append("other shapes of the arm")
    found, intruder = _simulate(log, world, frame_by_frame=bool(other))
    tolerances = {"qpos": FRAME_TOLERANCE} if other else COMPARED
    if len(found["times"]) < len(log.times):
        return Check(NAME, False, f"the commands last {found['times'][-1]:.2f} s, the frames {log.times[-1]:.2f} s")
    # The first frame is the start, and a fault may act before the first step.
    for frame in range(1, len(log.times)):
        for name, tolerance in tolerances.items():
            off = np.abs(np.atleast_1d(found[name][frame] - getattr(log, name)[frame]))
            if off.max() > tolerance:
                words = _difference(log, world, frame, name, off)
                changed = log.about.model_sha256 != world.scene.sha256
                return Check(NAME, False, words + (", in another compiled model than the log's" if changed else ""))
    if intruder:
        return Check(NAME, False, intruder)
    if other:
        words = f"each within {FRAME_TOLERANCE * 1000:g} mm of what follows from the one before ({'; '.join(other)})"
    else:
        words = "every digit equal"
    return Check(NAME, True, f"{len(log.times)} frames, {words}")


def _objection(log: Log, world: RecordedWorld) -> str | None:
    """Return why the commands of a log cannot be simulated, or None."""
    model, about = world.mujoco, log.about
    joints = {model.joint(i).name: int(model.joint(i).qposadr[0]) for i in range(model.njnt)}
    if about.joints != joints or log.qpos.shape[1] != model.nq or log.qvel.shape[1] != model.nv:
        return "its joints are not those of its scenario"
    if log.controls.shape[1] != model.nu:
        return f"{log.controls.shape[1]} commands a step, but the scene has {model.nu} actuators"
    rows = log.interventions
    if rows.shape[1] != 1 + mujoco.mj_stateSize(model, STATE):
        return "the states of its interventions are not those of its scenario"
    if not len(rows) or rows[0, 0] != 0 or np.any(np.diff(rows[:, 0]) <= 0):
        return "it does not say in which state the first step begins"
    return None


def _simulate(log: Log, world: RecordedWorld, *, frame_by_frame: bool) -> tuple[dict[str, np.ndarray], str | None]:
    """Return the recorded arrays of a simulation of the logged commands, and the first unexplained intervention.

    Args:
        log: of the run.
        world: rebuilt from it.
        frame_by_frame: begin every frame from the recorded one before it.
    """
    model, data, recorder = world.mujoco, mujoco.MjData(world.mujoco), Recorder(world.scene)
    interventions = {int(row[0]): row[1:] for row in log.interventions}
    controls = log.controls / COMMANDS_PER_UNIT
    recorder.record(data, glow=-1)
    intruder, frames = None, 1
    for step in range(len(controls)):
        if step in interventions:
            before = data.qpos.copy(), data.qvel.copy()
            mujoco.mj_setState(model, data, interventions[step], STATE)
            if step and not frame_by_frame:
                intruder = intruder or _intruder(world, data, before)
        data.ctrl[:] = controls[step]
        mujoco.mj_step(model, data)
        if recorder.feel(data):
            recorder.record(data, glow=-1)
            if frame_by_frame and frames < len(log.times):
                data.qpos[:], data.qvel[:] = log.qpos[frames], log.qvel[frames]
            frames += 1
    return recorder.arrays, intruder


def _intruder(world: RecordedWorld, data: mujoco.MjData, before: tuple[np.ndarray, np.ndarray]) -> str | None:
    """Return what an intervention changed that no recorded fault explains, in a sentence, or None."""
    model = world.mujoco
    dofs = np.flatnonzero(data.qvel != before[1])
    places = np.flatnonzero(data.qpos != before[0])
    moved = {model.joint(int(model.dof_jntid[dof])).name for dof in dofs}
    moved |= {joint_at(model, place) for place in places.tolist()}
    wrong = sorted(moved - world.excused(data.time))
    return f"{wrong[0]} was moved from outside at {data.time:.2f} s, and no recorded fault says so" if wrong else None


def _difference(log: Log, world: RecordedWorld, frame: int, name: str, off: np.ndarray) -> str:
    """Return where a frame differs from the simulation, in words."""
    model, time, worst = world.mujoco, float(log.times[frame]), int(off.argmax())
    if name == "qpos":
        joint = joint_at(model, worst)
        first, free = columns(model, joint)[0].start, model.joint(joint).type[0] == mujoco.mjtJoint.mjJNT_FREE
        far = 1000 * float(np.linalg.norm(off[first : first + 3]))
        where = f"{far:.4f} mm" if free and worst < first + 3 else f"{off.max():.2g} rad"
        return f"{joint} is {where} from where the commands lead, first at {time:.2f} s"
    whose = {"qvel": "velocities"}.get(name, name.replace("_", " "))
    return f"the {whose} differ by {off.max():.2g} from those that the commands lead to, first at {time:.2f} s"
