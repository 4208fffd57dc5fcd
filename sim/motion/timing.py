"""Time parameterisation of joint references within a robot's limits, also while the previous movement is ending."""

from typing import NamedTuple

import numpy as np
import scipy  # its submodules are loaded when they are used

from sim.motion.dynamics import InverseDynamics
from sim.motion.joint_trajectory import JointTrajectory, sampled, summed
from sim.motion.trajectory import CONTROL_PERIOD_S, STEPS, duration, smooth_rate, smooth_step
from sim.robots.robot import Robot

HEADROOM = 0.8
"""Share of the joints' speed and acceleration limits that a reference may use; the rest is for the controller."""

TORQUE_HEADROOM = 0.6
"""Share of a joint's torque left over by gravity that a reference may use; the rest is for the controller. With a
torque at its limit, the arm lags behind; when it has caught up, the torque jumps. At 0.8, torques still reach the limit
with 3 kg at 0.8 m. Holding 3 kg took at most 94 % of the Panda's torques in random postures."""

TORQUE_PERIODS = 6
"""Control periods between two samples of the torques of a movement: shorter than any peak."""

LEAST_TORQUE = 0.01
"""Least share of a torque limit that counts as left for moving, even if gravity leaves less."""

JERK_HEADROOM = 0.1
"""Share of the joints' jerk limits that a reference may use: with more the torques would change too fast."""

TORQUE_RATE_HEADROOM = 0.42
"""Share of the torque rate limits that a reference may use, computed from the arm's inertia and the jerks averaged over
a control period; the rates of the simulated torques are 1.5 to 2.2 times as large."""

JUMP_HEADROOM = 0.85
"""Share of the torque rate limits that a movement may use at its ends, where joints stop within a step. There, the
motors' damping is added to the inertia: for wrists, which have little inertia, it is three times as much."""

JUMP_RATE_PER_S = 280.0
"""Rate of a torque that jumps within a simulation step, divided by the jump, after the low-pass filter of commanded
torques (`sim.simulation.recorder`)."""

PLANNED_JERK_HEADROOM = 0.02
"""Share of the jerk limits that a planned path may use: on it, joints that carry the stretched arm move together, and
0.1 led to 173 % of a torque rate limit."""

SLOWING_MARGIN = 1.02
"""Factor by which a movement is slowed beyond what is needed, since the slowed movement is not checked again."""

BRAKING_HEADROOM = 0.5
"""Share of the acceleration limits that braking uses; the path itself may use the rest."""

MIN_BRAKING_TIME_S = 0.1
"""Shortest time in which the arm stops."""

DELAYS_TRIED = 4
"""Number of start times tried for a movement, from now to the end of the previous movement."""

PAUSE = 3
"""Control periods from the end of the previous movement to the latest start: stopping and starting at once may exceed
the limits."""


class MotionLimits(NamedTuple):
    """The limits of a movement.

    Attributes:
        robot: whose n joints move.
        inertias: (K, n, n) kg m^2, of the arm and its load at the ends of the movement, where jerks are greatest.
        damping: (n, n) kg m^2, which the motors' damping adds to the inertia when the acceleration jumps: the implicit
            integrator lets it act within the step, without counting it in the motors' torques.
        dynamics: of the arm.
        load: at the tool, kg.
    """

    robot: Robot
    inertias: np.ndarray
    damping: np.ndarray
    dynamics: InverseDynamics
    load: float


def timed(limits: MotionLimits, knots: np.ndarray, points: np.ndarray, *, seconds: float = 0.0) -> JointTrajectory:
    """Return a movement from rest to rest on the spline through points, slowed down until it is within the limits.

    Its (K, n) points, rad, are passed at (K,) knots, s, the last a multiple of `CONTROL_PERIOD_S`, if the limits and
    the least duration `seconds` allow it.
    """
    curve, duration = scipy.interpolate.CubicSpline(knots, points, bc_type="clamped"), float(knots[-1])
    slower = max(1.0, seconds / duration)
    movement = sampled(curve, duration, slower=slower)
    excess = max(
        _excess(limits, _from_rest(points[0], movement.references)),
        _end_excess(limits, curve([0.0, duration], 2)) / slower,
    )
    return movement if excess <= 1 else sampled(curve, duration, slower=slower * SLOWING_MARGIN * excess)


def along(limits: MotionLimits, path: np.ndarray, *, overlap: float) -> JointTrajectory:
    """Return a movement from rest to rest along straight lines in joint space.

    Each line is a minimum-jerk movement, which begins while the previous one is ending. Their sum rounds the corners.

    Args:
        limits: of the movement.
        path: (K, n) configurations, rad.
        overlap: share of a line's duration left when the next line begins, 0 .. 1; 0 to stop at every configuration.
    """
    lines = np.diff(path, axis=0)
    spans = np.array([_straight_duration(limits.robot, line) for line in lines])
    begins = np.concatenate([[0.0], np.cumsum(spans[:-1] - overlap * np.minimum(spans[:-1], spans[1:]))])

    def slowed(slower: float) -> JointTrajectory:
        periods = int(np.ceil(float((begins + spans).max()) * slower / CONTROL_PERIOD_S))
        t = np.arange(1, STEPS * periods + 1)[:, None] * CONTROL_PERIOD_S / STEPS
        u = (t / slower - begins) / spans
        return JointTrajectory(path[0] + smooth_step(u) @ lines, smooth_rate(u) / (slower * spans) @ lines)

    excess = _excess(limits, _from_rest(path[0], slowed(1.0).references), jerk=PLANNED_JERK_HEADROOM)
    return slowed(SLOWING_MARGIN * max(1.0, excess))


