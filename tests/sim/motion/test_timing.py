from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from sim.motion.joint_trajectory import JointTrajectory, sampled, summed
from sim.motion.kinematics import Arm
from sim.motion.timing import begun_late, braking_time, timed
from sim.motion.trajectory import CONTROL_PERIOD_S, STEPS, smooth_step
from sim.robots.arms.panda import PANDA
from sim.simulation.recorder import TORQUE_CUTOFF_HZ

STEP_S = CONTROL_PERIOD_S / STEPS

LIMITS = Arm(PANDA).limits(PANDA.home)

STRETCHED = np.array([0.0, 1.2, 0.0, -0.5, 0.0, 1.7, 0.8])
"""Joint angles of the stretched arm, rad."""


def turn(angle: float, seconds: float, joint: int = 1) -> np.ndarray:
    """Return references that turn one joint from home by an angle, rad."""
    t = np.arange(1, round(seconds / CONTROL_PERIOD_S) + 1) * CONTROL_PERIOD_S
    return PANDA.home + angle * np.outer(smooth_step(t / seconds), np.eye(7)[joint])


def shares(positions: np.ndarray, period: float) -> list[float]:
    """Return the greatest speed, acceleration and jerk as shares of the limits, with rest before and after."""
    rows = np.vstack([np.repeat(positions[:1], 3, axis=0), positions, np.repeat(positions[-1:], 3, axis=0)])
    limits = PANDA.velocity_limits, PANDA.acceleration_limits, PANDA.jerk_limits
    return [float((np.abs(np.diff(rows, k, axis=0)).max(axis=0) / period**k / limits[k - 1]).max()) for k in (1, 2, 3)]


@pytest.mark.parametrize("seconds", [0.3, 0.6, 2.0])
def test_a_movement_is_slowed_until_it_keeps_to_the_limits_and_no_further(seconds: float) -> None:
    points = np.vstack([PANDA.home, turn(0.8, seconds)])
    movement = timed(LIMITS, np.arange(len(points)) * CONTROL_PERIOD_S, points)
    assert max(shares(np.vstack([PANDA.home, movement.positions]), STEP_S)) < 0.9
    references = movement.references
    assert references[-1] == pytest.approx(points[-1])
    if seconds == 2.0:
        assert references == pytest.approx(points[1:])
    else:
        assert max(shares(references, CONTROL_PERIOD_S)) > 0.7


def test_a_movement_takes_the_least_duration() -> None:
    points = np.vstack([PANDA.home, turn(0.3, 1.0)])
    movement = timed(LIMITS, np.arange(len(points)) * CONTROL_PERIOD_S, points, seconds=1.5)
    assert movement.seconds == pytest.approx(1.5) and len(movement.references) == 150


def test_a_movement_that_begins_abruptly_is_slowed_as_one_that_ends_so() -> None:
    points = turn(0.5, 1.0)[45:]
    knots = np.arange(len(points)) * CONTROL_PERIOD_S
    begun, ended = (len(timed(LIMITS, knots, path).references) for path in (points, points[::-1]))
    assert begun == ended > 1.2 * len(points)


@pytest.mark.parametrize(("joint", "most"), [(1, 0.45), (4, 0.25)], ids=["stretched arm", "wrist"])
def test_no_torque_jumps_where_joints_catch_up_at_the_end(joint: int, most: float) -> None:
    u = np.linspace(0.0, 1.0, 25)
    knots, points = 0.72 * u, STRETCHED + 0.3 * np.outer(u**3 * (4 - 3 * u), np.eye(7)[joint])
    limits = Arm(PANDA).limits(points[0], points[-1])
    curve = timed(limits, knots, points)
    speeding = np.diff(curve.velocities, axis=0)[-2] / STEP_S
    filtered = 1 / (STEP_S + 1 / (2 * np.pi * TORQUE_CUTOFF_HZ))
    rates = np.abs(limits.inertias @ speeding).max(axis=0) * filtered / PANDA.torque_rate_limits
    damped = np.abs((limits.inertias + limits.damping) @ speeding).max(axis=0) * filtered / PANDA.torque_rate_limits
    assert 0.1 < rates.max() < most and damped.max() < 0.9


