"""The Panda's visual meshes: the installed STL files, split by finish, simplified and smoothed."""

import functools
import hashlib
from collections.abc import Sequence
from functools import partial
from importlib.metadata import version
from pathlib import Path

import numpy as np
import trimesh

from prefplan.limits import check_limits
from sim.cache import cache_folder, kept_arrays
from sim.geometry.solids import joined, smoothed

FOLDER = "kitchen_franka/franka_assets/meshes"
"""Folder of gymnasium-robotics with the STL files, `visual` and `collision`."""

FINISHES = {
    **{f"link{i}": ("shell",) for i in range(3)},
    "link3": ("shell", "trim"),
    "link4": ("shell", "trim"),
    "link5": ("shell", "trim"),
    "link6": ("shell", "trim", "shell"),
    "link7": ("metal", "trim"),
    "hand": ("shell", "metal"),
    "finger": ("metal", "rubber"),
}
"""Finishes of each link's connected parts, largest first; the rest are `trim`. Links have the files' names."""

LIBRARIES = ("trimesh", "fast-simplification")
"""Libraries on which the surfaces depend."""

FACES_KEPT = {"link7": 0.15, "hand": 0.4, "finger": 1.0}
"""Share of a link's faces that is kept, 0.08 for the others: 134,000 become 20,000. The wrist has fine curves."""

DETAIL_AREA_M2 = 3e-3
"""Surface area below which a part, such as a plug, keeps at most `DETAIL_FACES` faces, m^2."""

DETAIL_FACES = 80
"""Greatest number of faces of such a part."""

MIN_AREA_M2 = 1e-5
"""Parts with a smaller surface are artefacts of the original files and left out."""

SEAMS_M = {"link1": -0.1925, "link2": 0.0, "link3": -0.1215, "link4": 0.0, "link5": -0.2595}
"""Height of the 1 mm gap to the previous link in a link's frame, m. Both links are round about the joint's axis there.
The gap would be rendered as a dotted line, so a sleeve covers it."""

SLEEVE_M = [(0.0543, -0.008), (0.0553, -0.001), (0.0553, 0.001), (0.0543, 0.008)]
"""Outline of a sleeve, radius and height, m: its edges lie inside the links, whose radius is 55 mm, or 54.4 to 55.3 mm
after simplification."""

SLEEVE_SIDES = 48


@functools.cache
def surfaces(folder: Path) -> dict[tuple[str, str], trimesh.Trimesh]:
    """Return the mesh of all parts of a link that share a finish, in the link's frame, m, by link and finish.

    They are kept on disk, since to make them takes more than a second.
    """
    paths = [folder / "visual" / f"{link}.stl" for link in FINISHES]
    sources = (path.read_bytes() for path in (Path(__file__), *paths))
    digest = hashlib.sha256(b"".join([*sources, *(version(name).encode() for name in LIBRARIES)])).hexdigest()
    arrays = kept_arrays(cache_folder("panda_meshes") / f"{digest}.npz", partial(_arrays, paths))
    names, solids = arrays[0].tolist(), zip(arrays[1::3], arrays[2::3], arrays[3::3], strict=True)
    return {
        (link, finish): trimesh.Trimesh(vertices, faces, vertex_normals=normals, process=False)
        for (link, finish), (vertices, faces, normals) in zip(names, solids, strict=True)
    }


def _arrays(paths: Sequence[Path]) -> list[np.ndarray]:
    """Return the links and finishes of the surfaces in some files, and the vertices, faces and normals of each."""
    made = {(path.stem, finish): solid for path in paths for finish, solid in _surfaces(path).items()}
    arrays = [array for solid in made.values() for array in (solid.vertices, solid.faces, solid.vertex_normals)]
    return [np.array([*made]), *arrays]


def _surfaces(path: Path) -> dict[str, trimesh.Trimesh]:
    check_limits()
    mesh = trimesh.load_mesh(path)
    parts = mesh.split(only_watertight=False)
    parts = sorted((part for part in parts if part.area > MIN_AREA_M2), key=lambda part: -part.area)
    finishes = (*FINISHES[path.stem], *("trim" for _ in parts))
    by_finish: dict[str, list[trimesh.Trimesh]] = {}
    for part, finish in zip(parts, finishes, strict=False):
        by_finish.setdefault(finish, []).append(_thinned(part, FACES_KEPT.get(path.stem, 0.08)))
    solids = {finish: smoothed(joined(members)) for finish, members in by_finish.items()}
    if path.stem in SEAMS_M:
        solids["shell"] = joined([solids["shell"], _sleeve(SEAMS_M[path.stem])])
    return solids


def _sleeve(height: float) -> trimesh.Trimesh:
    """Return a sleeve round the z axis, centred at a height, m, with the normals of a cylinder."""
    sleeve = trimesh.creation.revolve(SLEEVE_M, sections=SLEEVE_SIDES)
    return trimesh.Trimesh(
        sleeve.vertices + [0, 0, height],
        sleeve.faces,
        vertex_normals=trimesh.unitize(sleeve.vertices * [1, 1, 0]),
        process=False,
    )


def _thinned(part: trimesh.Trimesh, share: float) -> trimesh.Trimesh:
    wanted = DETAIL_FACES if part.area < DETAIL_AREA_M2 else int(share * len(part.faces))
    if wanted >= len(part.faces):
        return part
    # The default aggression of 7 is a quarter second faster and dents the curves.
    return part.simplify_quadric_decimation(face_count=wanted, aggression=2)
