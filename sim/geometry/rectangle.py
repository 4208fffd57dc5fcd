"""Rectangles on the table, and whether and how far they overlap."""

from __future__ import annotations

from collections.abc import Iterator
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

    def local(self, points: np.ndarray) -> np.ndarray:
        """Return (..., 2) points, m, in the frame of its centre and its sides."""
        return np.asarray((points - self.centre) @ self.axes.T)

    def grown(self, margin: float) -> Rectangle:
        """Return the rectangle with every side moved outwards by a margin, m."""
        return Rectangle(self.centre, self.half + margin, self.yaw)


def overlap(a: Rectangle, b: Rectangle) -> bool:
    """Return whether two rectangles overlap (separating axis theorem)."""
    return all(depth > 0 for depth in _depths(a, b))


def overlap_depth(a: Rectangle, b: Rectangle) -> float:
    """Return the least distance by which one of two rectangles must be moved so that they only touch, m."""
    return max(0.0, min(_depths(a, b)))


def _depths(a: Rectangle, b: Rectangle) -> Iterator[float]:
    """Yield how far the projections of two rectangles on each of their axes overlap, m; negative if they are apart."""
    for axis in (*a.axes, *b.axes):
        reach = sum(float(np.abs(r.axes @ axis) @ r.half) for r in (a, b))
        yield reach - abs(float((b.centre - a.centre) @ axis))


def contains(outer: Rectangle, inner: Rectangle) -> bool:
    """Return whether `inner` lies within `outer`; sides may touch."""
    return bool((np.abs(outer.local(inner.corners)) <= outer.half + 1e-9).all())