def begun_late(
    limits: MotionLimits, movement: JointTrajectory, rest: np.ndarray, ending: np.ndarray
) -> JointTrajectory:
    """Return a movement from rest, delayed until its sum with the end of the previous movement is within the limits.

    It begins at (n,) `rest`, rad; `ending` has the (M, n) offsets of the previous one from it, rad, per control period.
    """
    if not len(ending):
        return movement
    late = movement
    for delay in (*np.linspace(0, len(ending), DELAYS_TRIED, dtype=int), len(ending) + PAUSE):
        late = movement.delayed(delay, rest)
        if _excess(limits, summed(late.references, ending)) <= 1:
            break
    return late


def braking_time(robot: Robot, velocities: np.ndarray) -> float:
    """Return how long joints with (n,) velocities, rad/s, take to stop smoothly (`JointTrajectory.braked`), s."""
    speeds = np.abs(velocities)
    slowing = 1.5 * speeds / (BRAKING_HEADROOM * robot.acceleration_limits)
    jerking = np.sqrt(6 * speeds / (JERK_HEADROOM * robot.jerk_limits))
    return float(max(slowing.max(), jerking.max(), MIN_BRAKING_TIME_S))


def _straight_duration(robot: Robot, line: np.ndarray) -> float:
    """Return the duration of a straight line from rest to rest, (n,) rad, within the limits, s."""
    lengths, accelerations = np.abs(line), np.broadcast_to(robot.acceleration_limits, line.shape)
    limits = HEADROOM * np.array([robot.velocity_limits, accelerations])
    times = [duration(length, *most) for length, most in zip(lengths, limits.T, strict=True)]
    # The peak jerk of a smooth step is 60 length / duration^3.
    jerking = np.cbrt(60 * lengths / (PLANNED_JERK_HEADROOM * robot.jerk_limits))
    return float(max(*times, *jerking, CONTROL_PERIOD_S))


def _from_rest(start: np.ndarray, references: np.ndarray) -> np.ndarray:
    """Return (3 + N, n) references, rad: three at rest at an (n,) start, then (N, n) given ones."""
    return np.vstack([np.repeat(start[None], 3, axis=0), references])


def _end_excess(limits: MotionLimits, accelerations: np.ndarray) -> float:
    """Return the factor by which a movement with (2, n) accelerations at its ends, rad/s^2, is too fast.

    An almost stretched arm lags behind the tool's path and catches up at its very end.
    """
    bounds = (limits.inertias, TORQUE_RATE_HEADROOM), (limits.inertias + limits.damping, JUMP_HEADROOM)
    shares = [np.abs(accelerations @ inertias).max(axis=(0, 1)) / headroom for inertias, headroom in bounds]
    return float(np.sqrt(JUMP_RATE_PER_S * (np.max(shares, axis=0) / limits.robot.torque_rate_limits).max()))


def _excess(limits: MotionLimits, references: np.ndarray, *, jerk: float = JERK_HEADROOM) -> float:
    """Return the factor by which a movement along (N, n) references to rest, rad, is too fast; <= 1 if it is not."""
    references = np.vstack([references, np.repeat(references[-1:], 3, axis=0)])
    rates = [np.diff(references, order, axis=0) / CONTROL_PERIOD_S**order for order in (1, 2, 3)]
    speeds, accelerations, jerks = (np.abs(rate).max(axis=0) for rate in rates)
    robot = limits.robot
    torque_rates = np.abs(rates[2] @ limits.inertias).max(axis=(0, 1))
    return float(
        max(
            (speeds / robot.velocity_limits).max() / HEADROOM,
            ((accelerations / robot.acceleration_limits).max() / HEADROOM) ** (1 / 2),
            _torque_share(limits, references[1:-1], (rates[0][1:] + rates[0][:-1]) / 2, rates[1]) ** (1 / 2),
            ((jerks / robot.jerk_limits).max() / jerk) ** (1 / 3),
            ((torque_rates / robot.torque_rate_limits).max() / TORQUE_RATE_HEADROOM) ** (1 / 3),
        )
    )


def _torque_share(limits: MotionLimits, *rows: np.ndarray) -> float:
    """Return the greatest torque that a movement adds to gravity's, as a share of what a reference may add.

    The rows are its (N, n) positions, velocities and accelerations.
    """
    holding, moving = limits.dynamics.torques(*(row[::TORQUE_PERIODS] for row in rows), load=limits.load)
    most = limits.robot.torque_limits
    left = np.maximum(most - np.sign(moving) * holding, LEAST_TORQUE * most)
    return float((np.abs(moving) / left).max()) / TORQUE_HEADROOM
