"""Objects from mesh files: their visual meshes, and their convex collision parts."""

from __future__ import annotations

import functools
import hashlib
import io
import json
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial import ConvexHull

from prefplan.errors import prefixed
from prefplan.limits import bounded, check_limits
from prefplan.models.manipulation.model import Object
from sim.cache import cache_folder, kept_arrays
from sim.errors import SimulationError
from sim.geometry.apart import run_apart
from sim.geometry.point_cloud import PointCloud
from sim.geometry.solids import smoothed

SIDES_M = 1e-4, 1.0
"""Bounds on the longest side of a mesh, m; checked before a decomposition that may take half a minute."""

CONVEX_SHARE = 0.97
"""Least share of its convex hull that a convex mesh fills."""

MAX_FACES = 20_000
"""A mesh with more faces is simplified to this number, drawn and in collisions: its hull would take half a minute."""

COACD = {
    "threshold": 0.1,
    "max_convex_hull": 24,
    "max_ch_vertex": 64,
    "decimate": True,
    "seed": 0,
    "mcts_nodes": 8,
    "mcts_iterations": 30,
    "mcts_max_depth": 2,
    "resolution": 1000,
    "preprocess_resolution": 30,
}
"""Options of the decomposition: a mug takes half a minute on one core, and minutes with CoACD's defaults."""

MAX_SECONDS = 600
"""Most time that a decomposition takes, s."""

DECOMPOSITION = Path(__file__).with_name("decomposition.py")
"""Script that decomposes a mesh in a separate process."""


@dataclass(frozen=True, eq=False)
class MeshParts:
    """A mesh whose bounding box is centred at the origin, m.

    Attributes:
        drawn: its surface.
        parts: convex meshes that together fill it.
        warning: for the user, or None.
    """

    drawn: trimesh.Trimesh
    parts: tuple[trimesh.Trimesh, ...]
    warning: str | None = None

    @property
    def size(self) -> tuple[float, ...]:
        """Lengths of its bounding box along x, y and z, m."""
        return tuple(round(float(length), 6) for length in self.drawn.extents)

    @functools.cached_property
    def surface(self) -> PointCloud:
        """The parts' surfaces as far as they are on the outside of the whole."""
        return PointCloud.of(self.parts)

    @functools.cached_property
    def corners(self) -> np.ndarray:
        """(K, 3) vertices of its convex hull, m."""
        points = np.concatenate([part.vertices for part in self.parts])
        return points[ConvexHull(points).vertices]

    @functools.cached_property
    def turned_back(self) -> MeshParts:
        """The mesh after a quarter turn about -z."""
        turn = trimesh.transformations.rotation_matrix(-np.pi / 2, [0, 0, 1])
        drawn, *parts = (mesh.copy().apply_transform(turn) for mesh in (self.drawn, *self.parts))
        return MeshParts(drawn, tuple(parts), self.warning)


def mesh_of(obj: Object, folder: Path) -> MeshParts:
    """Return the mesh of an object whose file is beside the scenario, in a folder.

    Raises `SimulationError`, which starts with the object's key, if the file is missing or no mesh.
    """
    where = f"objects.{obj.name}.file"
    if obj.file is None:
        raise SimulationError(f"{where}: missing; an STL or OBJ file beside the scenario")
    path = folder / obj.file
    if path.suffix.lower() not in (".stl", ".obj"):
        raise SimulationError(f"{where}: {obj.file!r} is neither an STL nor an OBJ file")
    try:
        with prefixed(f"objects.{obj.name}."):
            return _loaded(bounded(path).read_bytes(), path.suffix.lower()[1:], obj.scale)
    except OSError as error:
        raise SimulationError(f"{where}: {path}: {str(error.strerror).lower()}") from None
    except (ValueError, IndexError, KeyError, TypeError, AttributeError) as error:
        raise SimulationError(f"{where}: {path}: no mesh can be read from it ({error})") from None


@functools.lru_cache(maxsize=32)
def _loaded(contents: bytes, kind: str, scale: float) -> MeshParts:
    mesh = trimesh.load_mesh(trimesh.util.wrap_as_stream(contents), file_type=kind)
    if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces) or not np.isfinite(mesh.vertices).all():
        raise ValueError("it has no faces")
    longest = float(np.ptp(mesh.vertices, axis=0).max()) * scale
    if not SIDES_M[0] <= longest <= SIDES_M[1]:
        raise SimulationError(f"scale: its longest side is {longest:g} m; 0.001 if the file is in millimetres")
    mesh.apply_scale(scale)
    mesh.apply_translation(-mesh.bounds.mean(axis=0))
    check_limits()
    is_closed = mesh.is_watertight
    check_limits()
    if len(mesh.faces) > MAX_FACES:
        mesh = mesh.simplify_quadric_decimation(face_count=MAX_FACES)
        check_limits()
    if np.linalg.matrix_rank(mesh.vertices - mesh.vertices.mean(axis=0)) < 3:
        raise ValueError("it has no volume")
    hull = mesh.convex_hull
    if not is_closed:
        warning = "its surface is not closed, so that it collides as its convex hull"
        return MeshParts(smoothed(mesh), (hull,), warning)
    convex = mesh.volume > CONVEX_SHARE * hull.volume
    return MeshParts(smoothed(mesh), (hull,) if convex else _decomposed(mesh))


def _decomposed(mesh: trimesh.Trimesh) -> tuple[trimesh.Trimesh, ...]:
    """Return the convex parts of a mesh, cached on disk: to compute them takes seconds to minutes."""
    digest = hashlib.sha256(mesh.vertices.tobytes() + mesh.faces.tobytes() + repr(COACD).encode()).hexdigest()
    arrays = kept_arrays(cache_folder("convex_parts") / f"{digest}.npz", partial(_decompose, mesh))
    return tuple(trimesh.Trimesh(points).convex_hull for points in arrays)


def _decompose(mesh: trimesh.Trimesh) -> list[np.ndarray]:
    """Return the (N, 3) vertices of each convex part."""
    given = io.BytesIO()
    np.savez(given, vertices=mesh.vertices, faces=mesh.faces)
    found, done = run_apart(DECOMPOSITION, json.dumps(COACD), given=given.getvalue(), seconds=MAX_SECONDS)
    if not done:
        raise ValueError(f"it is not decomposed into convex parts within {MAX_SECONDS} s")
    with np.load(io.BytesIO(found)) as parts:
        return [parts[name] for name in parts.files]
