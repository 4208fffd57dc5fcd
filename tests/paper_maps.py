"""The regions of the paper's grids: boxes x0 y0 x1 y1, corners inclusive."""

from __future__ import annotations

MEADOW = {"dirt": (2, 0, 2, 0), "plant": (1, 1, 1, 1), "rock": (1, 2, 1, 2), "charge": (2, 2, 2, 2)}
"""Of Examples 1 to 3, 3 x 3 cells."""

TOWN = {
    "p1": (2, 0, 4, 2),
    "p2": (7, 2, 9, 4),
    "tacos": (12, 1, 18, 5),
    "cheese": (17, 7, 19, 9),
    "p3": (17, 11, 19, 15),
    "p4": (16, 17, 18, 19),
    "grocer": (10, 10, 14, 19),
    "pizza": (0, 15, 6, 18),
}
"""Of Case Studies 1 and 2, 20 x 20 cells."""
