"""Trajectories of the joints, which can be delayed, blended and braked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy  # its submodules are loaded when they are used

from sim.motion.trajectory import CONTROL_PERIOD_S, STEPS


@dataclass(frozen=True)
class JointTrajectory:
    """A movement of the arm's n joints, sampled at every step of whole control periods; it ends at rest.

    Positions and velocities are (K, n), rad and rad/s.
    """

    positions: np.ndarray
    velocities: np.ndarray

    def __len__(self) -> int:
        """Return the number of samples K."""
        return len(self.positions)

    @property
    def references(self) -> np.ndarray:
        """(N, n) positions at the ends of the control periods, rad."""
        return self.positions[STEPS - 1 :: STEPS]

    @property
    def seconds(self) -> float:
        """The duration, s."""
        return len(self) / STEPS * CONTROL_PERIOD_S

    def delayed(self, periods: int, rest: np.ndarray) -> JointTrajectory:
        """Return this trajectory after some control periods at rest at (n,) joint angles, rad."""
        pause = np.repeat(rest[None], periods * STEPS, axis=0)
        return JointTrajectory(np.vstack([pause, self.positions]), np.vstack([0 * pause, self.velocities]))

    def after(self, samples: int) -> JointTrajectory:
        """Return the rest of the trajectory after some samples."""
        return JointTrajectory(self.positions[samples:], self.velocities[samples:])

    def out_of(self, ending: JointTrajectory, rest: np.ndarray) -> JointTrajectory:
        """Return the sum of this trajectory and the end of the previous one, during which it begins.

        The previous one ends and this one begins at (n,) angles `rest`, rad, at rest: the sum is as smooth as both, and
        passes near this point.
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
        path = scipy.interpolate.CubicSpline(np.arange(len(self)), np.hstack([self.positions, self.velocities]))
        positions, velocities = np.hsplit(path(passed), 2)
        return JointTrajectory(positions, velocities * pace[:, None])


def sampled(curve: scipy.interpolate.PPoly, duration: float, *, slower: float = 1.0) -> JointTrajectory:
    """Return the movement along a curve of a duration, s, slowed down by a factor and then to whole control periods."""
    count = STEPS * int(np.ceil(duration * slower / CONTROL_PERIOD_S - 1e-6))
    t = np.arange(1, count + 1) * duration / count
    return JointTrajectory(curve(t), curve(t, 1) * duration * STEPS / (count * CONTROL_PERIOD_S))


def summed(references: np.ndarray, ending: np.ndarray) -> np.ndarray:
    """Return the sum of (N, n) references and the (M, n) end of the previous movement: (max(N, M), n), rad."""
    both = np.vstack([references, np.repeat(references[-1:], max(0, len(ending) - len(references)), axis=0)])
    both[: len(ending)] += ending
    return both
