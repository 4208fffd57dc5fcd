"""Checks of the motions in a log: gaps of the recording, and joint limits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import solve_banded

from prefplan.claims import Check
from sim.evidence.log import Log
from sim.evidence.replay import RecordedWorld
from sim.robots.robot import Robot
from sim.simulation.recorder import COMMANDS_PER_UNIT
from sim.simulation.run import FRAME_RATE_HZ

ROUNDING = 1e-6
"""Slack for comparisons of recorded numbers."""

JERK_TOLERANCE = 0.01
"""Greatest share of its limit by which a derived jerk may exceed the recorded one; in genuine logs it never does."""


def check_recording(log: Log) -> Check:
    """Check that frames follow each other without a gap, and actions within them."""
    name, times = "recording", log.times
    period = np.diff(times)
    gaps = np.flatnonzero((period <= 0) | (period > 1.5 / FRAME_RATE_HZ))
    if abs(times[0]) > ROUNDING or len(gaps):
        where = float(times[gaps[0]]) if len(gaps) else 0.0
        return Check(name, False, f"frames are missing or out of order after {where:.2f} s")
    end = float(times[-1])
    before = 0.0
    for k, action in enumerate(log.about.actions, 1):
        if not before - ROUNDING <= action.start <= action.end:
            return Check(name, False, f"action {k} `{action.action}` begins before the one before it ends")
        if action.end > end + 1.5 / FRAME_RATE_HZ:
            return Check(
                name,
                False,
                f"the frames end at {end:.2f} s, but action {k} `{action.action}` at {action.end:.2f} s",
            )
        before = action.end
    return Check(name, True, f"{len(times)} frames, {end:.1f} s, {len(log.about.actions)} actions")


def check_limits(log: Log, world: RecordedWorld) -> list[Check]:
    """Check the arm's joint positions and loads against their limits.

    Speeds, accelerations, torques and torque rates are those of the simulated joints, contacts included; accelerations
    and torque rates are differences between two steps of the simulation. Jerks are those of the commanded trajectory,
    to which a manufacturer's limit applies: measured jerks show every contact.
    """
    angles, robot = world.arm(), world.robot
    low, high = robot.ranges(world.mujoco).T
    middle, half = (low + high) / 2, (high - low) / 2
    checks = [_within("joint positions", np.abs(angles - middle) / half, log, robot)]
    hidden = dict(_hidden(log, angles, robot)) | dict(_hidden_jerks(log, world))
    for load, limits in robot.load_limits.items():
        name = f"joint {load.replace('_', ' ')}"
        if load in hidden:
            checks.append(Check(name, False, hidden[load]))
        else:
            checks.append(_within(name, getattr(log, load) / limits, log, robot))
    return checks


def _hidden(log: Log, angles: np.ndarray, robot: Robot) -> Iterator[tuple[str, str]]:
    """Yield each load whose recorded maximum is below its mean by the (T, n) angles, rad, with an explanation."""
    period = np.diff(log.times)[:, None]
    mean_speeds = np.diff(angles, axis=0) / period
    mean_accelerations = 2 * np.diff(mean_speeds, axis=0) / (period[1:] + period[:-1])
    most = np.maximum(log.accelerations[2:], log.accelerations[1:-1])
    for load, unit, mean, greatest, slack in (
        ("speeds", "rad/s", mean_speeds, log.speeds[1:], 1e-3),
        ("accelerations", "rad/s^2", mean_accelerations, most, 1e-2),
    ):
        beyond = np.argwhere(np.abs(mean) > greatest + slack)
        if len(beyond):
            frame, joint = beyond[0]
            yield (
                load,
                f"{robot.joints[joint]} has a mean of {abs(mean[frame, joint]):.2f} {unit} at "
                f"{log.times[frame]:.2f} s, but at most {greatest[frame, joint]:.2f} {unit} are recorded",
            )


def _hidden_jerks(log: Log, world: RecordedWorld) -> Iterator[tuple[str, str]]:
    """Yield the jerks if the recorded ones are below those of the commanded trajectory, with an explanation.

    A command is the reference r plus the actuator's lag times its rate: u = r + lag r'. The trapezoidal rule gives r,
    and its third difference the jerk.
    """
    robot, model = world.robot, world.mujoco
    motors = [model.actuator(name).id for name in robot.joints]
    if log.controls.shape[1] != model.nu or len(log.controls) < 2 or len(log.times) < 2:
        return
    period = float(model.opt.timestep)
    lags = model.actuator_biasprm[motors, 2] / model.actuator_biasprm[motors, 1]
    commands = log.controls[:, motors] / COMMANDS_PER_UNIT
    first = commands[0]
    references = np.empty_like(commands)
    for joint, share in enumerate(period / (2 * lags)):
        offsets = commands[:, joint] - first[joint]
        # (1 + share) y[k] + (share - 1) y[k - 1] = share (x[k] + x[k - 1])
        diagonals = np.tile([[1 + share], [share - 1]], len(offsets))
        driven = share * (offsets + np.append(0.0, offsets[:-1]))
        references[:, joint] = first[joint] + solve_banded((1, 0), diagonals, driven, check_finite=False)
    jerks = np.abs(np.diff(np.vstack([[first] * 3, references]), 3, axis=0)) / period**3
    # A command is logged when the actuator gets it, later than its reference by the latency.
    late = round(world.scene.latency / period)
    frames = np.searchsorted(np.rint(log.times / period), np.arange(len(jerks)) - late, side="right")
    during = frames < len(log.times)
    derived = np.zeros_like(log.jerks)
    np.maximum.at(derived, frames[during], jerks[during])
    beyond = np.argwhere(derived > log.jerks + JERK_TOLERANCE * robot.load_limits["jerks"])
    if len(beyond):
        frame, joint = beyond[0]
        yield (
            "jerks",
            f"{robot.joints[joint]} is commanded with {derived[frame, joint]:.0f} rad/s^3 at {log.times[frame]:.2f} s, "
            f"but at most {log.jerks[frame, joint]:.0f} rad/s^3 are recorded",
        )


def _within(name: str, shares: np.ndarray, log: Log, robot: Robot) -> Check:
    """Return whether shares of a limit, (T, n), stay below 1."""
    frame, joint = np.unravel_index(int(shares.argmax()), shares.shape)
    most = f"{shares[frame, joint]:.1%} of the limit, {robot.joints[joint]} at {log.times[frame]:.2f} s"
    if shares.max() <= 1:
        return Check(name, True, f"at most {most}")
    return log.about.claims.against(name, f"exceeded: {most}")
