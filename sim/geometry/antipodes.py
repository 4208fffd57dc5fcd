"""Antipodal pairs: opposite patches of a surface that two pads can press towards each other."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import KDTree

from sim.geometry.point_cloud import PointCloud, spread

DIRECTIONS = np.array(
    [*([np.cos(turn), np.sin(turn), 0.0] for turn in np.radians(np.arange(0, 180, 22.5))), [0.0, 0.0, 1.0]]
)
"""(L, 3) closing directions that are tried."""

FACING, MEAN_FACING = np.cos(np.radians([25, 8]))
"""Least cosines of the angles to the closing direction, for a patch's normals and their mean: no pad slips off."""

PATCH_RADIUS_M = 0.007
"""Radius of the patch that a pad presses, m."""

MIN_PATCH_POINTS = 18
"""Least number of points of a patch: half as many as on a full disc."""

PATCH_DEPTH_M = 0.003
"""Greatest depth of a patch along the closing direction: it is nearly flat."""

GRID_M = 0.006
"""Distance between the lines along which patches are sought."""


@dataclass(frozen=True, eq=False)
class Antipodes:
    """Two patches that face away from each other along a line, `width` m apart.

    The (3,) position is midway between them, m, and the direction a (3,) unit vector from one to the other.
    """

    position: np.ndarray
    direction: np.ndarray
    width: float


@lru_cache(maxsize=32)  # a scene is built again for each check of a log
def antipodes(surface: PointCloud, low: float, high: float) -> tuple[Antipodes, ...]:
    """Return pairs of patches from `low` to `high` apart, m; in each direction, a few, nearest to the centre first."""
    found = []
    for direction in DIRECTIONS:
        if pairs := list(_along(surface, direction, low, high)):
            found += [pairs[i] for i in spread(np.array([pair.position for pair in pairs]), surface.centre)]
    return tuple(found)


def _along(surface: PointCloud, direction: np.ndarray, low: float, high: float) -> Iterator[Antipodes]:
    """Yield the pairs on a grid of lines in one direction."""
    across = np.linalg.svd(direction[None])[2][1:]
    flat, depths = surface.points @ across.T, surface.points @ direction
    tree = KDTree(flat)
    axes = [np.arange(GRID_M * np.floor(np.min(side) / GRID_M), np.max(side), GRID_M) for side in flat.T]
    for point in itertools.product(*axes):
        near = np.array(tree.query_ball_point(point, PATCH_RADIUS_M), dtype=int)
        starts = _patches(depths[near], surface.normals[near], -direction)
        ends = _patches(depths[near], surface.normals[near], direction)
        for start, end in itertools.product(starts, ends):
            width = float(end.max() - start.min())
            if low <= width <= high and start.max() < end.min():
                yield Antipodes(point @ across + (end.max() + start.min()) / 2 * direction, direction, width)


def _patches(depths: np.ndarray, normals: np.ndarray, direction: np.ndarray) -> list[np.ndarray]:
    """Return the depths of the points of each patch that faces in a (3,) direction, m."""
    facing = np.flatnonzero(normals @ direction > FACING)
    ordered = facing[np.argsort(depths[facing])]
    groups = np.split(ordered, np.flatnonzero(np.diff(depths[ordered]) > PATCH_DEPTH_M) + 1)
    return [depths[group] for group in groups if _is_flat(depths[group], normals[group], direction)]


def _is_flat(depths: np.ndarray, normals: np.ndarray, direction: np.ndarray) -> bool:
    if len(depths) < MIN_PATCH_POINTS or np.ptp(depths) > PATCH_DEPTH_M:
        return False
    mean = normals.mean(axis=0)
    return bool(mean @ direction > MEAN_FACING * np.linalg.norm(mean))
