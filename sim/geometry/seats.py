"""Seats of a suction cup: flat places on a surface that its lip can be pressed on."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import trimesh
from scipy.ndimage import maximum_filter, minimum_filter

from sim.geometry.point_cloud import centre_of_mass, spread

GRID_M = 0.002
"""Distance between the lines along which the surface is sampled."""

FLAT_M = 0.0005
"""Greatest difference in height under the lip: its rubber yields by more."""

NO_HEIGHT_M = -1.0
"""Marks lines that do not meet the surface."""

SAME_FACE = np.cos(np.radians(3))
"""Least cosine of the angle between the normals of triangles that belong to one face."""


@dataclass(frozen=True, eq=False)
class Seat:
    """A flat place on a surface: the (3,) position of its middle, m, and its (3,) normal out of the solid."""

    position: np.ndarray
    normal: np.ndarray


@lru_cache(maxsize=32)  # a scene is built again for each check of a log
def seats(
    parts: tuple[trimesh.Trimesh, ...], *, half_width: float, hand_half_width: float, hand_height: float
) -> tuple[Seat, ...]:
    """Return seats on the union of convex parts: by face, the largest first, and near the centre of mass first.

    A square of `half_width`, m, must be flat; below the hand, which is aligned with it, no part may be higher than
    `hand_height` over the lip, m.
    """
    found = []
    centre = centre_of_mass(parts)
    for normal in _normals(parts, (2 * half_width) ** 2):
        across = np.linalg.svd(normal[None])[2][1:]
        flat = np.concatenate([part.vertices for part in parts]) @ across.T
        axes = [np.arange(low, high + GRID_M, GRID_M) for low, high in zip(flat.min(0), flat.max(0), strict=True)]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        heights = np.max([_heights(part, grid @ across, normal) for part in parts], axis=0)
        lip, hand = (2 * int(np.ceil(half / GRID_M)) + 1 for half in (half_width, hand_half_width))
        outside = {"mode": "constant", "cval": NO_HEIGHT_M}
        level = maximum_filter(heights, lip, **outside) - minimum_filter(heights, lip, **outside) < FLAT_M
        free = maximum_filter(heights, hand, **outside) < heights + hand_height
        fits = level & free & (heights > NO_HEIGHT_M)
        places = grid[fits] @ across + heights[fits, None] * normal
        found += [Seat(places[i], normal) for i in spread(places, centre)]
    return tuple(found)


def _normals(parts: Sequence[trimesh.Trimesh], area: float) -> list[np.ndarray]:
    """Return the (3,) normals of faces of at least an area, m², the largest first."""
    normals = np.concatenate([part.face_normals for part in parts])
    areas = np.concatenate([part.area_faces for part in parts])
    left, found = np.ones(len(normals), dtype=bool), []
    for i in np.argsort(-areas, kind="stable"):
        if left[i]:
            face = left & (normals @ normals[i] > SAME_FACE)
            left &= ~face
            if areas[face].sum() >= area:
                found.append((areas[face].sum(), normals[i]))
    return [normal for _, normal in sorted(found, key=lambda pair: -pair[0])]


def _heights(part: trimesh.Trimesh, points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return the greatest height of a convex part along a (3,) normal on the lines through (..., 3) points, m.

    A line is inside the part where it is inside every face's half-space.
    """
    slopes = part.face_normals @ normal
    with np.errstate(divide="ignore", invalid="ignore"):
        gaps = np.einsum("ij,ij->i", part.face_normals, part.triangles_center) - points @ part.face_normals.T
        bounds = gaps / slopes
    top = np.where(slopes > 1e-9, bounds, np.inf).min(axis=-1)
    bottom = np.where(slopes < -1e-9, bounds, -np.inf).max(axis=-1)
    beside = (gaps[..., np.abs(slopes) <= 1e-9] < 0).any(axis=-1)
    return np.where((bottom <= top) & ~beside, top, NO_HEIGHT_M)
