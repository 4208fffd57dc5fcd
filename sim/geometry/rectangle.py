"""Rectangles on the table, and whether they overlap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Rectangle:
    """A rotated rectangle.

    Attributes:
        centre: (2,) m.
        half: (2,) half its sides, the first along `yaw`, m.
        yaw: heading of its first side, rad.
    """

    centre: np.ndarray
    half: np.ndarray
    yaw: float

    @property
    def axes(self) -> np.ndarray:
        """(2, 2) rows: unit vectors along its sides."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return np.array([[c, s], [-s, c]])

    @property
    def corners(self) -> np.ndarray:
        """(4, 2) corners in order, m."""
        return self.centre + np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * self.half @ self.axes

    def grown(self, margin: float) -> Rectangle:
        """Return the rectangle with every side moved outwards by a margin, m."""
        return Rectangle(self.centre, self.half + margin, self.yaw)


def overlap(a: Rectangle, b: Rectangle) -> bool:
    """Return whether two rectangles overlap (separating axis theorem)."""
    for axis in (*a.axes, *b.axes):
        reach = sum(float(np.abs(r.axes @ axis) @ r.half) for r in (a, b))
        if abs(float((b.centre - a.centre) @ axis)) >= reach:
            return False
    return True


def contains(outer: Rectangle, inner: Rectangle) -> bool:
    """Return whether `inner` lies within `outer`; sides may touch."""
    return bool((np.abs((inner.corners - outer.centre) @ outer.axes.T) <= outer.half + 1e-9).all())
