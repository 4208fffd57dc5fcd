"""Checks of the motions in a log: gaps of the recording, and joint limits."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from prefplan.claims import Check
from sim.evidence.log import Log
from sim.evidence.replay import RecordedWorld
from sim.robots.robot import Robot
from sim.simulation.run import FRAME_RATE_HZ

ROUNDING = 1e-6
"""Slack for comparisons of recorded numbers."""


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


def check_limits(log: Log, world: RecordedWorld, loads: Mapping[str, np.ndarray]) -> list[Check]:
    """Check the arm's joint positions, and its loads when it was simulated again, against their limits.

    Speeds, accelerations, torques and torque rates are those of the simulated joints, contacts included; accelerations
    and torque rates are differences between two steps of the simulation. Jerks are those of the commanded trajectory,
    to which a manufacturer's limit applies: measured jerks show every contact.

    Args:
        log: of the run.
        world: rebuilt from it.
        loads: (frames, n) by their names in `sim.simulation.run.Run`.
    """
    robot = world.robot
    low, high = robot.ranges(world.mujoco).T
    middle, half = (low + high) / 2, (high - low) / 2
    checks = [_within("joint positions", np.abs(log.qpos[:, robot.qpos(world.mujoco)] - middle) / half, log, robot)]
    for load, limits in robot.load_limits.items():
        checks.append(_within(f"joint {load.replace('_', ' ')}", loads[load] / limits, log, robot))
    return checks


def _within(name: str, shares: np.ndarray, log: Log, robot: Robot) -> Check:
    """Return whether shares of a limit, (T, n), stay below 1."""
    frame, joint = np.unravel_index(int(shares.argmax()), shares.shape)
    most = f"{shares[frame, joint]:.1%} of the limit, {robot.joints[joint]} at {log.times[frame]:.2f} s"
    if shares.max() <= 1:
        return Check(name, True, f"at most {most}")
    return log.about.claims.against(name, f"exceeded: {most}")
