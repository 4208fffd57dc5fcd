"""Solids with rounded edges, which catch the light as real objects do: boxes, cylinders, plates and trays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh

CREASE = np.radians(40)
"""Faces that meet at a smaller angle are shaded as one smooth surface, rad."""


@dataclass(frozen=True)
class Solid:
    """A surface ready to draw.

    Attributes:
        vertices: (V, 3) m.
        normals: (V, 3) unit normals.
        faces: (F, 3) indices into both.
    """

    vertices: np.ndarray
    normals: np.ndarray
    faces: np.ndarray


def smoothed(mesh: trimesh.Trimesh) -> Solid:
    """Return a mesh with vertices doubled along creases, so that it is smooth in between only."""
    shaded = trimesh.graph.smooth_shade(mesh, angle=CREASE)
    return Solid(np.array(shaded.vertices), np.array(shaded.vertex_normals), np.array(shaded.faces))


def rounded_box(half: np.ndarray, radius: float, *, steps: int = 2) -> Solid:
    """Return a box with rounded edges.

    Every face of the box is a grid, dense along its rim; a point within `radius` of the rim is pushed onto the
    sphere or cylinder of that radius about the inner box.

    Args:
        half: (3,) half its sides, m.
        radius: of the edges, m.
        steps: quads across half an edge.
    """
    parts: list[Solid] = []
    ramp = np.linspace(0, radius, steps + 1)
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        lines = [np.concatenate([ramp - half[a], half[a] - ramp[::-1]]) for a in (u, v)]
        grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
        for side in (-1, 1):
            points = np.empty((*grid.shape[:2], 3))
            points[..., axis], points[..., u], points[..., v] = side * half[axis], grid[..., 0], grid[..., 1]
            inner = np.clip(points, radius - half, half - radius)
            normals = (points - inner) / np.linalg.norm(points - inner, axis=-1, keepdims=True)
            faces = _quads(*grid.shape[:2])
            faces = faces if side > 0 else faces[:, ::-1]
            parts.append(Solid((inner + radius * normals).reshape(-1, 3), normals.reshape(-1, 3), faces))
    first = np.cumsum([0] + [len(part.vertices) for part in parts])
    return Solid(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, first, strict=False)]),
    )


def plate(half: np.ndarray, *, corner: float, bevel: float) -> Solid:
    """Return a flat plate with round corners, its middle at the origin.

    Args:
        half: (3,) half its sides, m.
        corner: radius of the corners seen from above, m.
        bevel: width of the slope along its upper edge, m.
    """
    x, y, z = half
    return _lofted(
        [
            (x, y, corner, -z),
            (x, y, corner, z - bevel),
            (x - 0.3 * bevel, y - 0.3 * bevel, corner - 0.3 * bevel, z - 0.3 * bevel),
            (x - bevel, y - bevel, corner - bevel, z),
        ],
        closed=False,
    )


def rounded_cylinder(radius: float, half: float, bevel: float, *, steps: int = 3) -> Solid:
    """Return an upright cylinder with rounded rims, its middle at the origin.

    Args:
        radius: m.
        half: half its height, m.
        bevel: radius of the rims' rounding, m.
        steps: quads across a rim.
    """
    angles = np.linspace(0, np.pi / 2, steps + 1)
    top = [(radius - bevel + bevel * np.cos(a), half - bevel + bevel * np.sin(a)) for a in angles]
    bottom = [(r, -z) for r, z in reversed(top)]
    return _lofted([(r, r, r, z) for r, z in [*bottom, *top]], closed=False)


def tray(half: np.ndarray, *, wall: float, corner: float) -> Solid:
    """Return walls of even thickness with round corners and a round brim, standing on z = 0.

    Args:
        half: (3,) half the sides inside, and the walls' whole height, m.
        wall: thickness, m.
        corner: radius of the corners inside, m.
    """
    x, y, z = half
    brim = [(wall / 2 * (1 + np.cos(a)), z - wall / 2 * (1 - np.sin(a))) for a in np.linspace(0, np.pi, 7)]
    outside, inside = (wall, 0.0), (0.0, 0.0)
    return _lofted([(x + w, y + w, corner + w, h) for w, h in [outside, *brim, inside]], closed=True)


def dish(half: np.ndarray, *, floor: float, rim: float) -> Solid:
    """Return a dish as round as its sides allow, standing on z = 0.

    Args:
        half: (2,) half its sides, m.
        floor: height of its flat middle, m.
        rim: height of its rim, m.
    """
    least = float(half.min())
    profile = [
        (0.40 * least, 0.0),
        (0.37 * least, 0.35 * floor),
        (0.0, rim - 0.0016),
        (0.0, rim - 0.0006),
        (0.0008, rim),
        (0.0022, rim - 0.0002),
        (0.0130, floor + 0.0010),
        (0.0150, floor + 0.0002),
        (0.0175, floor),
    ]
    return _lofted([(*(half - inset), least - inset, z) for inset, z in profile], closed=False)


def _lofted(loops: list[tuple[float, float, float, float]], *, closed: bool) -> Solid:
    """Return the surface through round-cornered rectangles (half x, half y, corner radius, height) in turn.

    Args:
        loops: from the outer foot upwards.
        closed: whether the last loop leads back to the first; otherwise both ends are filled.
    """
    rings = [_rounded_rectangle(x, y, max(r, 1e-4), z) for x, y, r, z in loops]
    count = len(rings[0])
    vertices = np.concatenate(rings)
    columns = np.arange(count)
    following = (columns + 1) % count
    faces = []
    for k in range(len(rings) - 1):
        a, b = k * count + columns, k * count + following
        c, d = b + count, a + count
        faces += [np.stack([a, b, c], -1), np.stack([a, c, d], -1)]
    if not closed:
        top, middle = (len(rings) - 1) * count, len(vertices)
        vertices = np.concatenate([vertices, [[0.0, 0.0, loops[-1][3]], [0.0, 0.0, loops[0][3]]]])
        faces.append(np.stack([top + columns, top + following, np.full(count, middle)], -1))
        faces.append(np.stack([following, columns, np.full(count, middle + 1)], -1))
    return smoothed(trimesh.Trimesh(vertices, np.concatenate(faces), process=False))


def _rounded_rectangle(x: float, y: float, radius: float, z: float) -> np.ndarray:
    """Return (N, 3) points anticlockwise seen from above."""
    points = []
    for quarter, (sx, sy) in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
        for angle in np.linspace(0, np.pi / 2, 7) + quarter * np.pi / 2:
            points.append((sx * (x - radius) + radius * np.cos(angle), sy * (y - radius) + radius * np.sin(angle), z))
    return np.array(points)


def _quads(rows: int, columns: int) -> np.ndarray:
    """Return the triangles of a grid of points in row-major order."""
    corner = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    return np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
