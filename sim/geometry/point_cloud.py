"""Point clouds: surfaces of solids as points with normals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import trimesh

POINT_DISTANCE_M = 0.002
"""Approximate distance between neighbouring points of a surface."""

INSIDE_M = 0.0003
"""A point deeper than this inside another part is not on the surface of the whole."""

APART_M = 0.012
"""Least distance between the places of one face that a gripper may press, m."""

MOST_PLACES = 8
"""Greatest number of places of one face that a gripper may press."""


def spread(places: np.ndarray, centre: np.ndarray) -> list[int]:
    """Return the indices of up to `MOST_PLACES` of (N, 3) points, `APART_M` apart, the nearest to a centre first."""
    kept: list[int] = []
    for i in np.argsort(np.linalg.norm(places - centre, axis=-1), kind="stable").tolist():
        if len(kept) < MOST_PLACES and all(np.linalg.norm(places[i] - places[k]) > APART_M for k in kept):
            kept.append(i)
    return kept


def centre_of_mass(parts: Sequence[trimesh.Trimesh]) -> np.ndarray:
    """Return the (3,) centre of mass of convex parts, m."""
    return np.asarray(np.average([part.center_mass for part in parts], axis=0, weights=[part.volume for part in parts]))


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Points on a surface, about `POINT_DISTANCE_M` apart.

    Attributes:
        points: (N, 3), m.
        normals: (N, 3) unit vectors out of the solid.
        centre: (3,) centre of mass of the solid, m.
    """

    points: np.ndarray
    normals: np.ndarray
    centre: np.ndarray

    @staticmethod
    def of(parts: Sequence[trimesh.Trimesh]) -> PointCloud:
        """Return points on the surface of the union of convex parts."""
        points, normals = [], []
        for part in parts:
            number = int(part.area / POINT_DISTANCE_M**2) + 1
            drawn, faces = trimesh.sample.sample_surface_even(part, number, seed=0)
            inside = np.zeros(len(drawn), dtype=bool)
            for other in parts:
                if other is not part:
                    offsets = (drawn[:, None] - other.triangles_center) * other.face_normals
                    inside |= offsets.sum(axis=2).max(axis=1) < -INSIDE_M
            points.append(drawn[~inside])
            normals.append(part.face_normals[faces[~inside]])
        return PointCloud(np.concatenate(points), np.concatenate(normals), centre_of_mass(parts))
