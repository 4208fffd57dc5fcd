"""The Panda's surface: the installed STL files, parted by finish, thinned out and smoothed."""

from __future__ import annotations

import functools
import importlib.util
from dataclasses import dataclass
from pathlib import Path

import fast_simplification
import numpy as np
import trimesh

LINKS = (*(f"link{i}" for i in range(8)), "hand", "finger")
"""The files' names, without ending."""

FACES_KEPT = 0.2
"""Share of the 134 thousand faces that is kept: 1.8 mm off at most, and half the time to render."""

FEWEST_FACES = 200
"""A part with fewer faces is kept as it is."""

SMALLEST_PART = 1e-5
"""Parts of less surface are specks of the original drawing and left out, m^2."""

CREASE = np.radians(38)
"""Faces that meet at a smaller angle are shaded as one smooth surface, rad."""

FINISHES = {
    "link3": ("shell", "trim"),
    "link4": ("shell", "trim"),
    "link5": ("shell", "trim"),
    "link6": ("shell", "trim", "shell", "shell", "shell"),
    "link7": ("metal", "trim"),
    "hand": ("shell", "metal"),
    "finger": ("metal", "rubber"),
}
"""Finish of each link's connected parts, largest first. The rest are `trim`; other links' largest is `shell`."""


@dataclass(frozen=True)
class Surface:
    """All parts of one link that share a finish.

    Attributes:
        vertices: (V, 3) in the link's frame, m.
        normals: (V, 3) unit normals.
        faces: (F, 3) indices into both.
    """

    link: str
    finish: str
    vertices: np.ndarray
    normals: np.ndarray
    faces: np.ndarray


def mesh_folder() -> Path | None:
    """Return the folder with `visual` and `collision` STL files, or None when they are not installed."""
    found = importlib.util.find_spec("gymnasium_robotics")
    if found is None or not found.submodule_search_locations:
        return None
    folder = Path(found.submodule_search_locations[0], "envs/assets/kitchen_franka/franka_assets/meshes")
    return folder if folder.is_dir() else None


@functools.cache
def surfaces(folder: Path) -> tuple[Surface, ...]:
    """Return what to draw of every link; takes about a second, once a process."""
    return tuple(surface for link in LINKS for surface in _surfaces(folder / "visual" / f"{link}.stl"))


def _surfaces(path: Path) -> list[Surface]:
    parts = trimesh.load_mesh(path).split(only_watertight=False)
    parts = sorted((p for p in parts if p.area > SMALLEST_PART), key=lambda part: -part.area)
    finishes = FINISHES.get(path.stem, ("shell",))
    by_finish: dict[str, list[trimesh.Trimesh]] = {}
    for i, part in enumerate(parts):
        finish = finishes[i] if i < len(finishes) else "trim"
        by_finish.setdefault(finish, []).append(_smoothed(_thinned(part)))
    found = []
    for finish, members in by_finish.items():
        whole = trimesh.util.concatenate(members)
        normals = np.concatenate([member.vertex_normals for member in members])
        found.append(Surface(path.stem, finish, np.array(whole.vertices), normals, np.array(whole.faces)))
    return found


def _thinned(part: trimesh.Trimesh) -> trimesh.Trimesh:
    wanted = max(FEWEST_FACES, int(FACES_KEPT * len(part.faces)))
    if len(part.faces) <= wanted:
        return part
    vertices, faces = fast_simplification.simplify(part.vertices, part.faces, target_count=wanted)
    return trimesh.Trimesh(vertices, faces)


def _smoothed(part: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return the part with its vertices doubled along creases, so that normals are smooth in between only."""
    return trimesh.graph.smooth_shade(part, angle=CREASE)
