"""Curves of edges: smooth from node to node, and self-loops. Lengths are in points; y points downwards."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

RADIUS_PT = 17.0
"""Radius of a node with a short name; a node with a long name is a box with ends of this radius."""

LOOP_PT = 30.0
"""Height of a self-loop above its node, points."""


def curve_between(
    source: np.ndarray,
    half: np.ndarray,
    route: np.ndarray,
    target: np.ndarray,
    other: np.ndarray,
    clear: Sequence[float],
) -> np.ndarray:
    """Return a smooth curve from node to node that is horizontal at given points between them.

    It is also horizontal within the distances `clear` of the centres of both nodes, where it would cross their labels.
    """
    first, last = _border(source, half, route[0]), _border(target, other, route[-1])
    side, far_side = (np.sign(end[0] - middle[0]) for end, middle in ((first, source), (last, target)))
    near = [[source[0] + side * clear[0], first[1]]] if clear[0] > half[0] else []
    far = [[target[0] + far_side * clear[1], last[1]]] if clear[1] > other[0] else []
    between = [*near, *route, *far]
    points = np.array([first, *between, last])
    level = np.array([np.sign(route[-1][0] - route[0][0]) or np.sign(target[0] - source[0]), 0.0])
    out, into = level if near else _outwards(source, first), level if far else -_outwards(target, last)
    tangents = [out, *([level] * len(between)), into]
    curve = [first]
    for (a, b), (u, v) in zip(
        zip(points, points[1:], strict=False), zip(tangents, tangents[1:], strict=False), strict=True
    ):
        reach = 0.55 * abs(b[0] - a[0])
        curve += [a + reach * u / max(abs(u[0]), 0.7), b - reach * v / max(abs(v[0]), 0.7), b]
    return np.array(curve)


def _border(middle: np.ndarray, half: np.ndarray, towards: np.ndarray) -> np.ndarray:
    """Return where a curve from a point meets the border of a node: on its left or right side."""
    apart = towards - middle
    up = half[1] * np.sin(np.clip(np.arctan2(apart[1], abs(apart[0])), -1.0, 1.0))
    round_part = max(0.0, abs(up) - (half[1] - RADIUS_PT))
    across = half[0] - RADIUS_PT + np.sqrt(RADIUS_PT**2 - round_part**2)
    return middle + [(np.sign(apart[0]) or 1.0) * across, up]


def _outwards(middle: np.ndarray, border: np.ndarray) -> np.ndarray:
    apart = border - middle
    apart = np.array([apart[0], apart[1] * 0.6])
    return apart / np.linalg.norm(apart)


def loop_above(top: np.ndarray) -> np.ndarray:
    """Return a self-loop above a node."""
    a, b = top + [-8.5, 2.4], top + [8.5, 2.4]
    rise = 1.25 * LOOP_PT
    return np.array([a, a + [-9, -rise], b + [9, -rise], b])
