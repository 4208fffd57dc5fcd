"""What actions take of the arm: time, joint travel and energy."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from sim.robots.robot import Robot


@dataclass(frozen=True)
class Effort:
    """What a stretch of a simulation took.

    Attributes:
        time: s.
        travel: sum over the arm's joints of the angle covered, there and back, rad.
        energy: integral of |torque * speed| summed over the arm's joints, J. The torque is what the motors of the
            real arm give: they carry its weight, and braking costs as much as driving.
    """

    time: float = 0.0
    travel: float = 0.0
    energy: float = 0.0

    def __add__(self, other: Effort) -> Effort:
        """Return both together."""
        return Effort(self.time + other.time, self.travel + other.travel, self.energy + other.energy)

    def __sub__(self, other: Effort) -> Effort:
        """Return what was added to the other."""
        return Effort(self.time - other.time, self.travel - other.travel, self.energy - other.energy)


class EffortMeter:
    """Adds up the effort of a running simulation.

    Attributes:
        total: so far.
    """

    def __init__(self, robot: Robot, data: mujoco.MjData) -> None:
        """Begin with nothing at a state."""
        self._dofs = robot.dofs(data.model)
        self._looked = float(data.time)
        self.total = Effort()

    def update(self, data: mujoco.MjData) -> None:
        """Add the time since the last update, at the speeds and torques of a state just simulated."""
        period = float(data.time) - self._looked
        speeds = data.qvel[self._dofs]
        torques = data.qfrc_actuator[self._dofs]
        self._looked = float(data.time)
        self.total += Effort(
            period, period * float(np.abs(speeds).sum()), period * float(np.abs(torques * speeds).sum())
        )
