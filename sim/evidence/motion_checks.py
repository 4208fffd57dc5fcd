"""Checks of the motions in a log: the times of its actions, and joint limits."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from prefplan.claims import Check
from sim.evidence.log import Log
from sim.evidence.replay import RecordedWorld
from sim.robots.robot import Robot
from sim.simulation.run import FRAME_RATE_HZ

ROUNDING_S = 1e-6
"""Greatest rounding error of a time, s."""


def check_recording(log: Log) -> Check:
    """Check that actions follow each other within the frames; that none of these is missing, the simulation shows."""
    end, before = float(log.times[-1]), 0.0
    for k, action in enumerate(log.about.actions, 1):
        if not before - ROUNDING_S <= action.start <= action.end:
            words = f"action {k} `{action.action}` begins before the one before it ends"
            return Check("recording", False, words)
        if action.end > end + 1.5 / FRAME_RATE_HZ:
            words = f"the frames end at {end:.2f} s, but action {k} `{action.action}` at {action.end:.2f} s"
            return Check("recording", False, words)
        before = action.end
    return Check("recording", True, f"{len(log.times)} frames, {end:.1f} s, {len(log.about.actions)} actions")


def check_limits(log: Log, world: RecordedWorld, loads: Mapping[str, np.ndarray]) -> list[Check]:
    """Check the arm's joint positions, and its loads when it was simulated again, against their limits.

    Speeds, accelerations, torques and torque rates are those of the simulated joints, contacts included; accelerations
    and torque rates are differences between two steps of the simulation, except where MuJoCo misses a contact
    (`sim.simulation.recorder.missed_contacts`). Jerks are those of the commanded trajectory, to which a manufacturer's
    limit applies: measured jerks show every contact. Loads are (T, n), by their names in `sim.simulation.run.Run`.
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