def test_a_stretched_arm_is_turned_more_gently() -> None:
    """Torques change by the arm's inertia times the jerk; stretched, its inertia about the first joint is largest."""
    limits = Arm(PANDA).limits(STRETCHED)
    points = np.vstack([PANDA.home, turn(0.3, 0.4, joint=0)])
    knots = np.arange(len(points)) * CONTROL_PERIOD_S
    folded, stretched = (timed(one, knots, points) for one in (LIMITS, limits))
    assert len(stretched) > len(folded)
    for one, movement in ((LIMITS, folded), (limits, stretched)):
        rows = np.vstack([PANDA.home, movement.positions])
        jerks = np.diff(np.vstack([np.repeat(rows[:1], 3, axis=0), rows]), 3, axis=0) / STEP_S**3
        assert np.abs(jerks @ one.inertias[0]).max() < PANDA.torque_rate_limits[0]


def movements() -> tuple[JointTrajectory, JointTrajectory]:
    """Return a turn of joint 2, and one of joint 4 that begins where it ends."""
    first = turn(0.5, 1.0)
    second = first[-1] + (turn(0.4, 1.0, joint=3) - PANDA.home)
    knots = np.linspace(0.0, 1.0, 101)
    paths = np.vstack([PANDA.home, first]), np.vstack([first[-1], second])
    one, other = (sampled(CubicSpline(knots, path, bc_type="clamped"), 1.0) for path in paths)
    return one, other


@pytest.mark.parametrize("left", [0, 50, 400])
def test_a_movement_out_of_another_is_as_smooth_and_ends_where_it_should(left: int) -> None:
    first, second = movements()
    rest, done = first.positions[-1], len(first) - left
    both = second.out_of(first.after(done), rest)
    whole = np.vstack([first.positions[:done], both.positions])
    assert both.positions[-1] == pytest.approx(second.positions[-1]) and len(both) == len(second)
    apart = max(shares(first.positions, STEP_S)), max(shares(second.positions, STEP_S))
    assert max(shares(whole, STEP_S)) < 1.1 * max(apart), "different joints do not add up"
    speeds = np.diff(whole, axis=0) / STEP_S
    assert both.velocities[:-1] == pytest.approx(speeds[done:], abs=0.02)
    slowest = np.abs(speeds[100:-100]).max(axis=1).min()
    assert (slowest > 0.02) == (left > 0), "rest in between only if the first is at its end"


def test_an_ending_longer_than_the_movement_is_followed_to_its_end() -> None:
    first, second = movements()
    short = JointTrajectory(second.positions[:10] * 0 + first.positions[-1], second.velocities[:10] * 0)
    both = short.out_of(first.after(100), first.positions[-1])
    assert len(both) == len(first) - 100 and both.positions == pytest.approx(first.positions[100:])


def test_a_movement_against_the_ending_begins_later() -> None:
    """The joint brakes at its acceleration limit, and turning back would add to that."""
    movement = timed(LIMITS, np.arange(61) * CONTROL_PERIOD_S, np.vstack([PANDA.home, turn(0.8, 0.6)]))
    references = movement.references
    ending = references[len(references) // 2 :] - references[-1]
    back = 2 * references[-1] - references
    assert max(shares(np.vstack([references[: len(references) // 2], summed(back, ending)]), CONTROL_PERIOD_S)) > 0.81
    returning = JointTrajectory(references[-1] + PANDA.home - movement.positions, -movement.velocities)
    late = begun_late(LIMITS, returning, references[-1], ending).references
    assert len(late) > len(references)
    together = np.vstack([references[: len(references) // 2], summed(late, ending)])
    assert max(shares(together, CONTROL_PERIOD_S)) <= 0.81
    assert together[-1] == pytest.approx(PANDA.home)


@pytest.mark.parametrize("done", [30, 250, 400])
def test_braking_stops_on_the_path_within_the_limits(done: int) -> None:
    points = np.vstack([PANDA.home, turn(0.8, 0.6)])
    first = timed(LIMITS, np.arange(61) * CONTROL_PERIOD_S, points)
    rest = first.after(min(done, len(first) - 20))
    samples = round(braking_time(PANDA, rest.velocities[0]) / STEP_S)
    braked = rest.braked(samples)
    assert len(braked) == samples and np.abs(braked.velocities[-1]).max() < 1e-6
    whole = np.vstack([first.positions[: len(first) - len(rest)], braked.positions])
    assert max(shares(whole, STEP_S)) < 1
    assert (np.diff(whole[:, 1]) >= -1e-9).all() and whole[-1, 1] <= first.positions[-1, 1] + 1e-9
    assert np.abs(np.delete(whole - PANDA.home, 1, axis=1)).max() < 1e-9
