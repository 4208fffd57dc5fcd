"""What a load comes to rest on or beside at the end of a path: there it may touch that."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

CARRIER_NEARING_M = 0.001
"""By how much the load may be nearer to a carrier on the path than at its end, and how deep in one beside it, m: the
arm comes to rest within 1 mm of where it is sent."""

LEAST_LIFT = 0.7
"""Least upward component of the normal of a contact that carries the load. The load may end deeper in what carries it,
as the height of that is observed, too; but not in what is beside it, and never in what is above it."""


@dataclass(frozen=True)
class Carriers:
    """Geoms that may touch the load.

    Attributes:
        own: (ngeom,) bool, which geoms are the load's.
        least: distance from the load, by geom, down to which it may be touched, m.
    """

    own: np.ndarray
    least: dict[int, float]

    @classmethod
    def found(cls, own: np.ndarray, data: mujoco.MjData, *, clearance: float, without: np.ndarray) -> Carriers:
        """Return those that are within a clearance of the load now, m, except for (ngeom,) bool that are none.

        What is beside it counts only where something carries it.
        """
        contact, found, carried = data.contact, dict[int, float](), False
        for (one, other), distance, frame in zip(contact.geom.tolist(), contact.dist, contact.frame, strict=True):
            # The normal points from the first geom to the second.
            carrier, lift = (other, -frame[2]) if own[one] else (one, frame[2])
            if own[one] == own[other] or without[carrier] or distance >= clearance:
                continue
            if lift > LEAST_LIFT or (lift > -LEAST_LIFT and distance > -CARRIER_NEARING_M):
                found[carrier] = min(found.get(carrier, np.inf), float(distance) - CARRIER_NEARING_M)
                carried |= lift > LEAST_LIFT
        return cls(own, found if carried else {})

    def touching(self, data: mujoco.MjData) -> np.ndarray:
        """Return which of the N contacts are of the load with one of these geoms, no nearer than it may be: (N,)."""
        pairs = zip(data.contact.geom.tolist(), data.contact.dist.tolist(), strict=True)
        return np.array(
            [
                self.own[one] != self.own[other] and distance > self.least.get(other if self.own[one] else one, np.inf)
                for (one, other), distance in pairs
            ],
            dtype=bool,
        )
