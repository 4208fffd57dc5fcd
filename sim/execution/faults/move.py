"""Move: an object is moved to a free place."""

from __future__ import annotations

import numpy as np

from sim.execution.faults.fault import Injection
from sim.execution.faults.relocation import ObjectFault, in_slot, put

SLOT_PROBABILITY = 0.3
"""Probability that an object is moved to a free location rather than to anywhere on the table."""

MAX_DISTANCE_M, MAX_BEARING_RAD = 0.64, np.radians(65)
"""Greatest distance from the base and angle from straight ahead at which a moved object is put down, the same for every
robot: those that ship reach 0.78 m there."""

MAX_DRAWS = 500
"""Number of poses drawn for a moved object at most, until one is free."""


class Move(ObjectFault):
    """An object is put upright into a free slot, or anywhere within reach."""

    kind = "move"

    def disturb(self, injection: Injection) -> bool:
        """See `ObjectFault.disturb`."""
        cell, rng, obj = injection.cell, injection.rng, self.argument
        if rng.random() < SLOT_PROBABILITY:
            slots = [slot for row in cell.scene.slots.values() for slot in row]
            if any(put(cell, obj, *in_slot(cell, rng, obj, slots[i])) for i in rng.permutation(len(slots))):
                return True
        height, robot = float(cell.scene.shapes[obj].half[2]), cell.scene.robot
        lowest, highest = [robot.nearest_m, -MAX_BEARING_RAD, -np.pi], [MAX_DISTANCE_M, MAX_BEARING_RAD, np.pi]
        for _ in range(MAX_DRAWS):
            far, bearing, yaw = rng.uniform(lowest, highest)
            heading, (x, y) = robot.yaw + bearing, robot.position[:2]
            position = np.array([x + far * np.cos(heading), y + far * np.sin(heading), height + 0.001])
            if put(cell, obj, position, yaw):
                return True
        return False
