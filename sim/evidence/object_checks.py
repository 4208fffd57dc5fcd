"""Checks of the motions of objects in a log against physics: where they start, how they move, what holds them up."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from prefplan.claims import Check
from prefplan.logic.good_prefix import Label
from prefplan.models.manipulation.action import at
from sim.evidence.dynamics import Dynamics
from sim.evidence.log import Log
from sim.evidence.replay import RecordedWorld
from sim.geometry.mjcf import columns, joint_at
from sim.simulation.run import FRAME_RATE_HZ

START_TOLERANCE = 1e-5
"""Greatest difference of a first position from the one that the seed gives, m or rad."""

LEAP_TOLERANCE = 0.015
"""Greatest distance that an object or a joint covers between two states beyond what its velocities allow, m or rad;
an impact between two frames hides 0.005."""

FALL_TOLERANCE_M_S = 0.05
"""Greatest difference of a velocity from free fall, between states in which nothing is near an object."""

ENERGY_TOLERANCE_J = 0.005
"""Greatest energy that objects may gain while the robot touches none; contacts return up to 0.0007. A block that is
lifted by 10 mm, or moves at 0.4 m/s, has gained more."""

REST_SPEED_M_S = 0.01
"""Greatest mean speed of an object at the end of a run that is claimed to be completed."""

REST_PERIOD_FRAMES = round(0.2 * FRAME_RATE_HZ)
"""Number of frames over which that mean is taken."""

MAX_DEPTH_M = 0.002
"""Greatest depth of an object in furniture or in another object for `REST_PERIOD_FRAMES`; an impact is briefer."""

ENERGY_MEMORY_STATES = 12
"""Number of states after which contacts have returned the energy that they stored."""


def check_start(log: Log, world: RecordedWorld, label: Label) -> Check:
    """Check that the first positions are those of the seed and that, by the `label`, every object is at its start."""
    off = np.abs(world.qpos[0] - world.start)
    if off.max() > START_TOLERANCE:
        joint, seed = joint_at(world.mujoco, int(off.argmax())), log.about.setting.get("seed")
        return Check("start", False, f"{joint} is {off.max():.4f} m or rad from where seed {seed} puts it")
    wrong = [obj for obj in world.model.objects if at(obj.name, obj.start) not in label]
    if wrong:
        return Check("start", False, f"{wrong[0].name} does not start at {wrong[0].start}")
    return Check("start", True, "every object is where the scenario says")


def check_rest(log: Log, world: RecordedWorld) -> Check:
    """Check that nothing on the table moves at the end, if the run is claimed to be completed."""
    name = "rest"
    if not log.about.claims.completed:
        return Check(name, True, "not claimed: the run was not completed")
    first = max(0, len(log.times) - 1 - REST_PERIOD_FRAMES)
    seconds = max(float(log.times[-1] - log.times[first]), 1 / FRAME_RATE_HZ)
    for obj in world.objects:
        path = world.path(obj)[first:]
        speed = float(np.linalg.norm(path[-1] - path[0])) / seconds
        if path[-1, 2] > 0 and speed > REST_SPEED_M_S:
            return Check(name, False, f"{obj} still moves, at {speed:.3f} m/s, when the log ends")
    return Check(name, True, f"nothing moved faster than {REST_SPEED_M_S} m/s in the last {seconds:.1f} s")


def check_depth(dynamics: Dynamics) -> Check:
    """Check that no object sinks into furniture or into another object."""
    name = "penetration"
    for obj, depth in dynamics.depth.items():
        lasting = sliding_window_view(depth, min(REST_PERIOD_FRAMES, len(depth))).min(axis=1)
        deepest = int(lasting.argmax())
        if lasting[deepest] > MAX_DEPTH_M:
            deep = f"{1000 * lasting[deepest]:.1f} mm deep in what it touches"
            return Check(name, False, f"{obj} is {deep} at {dynamics.times[deepest]:.2f} s")
    return Check(name, True, f"no object is deeper than {1000 * MAX_DEPTH_M:g} mm in another one or in furniture")


def check_motions(world: RecordedWorld, dynamics: Dynamics) -> Check:
    """Check that positions follow from velocities, and velocities from contacts and gravity, faults aside."""
    objections = (_leap(world, dynamics), _float(dynamics, world), _push(world, dynamics))
    objection = next((words for words in objections if words), None)
    if objection:
        return Check("objects", False, objection)
    return Check("objects", True, "their motions follow from the hand, gravity and the recorded faults")


def _leap(world: RecordedWorld, dynamics: Dynamics) -> str | None:
    """Return which object or joint moves farther than its velocities allow, in a sentence, or None."""
    model, robot = world.mujoco, world.robot
    span = np.diff(dynamics.times)[:, None]
    for name in (*dynamics.objects, *robot.joints, *robot.gripper.joints):
        pose, rates = columns(model, name)
        moved, speeds = np.diff(dynamics.qpos[:, pose][:, :3], axis=0), dynamics.qvel[:, rates][:, :3]
        least, most = np.minimum(speeds[:-1], speeds[1:]) * span, np.maximum(speeds[:-1], speeds[1:]) * span
        off = np.maximum(np.maximum(least - moved, moved - most), 0).max(axis=1)
        for k in np.flatnonzero(off > LEAP_TOLERANCE):
            time = float(dynamics.times[k + 1])
            if dynamics.frame[k + 1] >= 0 or name not in world.excused(time):
                far, unit = float(np.linalg.norm(moved[k])), "m" if name in dynamics.objects else "rad"
                said = float(np.linalg.norm(speeds[k : k + 2].mean(axis=0) * span[k]))
                return f"{name} moves by {far:.3f} {unit} at {time:.2f} s, its velocity by {said:.3f}"
    return None


def _float(dynamics: Dynamics, world: RecordedWorld) -> str | None:
    """Return which object does not fall freely while nothing touches it, in a sentence, or None."""
    span = np.diff(dynamics.times)
    for obj in dynamics.objects:
        gained = np.diff(dynamics.centre(obj)[1], axis=0) - span[:, None] * world.mujoco.opt.gravity
        alone = ~dynamics.supported[obj]
        # An object may have bounced just before or after a state, so the states around must be free, too.
        free = alone[:-3] & alone[1:-2] & alone[2:-1] & alone[3:]
        still = np.all(np.stack([dynamics.frame[k : len(alone) - 3 + k] >= 0 for k in range(4)]), axis=0)
        off = np.abs(gained[1:-1]).max(axis=1) * (free & still)
        for k in np.flatnonzero(off > FALL_TOLERANCE_M_S) + 1:
            if next(dynamics.may_meet(obj, int(k)), None) is None:
                return f"nothing touches {obj} at {dynamics.times[k]:.2f} s, but it does not fall freely"
    return None


def _push(world: RecordedWorld, dynamics: Dynamics) -> str | None:
    """Return when objects gain energy from neither the robot nor a fault, in a sentence, or None."""
    driven = np.any([*dynamics.touched.values()], axis=0) | (dynamics.frame < 0)
    since = 0
    for k in range(1, len(driven)):
        if driven[k] or driven[k - 1]:
            since = k
            continue
        stored = dynamics.energy[max(since, k - ENERGY_MEMORY_STATES) : k].max()
        if dynamics.energy[k] - stored > ENERGY_TOLERANCE_J:
            # Between two states, the hand may push an object that it has just released.
            if any(world.robot.name in dynamics.may_meet(obj, k - 1) for obj in dynamics.objects):
                since = k
                continue
            gain = 1000 * (dynamics.energy[k] - stored)
            return f"an object gains {gain:.0f} mJ by itself at {dynamics.times[k]:.2f} s: nothing pushes it"
    return None
