"""The 3-D scene of a report, one for all runs, and its viewer, as scripts that a page can load from disk."""

from __future__ import annotations

import base64
import gzip
import re
from collections.abc import Mapping
from pathlib import Path

from trimesh.creation import box
from trimesh.viewer import scene_to_html

from experiments.cli.files import write_bytes
from experiments.report.recordings import Recording
from sim.export.gltf import encode_glb

LIBRARY = "three.js"
"""File of the viewer's library: three.js with its loader of glTF, MIT, three.js authors."""

SCENE = "scene_data.js"
"""File of the scene: of the files on a disk, a page can load only scripts."""

LIBRARY_END = "THREE.GLTFLoader=GLTFLoader;})();"
"""End of the library in the page that trimesh makes of a scene."""


def write_scene(recordings: Mapping[int, Recording], folder: Path) -> bool:
    """Write the scene of some runs and the library that shows it; return whether the library was found.

    Raises:
        PrefplanError: a file cannot be written.
    """
    library = _library()
    if library is None:
        return False
    scene = encode_glb({f"plan {i}": recording.log for i, recording in recordings.items()})
    text = base64.b64encode(gzip.compress(scene, mtime=0)).decode()
    write_bytes(folder / SCENE, f'window.sceneData = "{text}";\n'.encode())
    write_bytes(folder / LIBRARY, library.encode())
    return True


def _library() -> str | None:
    """Return the library that comes with trimesh, with its licence; None if trimesh has another viewer."""
    page = scene_to_html(box().scene())
    script = re.search(r"<script>(.*?)</script>", page, re.DOTALL)
    library, end, _ = (script[1] if script else "").partition(LIBRARY_END)
    return library + end if end else None
