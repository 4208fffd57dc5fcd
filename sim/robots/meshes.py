"""The Panda's surface: the installed STL files, parted by finish, thinned out and smoothed."""

from __future__ import annotations

import functools
import importlib.util
from dataclasses import dataclass
from pathlib import Path

import fast_simplification
import numpy as np
import trimesh

from sim.geometry.solids import smoothed

LINKS = (*(f"link{i}" for i in range(8)), "hand", "finger")
"""The files' names, without ending."""

FACES_KEPT = {"link6": 0.2, "link7": 0.2, "hand": 0.4, "finger": 1.0}
"""Share of a link's faces that is kept, a tenth for the others: 134 thousand become 20. The wrist has fine curves."""

DETAIL_AREA, DETAIL_FACES = 3e-3, 80
"""A part of less surface (m^2), such as a plug, keeps no more faces than this."""

GENTLENESS = 2
"""`agg` of fast-simplification: its default of 7 is a quarter second faster and dents the curves."""

SMALLEST_PART = 1e-5
"""Parts of less surface are specks of the original drawing and left out, m^2."""

FINISHES = {
    "link3": ("shell", "trim"),
    "link4": ("shell", "trim"),
    "link5": ("shell", "trim"),
    "link6": ("shell", "trim", "shell"),
    "link7": ("metal", "trim"),
    "hand": ("shell", "metal"),
    "finger": ("metal", "rubber"),
}
"""Finish of each link's connected parts, largest first. The rest are `trim`; other links' largest is `shell`."""


LAPPING = ("link1", "link3", "link5")
"""Links whose lower rim, as drawn, ends 1 mm short of the link before: a slit narrower than a pixel, of which a
picture would show dots."""

LAP = 1.2e-3
"""By how much their rim is drawn further down, m."""

RIM = 1e-4
"""What is no higher than this above a link's lowest point is its rim, m."""


@dataclass(frozen=True)
class Surface:
    """All parts of one link that share a finish, in the link's frame."""

    link: str
    finish: str
    solid: trimesh.Trimesh


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
    mesh = trimesh.load_mesh(path)
    if path.stem in LAPPING:
        mesh.vertices = _lapped(mesh.vertices)
    parts = mesh.split(only_watertight=False)
    parts = sorted((p for p in parts if p.area > SMALLEST_PART), key=lambda part: -part.area)
    finishes = FINISHES.get(path.stem, ("shell",))
    share = FACES_KEPT.get(path.stem, 0.08)
    by_finish: dict[str, list[trimesh.Trimesh]] = {}
    for i, part in enumerate(parts):
        finish = finishes[i] if i < len(finishes) else "trim"
        by_finish.setdefault(finish, []).append(_thinned(part, share))
    return [Surface(path.stem, finish, smoothed(_joined(members))) for finish, members in by_finish.items()]


def _lapped(vertices: np.ndarray) -> np.ndarray:
    """Return a link's (V, 3) vertices, the lower rim brought into the link before."""
    below = np.where(vertices[:, 2] < vertices[:, 2].min() + RIM, LAP, 0.0)
    return vertices - below[:, None] * [0.0, 0.0, 1.0]


def _thinned(part: trimesh.Trimesh, share: float) -> trimesh.Trimesh:
    wanted = int(share * len(part.faces))
    if part.area < DETAIL_AREA:
        wanted = DETAIL_FACES
    if wanted >= len(part.faces):
        return part
    vertices, faces = fast_simplification.simplify(part.vertices, part.faces, target_count=wanted, agg=GENTLENESS)
    return trimesh.Trimesh(vertices, faces)


def _joined(parts: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    whole = trimesh.util.concatenate(parts)
    assert isinstance(whole, trimesh.Trimesh)
    return whole
