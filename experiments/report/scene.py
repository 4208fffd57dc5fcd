"""The 3-D scene of a report, one for all runs, and the library that shows it, as scripts that a page can load."""

import base64
import gzip
from collections.abc import Mapping
from pathlib import Path

from experiments.cli.files import write_bytes
from experiments.report.recordings import Recording
from sim.export.gltf import encode_glb

LIBRARY = Path(__file__).parents[2] / "assets" / "three.js.gz"
"""three.js r140 with its glTF loader and camera controls, which a page can load without a server; compressed."""

SCENE = "scene_data.js"
"""File of the scene: a script, since a page that is opened from a disk can load no other files."""


def write_scene(recordings: Mapping[int, Recording], folder: Path) -> None:
    """Write the scene of some runs and the library that shows it.

    Raises:
        PrefplanError: a file cannot be written.
    """
    scene = encode_glb({f"plan {i}": recording.proof.log for i, recording in recordings.items()})
    text = base64.b64encode(gzip.compress(scene, mtime=0)).decode()
    write_bytes(folder / SCENE, f'window.sceneData = "{text}";\n'.encode())
    write_bytes(folder / LIBRARY.stem, gzip.decompress(LIBRARY.read_bytes()))
