"""Trial build of a user's MJCF, before MuJoCo builds it in this process: a few characters may ask for gigabytes.

Its files have relative paths, since a log holds the files of its scene, so that anyone can check it.
"""

import json
import os
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree

from prefplan.errors import prefixed
from prefplan.limits import MOST_BYTES, bounded, left
from sim.errors import SimulationError
from sim.geometry.apart import run_apart
from sim.geometry.mjcf import as_utf8

MAX_BYTES = 20_000_000
"""Greatest size of a file of MJCF, bytes."""

MAX_SECONDS = 60
"""Most time in which MuJoCo builds a file, s."""

MAX_MEMORY = 2_000_000_000
"""Most memory with which MuJoCo builds a file, bytes."""

TRIAL = Path(__file__).with_name("mjcf_trial.py")
"""Script that builds an MJCF in a separate process."""

_built: dict[Path, dict[Path, int]] = {}
"""When each file of an MJCF that could be built was last written, ns, by the path of the MJCF."""


def check_file(path: Path, key: str) -> None:
    """Raise SimulationError if a file cannot be built within the limits, or names files by absolute paths.

    Messages start with the scenario's `key`.

    Raises:
        LimitError: the time is up.
    """
    with prefixed(f"{key}: ", SimulationError):
        mjcf_files(path)


def mjcf_files(path: Path) -> list[Path]:
    """Return an MJCF and the files that it names, such as meshes; for errors, see `check_file`."""
    if not os.path.isfile(path):
        raise SimulationError(f"{path}: no such file")
    if path not in _built or _built[path] != _written(_built[path]):
        _check_paths(path)
        _built[path] = _written(_tried(path))
    return sorted(_built[path])


def _written(files: Iterable[Path]) -> dict[Path, int]:
    """Return when files were last written, ns; those that are gone are left out."""
    return {file: file.stat().st_mtime_ns for file in files if file.exists()}


def _tried(path: Path) -> list[Path]:
    """Return the files that MuJoCo reads when a process of its own builds an MJCF."""
    memory = int(min(MAX_MEMORY, left()[1]))
    said, _ = run_apart(TRIAL, as_utf8(path).encode(), str(memory), seconds=MAX_SECONDS)
    told = {key: value for line in said.splitlines() for key, value in json.loads(line).items()}
    files = [Path(os.fsdecode(name.encode())) for name in told.get("files", ())]
    for file in files:
        _bounded(file)
    if "refusal" not in told:
        within = f"{MAX_SECONDS} s and {memory / 1e6:.0f} MB of memory"
        raise SimulationError(f"{path}: MuJoCo cannot build it within {within}")
    if told["refusal"]:
        raise SimulationError(f"{path}: {' '.join(told['refusal'].split())}")
    return files


def _bounded(path: Path, most: int = MOST_BYTES) -> Path:
    """Return the path of a file, or raise SimulationError if it cannot be read or is too large."""
    try:
        return bounded(path, most)
    except OSError as error:
        raise SimulationError(f"{path}: {str(error.strerror).lower()}") from None


def _check_paths(path: Path) -> None:
    """Check the paths in a file of MJCF and in those that it includes, each once."""
    found = [path]
    for file in found:
        try:
            root = ElementTree.fromstring(_bounded(file, MAX_BYTES).read_text(encoding="utf-8-sig"))
        except (OSError, ValueError, ElementTree.ParseError):
            continue
        for element in root.iter():
            for path_in_it in paths(element):
                if not is_relative(path_in_it):
                    raise SimulationError(f"{file}: {path_in_it!r} is no path relative to the file")
            if element.tag == "include" and (other := file.parent / element.get("file", "")) not in found:
                found.append(other)


def paths(element: ElementTree.Element) -> list[str]:
    """Return the paths that an element of MJCF names."""
    return [value for key, value in element.attrib.items() if key.startswith("file") or key.endswith("dir")]


def is_relative(path: str) -> bool:
    """Return whether a path is relative on every kind of machine."""
    return not (os.path.isabs(path) or "\0" in path or "\\" in path or ":" in path)
