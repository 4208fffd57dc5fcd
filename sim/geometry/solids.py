"""Solids with rounded edges, which reflect light as real objects do: each a stack of round-cornered rectangles."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import trimesh

CREASE_RAD = np.radians(40)
"""Faces that meet at a smaller angle are shaded as one smooth surface."""

EDGE_STEPS = 3
"""Number of facets of a round edge."""

CORNER_SAG_M = 1e-4
"""Greatest distance between a round corner seen from above and its facets."""


def joined(parts: Sequence[trimesh.Trimesh]) -> trimesh.Trimesh:
    """Return one mesh of several."""
    whole = trimesh.util.concatenate(parts)
    assert isinstance(whole, trimesh.Trimesh)
    return whole


def smoothed(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return a mesh with vertices doubled along creases, so that normals are not smoothed across them."""
    return trimesh.graph.smooth_shade(mesh, angle=CREASE_RAD, facet_minarea=None)


def rounded(half: np.ndarray, *, corner: float, edge: float) -> trimesh.Trimesh:
    """Return a box of (3,) half sides, m, centred at the origin; if `corner` is half its sides, a cylinder.

    `corner` is the radius of the upright edges, `edge` that of the others, m.
    """
    x, y, z = half
    angles = np.linspace(0, np.pi / 2, EDGE_STEPS + 1)
    rim = list(zip(edge * (1 - np.cos(angles)), z - edge * (1 - np.sin(angles)), strict=True))
    profile = [*((inset, -height) for inset, height in reversed(rim)), *rim]
    return _lofted(tuple((x - inset, y - inset, corner - inset, height) for inset, height in profile))


def tray(half: np.ndarray, *, wall: float, corner: float) -> trimesh.Trimesh:
    """Return walls without a floor, on z = 0, with a round brim; `corner` is the inner radius of their corners, m.

    `half` is (3,): half the inner sides, and the full height of the walls, m; `wall` is their thickness, m.
    """
    x, y, z = half
    angles = np.linspace(0, np.pi, 2 * EDGE_STEPS + 1)
    brim = zip(wall / 2 * (1 + np.cos(angles)), z - wall / 2 * (1 - np.sin(angles)), strict=True)
    profile = [(wall, 0.0), *brim, (0.0, 0.0)]
    return _lofted(tuple((x + w, y + w, corner + w, height) for w, height in profile), closed=True)


def dish(half: np.ndarray, *, floor: float, rim: float) -> trimesh.Trimesh:
    """Return a dish of (2,) half sides, m, on z = 0, round or with round ends; `floor` and `rim` are heights, m."""
    least = float(half.min())
    foot = [(0.40 * least, 0.0), (0.37 * least, 0.35 * floor)]
    lip = [(0.0, rim - 0.0016), (0.0, rim - 0.0006), (0.0008, rim), (0.0022, rim - 0.0002)]
    middle = [(0.0130, floor + 0.0010), (0.0150, floor + 0.0002), (0.0175, floor)]
    return _lofted(tuple((*(half - inset), least - inset, height) for inset, height in [*foot, *lip, *middle]))


@lru_cache(maxsize=256)  # within and across scenes, many parts are equal
def _lofted(loops: tuple[tuple[float, float, float, float], ...], *, closed: bool = False) -> trimesh.Trimesh:
    """Return the surface through round-cornered rectangles (half x, half y, corner radius, height) in order.

    The order is from the outer foot upwards. Both ends are filled, unless the profile is `closed`.
    """
    widest = max(radius for _, _, radius, _ in loops)
    steps = int(np.ceil(np.pi / 4 / np.arccos(1 - min(0.5, CORNER_SAG_M / widest))))
    rings = [_ring(x, y, max(radius, 1e-4), height, steps) for x, y, radius, height in loops]
    count = len(rings[0])
    middles = [] if closed else [[[0.0, 0.0, loops[end][3]]] for end in (0, -1)]
    vertices = np.concatenate([*rings, *middles])
    here = np.arange(count)
    beside = (here + 1) % count
    faces = []
    for lower in range(0, count * (len(rings) - 1), count):
        a, b, c, d = lower + here, lower + beside, lower + count + beside, lower + count + here
        faces += [np.stack([a, b, c], -1), np.stack([a, c, d], -1)]
    if not closed:
        last, bottom, top = count * (len(rings) - 1), *(np.full(count, len(vertices) - end) for end in (2, 1))
        faces += [np.stack([beside, here, bottom], -1), np.stack([last + here, last + beside, top], -1)]
    solid = trimesh.Trimesh(vertices, np.concatenate(faces), process=False)
    # Where rings are circles, their quarters share end points, which would show as vertical lines if not merged.
    solid.merge_vertices()
    solid.update_faces(solid.nondegenerate_faces())
    return smoothed(solid)


def _ring(x: float, y: float, radius: float, height: float, steps: int) -> np.ndarray:
    """Return (N, 3) points of a round-cornered rectangle, anticlockwise seen from above."""
    quarters = np.radians(np.arange(0, 360, 90))[:, None]
    angles = quarters + np.linspace(0, np.pi / 2, steps + 1)
    centres = (np.array([x, y]) - radius) * [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    outline = centres[:, None] + radius * np.stack([np.cos(angles), np.sin(angles)], -1)
    return np.column_stack([outline.reshape(-1, 2), np.full(outline.size // 2, height)])
