"""Checks of the motions in a log, which must end at rest and keep the joint limits, and of its events."""

from collections.abc import Mapping

import numpy as np

from prefplan.claims import Check
from sim.evidence.log import EVENTS, Log
from sim.evidence.replay import RecordedWorld
from sim.robots.robot import Robot
from sim.simulation.run import FRAME_RATE_HZ

REST_SPEED_M_S = 0.01
"""Greatest mean speed of an object at the end of a run that is claimed to be completed, m/s."""

REST_PERIOD_FRAMES = round(0.2 * FRAME_RATE_HZ)
"""Number of frames over which the mean speed at the end is taken."""

LAST_EVENT_S = 1.0
"""An event is recorded at most this long after the last frame."""


def check_rest(log: Log, world: RecordedWorld) -> Check:
    """Check that nothing on the table moves at the end, if the run is claimed to be completed."""
    if not log.about.claims.completed:
        return Check("rest", True, "not claimed: the run was not completed")
    first = max(0, len(log.times) - 1 - REST_PERIOD_FRAMES)
    seconds = max(float(log.times[-1] - log.times[first]), 1 / FRAME_RATE_HZ)
    for obj in world.objects:
        begin, end = world.path(obj)[[first, -1]]
        speed = float(np.linalg.norm(end - begin)) / seconds
        if end[2] > 0 and speed > REST_SPEED_M_S:
            return Check("rest", False, f"{obj} still moves, at {speed:.3f} m/s, when the log ends")
    return Check("rest", True, f"nothing moved faster than {REST_SPEED_M_S} m/s in the last {seconds:.1f} s")


def check_events(log: Log) -> Check:
    """Check that events are of the kinds in `EVENTS`, in order of time, and within the run."""
    before = 0.0
    for event in log.about.events:
        if not before <= event.time <= log.times[-1] + LAST_EVENT_S:
            return Check("events", False, f"`{event.kind}` at {event.time:.2f} s is out of order, or has no frames")
        if event.kind not in EVENTS:
            return Check("events", False, f"`{event.kind}` at {event.time:.2f} s is nothing that a log tells")
        before = event.time
    return Check("events", True, f"{len(log.about.events)}, in order")


def check_limits(log: Log, world: RecordedWorld, loads: Mapping[str, np.ndarray]) -> list[Check]:
    """Check the arm's recorded joint positions, and its loads when simulated again, against their limits.

    Speeds, accelerations, torques and torque rates are those of the simulated joints, contacts included; accelerations
    and torque rates are differences between two steps of the simulation, except where MuJoCo misses a contact
    (`sim.simulation.recorder.missed_contacts`). Jerks are those of the commanded trajectory, to which a manufacturer's
    limit applies: measured jerks show every contact. Loads are (T, n), by their names in `sim.simulation.run.Run`.
    """
    robot = world.robot
    low, high = robot.ranges(world.mujoco).T
    middle, half = (low + high) / 2, (high - low) / 2
    shares = {"positions": np.abs(log.qpos[:, robot.qpos(world.mujoco)] - middle) / half}
    shares |= {load: loads[load] / limits for load, limits in robot.load_limits.items()}
    return [_within(f"joint {name.replace('_', ' ')}", share, log, robot) for name, share in shares.items()]


def _within(name: str, shares: np.ndarray, log: Log, robot: Robot) -> Check:
    """Check that (T, n) shares of a limit do not exceed 1."""
    frame, joint = np.unravel_index(int(shares.argmax()), shares.shape)
    most = f"{shares[frame, joint]:.1%} of the limit, {robot.joints[joint]} at {log.times[frame]:.2f} s"
    if shares.max() <= 1:
        return Check(name, True, f"at most {most}")
    return log.about.claims.against(name, f"exceeded: {most}")
