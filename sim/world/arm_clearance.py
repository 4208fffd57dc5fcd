"""Clearance of the arm over tall obstacles between the base and a location at which the hand works."""

from __future__ import annotations

import numpy as np

from sim.geometry.rectangle import Rectangle, overlap

UNDERSIDE = (
    (-0.09, 0.06, 0.055, 0.100),
    (0.03, 0.12, 0.135, 0.150),
    (0.12, 0.30, 0.125, 0.165),
    (0.30, 0.60, 0.110, 0.240),
)
"""What the arm covers while the hand points down: from, to (inward from the tool), half its width, and how high over
the tool its underside is, m. Wrist, forearm twice, elbow; measured on the collision hulls all over the reach, less
5 mm."""


def arm_meets(tool: np.ndarray, obstacle: Rectangle, top: float) -> bool:
    """Return whether the arm collides with an obstacle on the table while the hand points down.

    Args:
        tool: (3,) between the pads, m.
        obstacle: its footprint on the table.
        top: height of its top over the table, m.
    """
    inward = -tool[:2] / np.hypot(*tool[:2])
    bearing = float(np.arctan2(inward[1], inward[0]))
    for near, far, half, height in UNDERSIDE:
        part = Rectangle(tool[:2] + (near + far) / 2 * inward, np.array([(far - near) / 2, half]), bearing)
        if top > tool[2] + height and overlap(part, obstacle):
            return True
    return False
