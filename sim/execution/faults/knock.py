"""Knock: an object is knocked over."""

import numpy as np

from sim.execution.faults.fault import Injection
from sim.execution.faults.relocation import ObjectFault

PUSH_SPEEDS_M_S = (0.25, 0.6)
"""Range of the horizontal speed of an object that is knocked over, m/s."""

TOSS_SPEED_M_S = 0.6
"""Upward speed of an object that is knocked over, m/s."""

TUMBLE_SPEEDS_RAD_S = (8.0, 14.0)
"""Range of the angular speed of an object that is knocked over, rad/s."""


class Knock(ObjectFault):
    """An object gets a random velocity, with which it tumbles."""

    kind = "knock"

    def disturb(self, injection: Injection) -> bool:
        """See `ObjectFault.disturb`."""
        rng, data = injection.rng, injection.cell.data
        velocity, axes = data.joint(self.argument).qvel, data.body(self.argument).xmat.reshape(3, 3)
        heading = rng.uniform(-np.pi, np.pi)
        direction = np.array([np.cos(heading), np.sin(heading), 0.0])
        velocity[:3] = direction * rng.uniform(*PUSH_SPEEDS_M_S) + [0.0, 0.0, TOSS_SPEED_M_S]
        velocity[3:] = axes.T @ np.cross([0.0, 0.0, 1.0], direction) * rng.uniform(*TUMBLE_SPEEDS_RAD_S)
        return True
