"""What a user's MJCF asks for, checked before MuJoCo builds it: a few characters may ask for gigabytes.

A log holds the files of its scene, so that anyone can check it: their paths are relative.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from xml.etree import ElementTree

import mujoco

from prefplan.limits import bounded
from sim.errors import SimulationError
from sim.geometry.mjcf import as_utf8

MAX_BYTES = 20_000_000
"""Greatest size of a file of MJCF."""

MAX_COPIES = 10_000
"""Most copies that the elements `replicate`, one inside another, make in a file."""

MAX_CELLS = 10_000_000
"""Most cells of a height field, and most pixels of a side of a texture: 40 MB."""


def check_file(path: Path, key: str) -> None:
    """Raise SimulationError if a file, or one that it names, asks for more than a scene has, or for files elsewhere.

    What is no XML, or has other values, MuJoCo refuses itself. Messages start with the scenario's `key`.
    """
    _check_mjcf(path, key, frozenset())
    try:
        named = mjcf_files(path)
    except SimulationError:
        return
    for file in named:
        with _told(file, key):
            bounded(file)


def mjcf_files(path: Path) -> list[Path]:
    """Return the files of an MJCF, such as meshes, and itself; raise `SimulationError` if one is missing, or no XML."""
    if not os.path.isfile(path):
        raise SimulationError(f"{path}: no such file")
    try:
        return sorted(Path(os.fsdecode(name.encode())) for name in mujoco.mju_getXMLDependencies(as_utf8(path)))
    except mujoco.FatalError as error:
        raise SimulationError(f"{path}: {' '.join(str(error).split())}") from None


@contextmanager
def _told(path: Path, key: str) -> Iterator[None]:
    """Raise SimulationError if a file cannot be read."""
    try:
        yield
    except OSError as error:
        raise SimulationError(f"{key}: {path}: {str(error.strerror).lower()}") from None


def _check_mjcf(path: Path, key: str, within: frozenset[Path]) -> None:
    """Check a file of MJCF, which files `within` include, and those that it includes."""
    try:
        with _told(path, key):
            root = ElementTree.fromstring(bounded(path, MAX_BYTES).read_text(encoding="utf-8-sig"))
    except (ValueError, ElementTree.ParseError):
        return
    for copies, element in _counted(root, 1):
        if copies > MAX_COPIES:
            raise SimulationError(f"{key}: {path}: replicate makes more than {MAX_COPIES} copies")
        for path_in_it in paths(element):
            if not is_relative(path_in_it):
                raise SimulationError(f"{key}: {path}: {path_in_it!r} is no path relative to the file")
        for kind, sides in (("hfield", ("nrow", "ncol")), ("texture", ("width", "height"))):
            if element.tag == kind and prod(_number(element, side) for side in sides) > MAX_CELLS:
                raise SimulationError(f"{key}: {path}: {kind}: {' x '.join(sides)} is more than {MAX_CELLS}")
        if element.tag == "include" and (other := path.parent / element.get("file", "")) not in within:
            _check_mjcf(other, key, within | {path})


def paths(element: ElementTree.Element) -> list[str]:
    """Return the paths that an element of MJCF names."""
    return [value for key, value in element.attrib.items() if key.startswith("file") or key.endswith("dir")]


def is_relative(path: str) -> bool:
    """Return whether a path is relative on every kind of machine."""
    return not (os.path.isabs(path) or "\0" in path or "\\" in path or ":" in path)


def _counted(element: ElementTree.Element, copies: int) -> Iterator[tuple[int, ElementTree.Element]]:
    """Yield every element with the number of its copies."""
    if element.tag == "replicate":
        copies *= max(1, _number(element, "count"))
    yield copies, element
    if copies <= MAX_COPIES:
        for child in element:
            yield from _counted(child, copies)


def _number(element: ElementTree.Element, name: str) -> int:
    try:
        return int(float(element.get(name, "0")))
    except (ValueError, OverflowError):
        return 0
