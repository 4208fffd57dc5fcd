"""What a user's MJCF asks for, tried out before MuJoCo builds it: a few characters may ask for gigabytes.

A log holds the files of its scene, so that anyone can check it: their paths are relative.
"""

import json
import os
from pathlib import Path
from xml.etree import ElementTree

from prefplan.errors import prefixed
from prefplan.limits import MOST_BYTES, bounded, left
from sim.errors import SimulationError
from sim.geometry.apart import run_apart
from sim.geometry.mjcf import as_utf8

MAX_BYTES = 20_000_000
"""Greatest size of a file of MJCF."""

MAX_SECONDS = 60
"""Most time in which MuJoCo builds a file, s."""

MAX_MEMORY = 2_000_000_000
"""Most memory with which MuJoCo builds a file, bytes."""

TRIAL = Path(__file__).with_name("mjcf_trial.py")
"""What is run in a process of its own."""


def check_file(path: Path, key: str) -> None:
    """Raise SimulationError if a file cannot be built, asks for more than a scene has, or for files elsewhere.

    Messages start with the scenario's `key`.

    Raises:
        LimitError: the time is up.
    """
    with prefixed(f"{key}: ", SimulationError):
        _check_paths(path)
        for file in mjcf_files(path):
            _bounded(file)
        _tried(path, "build")


def mjcf_files(path: Path) -> list[Path]:
    """Return the files of an MJCF, such as meshes, and itself; raise `SimulationError` if one is missing, or no XML."""
    if not os.path.isfile(path):
        raise SimulationError(f"{path}: no such file")
    return sorted(Path(os.fsdecode(name.encode())) for name in _tried(path, "read"))


def _tried(path: Path, what: str) -> list[str]:
    """Return the files that MuJoCo reads when a process of its own is to `read` or `build` an MJCF."""
    memory = int(min(MAX_MEMORY, left()[1]))
    told = run_apart(TRIAL, as_utf8(path).encode(), what, str(memory), seconds=MAX_SECONDS)
    if told is None:
        within = f"{MAX_SECONDS} s and {memory / 1e6:.0f} MB of memory"
        raise SimulationError(f"{path}: MuJoCo cannot {what} it within {within}")
    files, refusal = json.loads(told)
    if refusal is not None:
        raise SimulationError(f"{path}: {refusal.strip()}")
    return list(files)


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
