"""Trajectories of the joints: smooth curves through references, which can be blended and braked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from sim.motion.spline import from_rest
from sim.motion.timing import summed
from sim.motion.trajectory import CONTROL_PERIOD_S


@dataclass(frozen=True)
class JointTrajectory:
    """A movement of the arm's n joints, sampled at every step of the simulation; it ends at rest.

    Attributes:
        positions: (K, n) rad.
        velocities: (K, n) rad/s.
    """

    positions: np.ndarray
    velocities: np.ndarray

    def __len__(self) -> int:
        """Return the number of samples K."""
        return len(self.positions)

    def after(self, samples: int) -> JointTrajectory:
        """Return the rest of the trajectory after some samples."""
        return JointTrajectory(self.positions[samples:], self.velocities[samples:])

    def out_of(self, ending: JointTrajectory, rest: np.ndarray) -> JointTrajectory:
        """Return the sum of this trajectory and the end of the previous one, during which it begins.

        Both are at rest where they meet, so that the sum is as smooth as they are and passes near that point.

        Args:
            ending: the rest of the previous movement.
            rest: (n,) joint angles where that ends and this one begins, rad.
        """
        positions = summed(self.positions, ending.positions - rest)
        return JointTrajectory(positions, summed(self.velocities, ending.velocities))

    def braked(self, samples: int) -> JointTrajectory:
        """Return the same path with the joints slowing down at once and stopping after this number of samples.

        Over the duration, taken as 1, the pace falls from 1 to 0 with a slope of at most 1.5 and a second derivative of
        at most 6 (`sim.motion.timing.braking_time`).
        """
        u = np.linspace(0.0, 1.0, samples + 1)[1:]
        pace = 1 - u**2 * (3 - 2 * u)
        # The integral of the pace is the position along the path.
        passed = np.minimum((u - u**3 + u**4 / 2) * samples, len(self)) - 1
        path = CubicSpline(np.arange(len(self)), np.hstack([self.positions, self.velocities]))
        positions, velocities = np.hsplit(path(passed), 2)
        return JointTrajectory(positions, velocities * pace[:, None])


def through(points: np.ndarray, steps: int) -> JointTrajectory:
    """Return the smooth curve from rest through joint references to rest.

    Args:
        points: (N + 1, n) rad, the current joint angles and then a reference for every `CONTROL_PERIOD_S`.
        steps: number of simulation steps in a control period.

    Returns:
        N * steps samples.
    """
    curve = from_rest(np.arange(len(points)) * CONTROL_PERIOD_S, points)
    t = np.arange(1, steps * (len(points) - 1) + 1) * CONTROL_PERIOD_S / steps
    return JointTrajectory(curve(t), curve(t, 1))
