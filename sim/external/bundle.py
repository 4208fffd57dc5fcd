"""The files that a scene is built from besides the scenario: packed into logs, and unpacked again."""

import base64
import functools
import hashlib
import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

from prefplan.limits import bounded
from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import LogError, SimulationError
from sim.geometry.mjcf_limits import is_relative, mjcf_files, paths


def packed(model: ManipulationModel) -> dict[str, str]:
    """Return the files of a model in base64, by their normalised paths relative to the scenario's folder.

    Raises `SimulationError` if one of them is missing.
    """
    return {name: base64.b64encode(_contents(model.folder / name)).decode() for name in _file_names(model)}


def digests(model: ManipulationModel) -> dict[str, str]:
    """Return the SHA-256 of each file of a model, by its normalised path relative to the scenario's folder.

    Raises `SimulationError` if one of them is missing.
    """
    return {name: hashlib.sha256(_contents(model.folder / name)).hexdigest() for name in _file_names(model)}


def _file_names(model: ManipulationModel) -> list[str]:
    """Return the normalised paths of all files of a model, sorted."""
    found = {os.path.normpath(obj.file) for obj in model.objects if obj.file is not None}
    for name in filter(None, (model.scene, model.robot_setup.mjcf)):
        beside, path = os.path.dirname(name), model.folder / name
        parts = (os.path.relpath(part, path.parent) for part in mjcf_files(path))
        found |= {os.path.normpath(os.path.join(beside, part)) for part in parts}
    return sorted(found)


def _contents(path: Path) -> bytes:
    try:
        return bounded(path).read_bytes()
    except OSError as error:
        raise SimulationError(f"{path}: {str(error.strerror).lower()}") from None


def unpacked(model: ManipulationModel, files: Mapping[str, str]) -> ManipulationModel:
    """Return a model with packed files, in a temporary folder that is removed when the process ends.

    Nothing outside that folder is read: the files must be exactly those that the model names. Raises `LogError` if they
    are not, or if a path or the contents of a file are invalid.
    """
    for name in model.files:
        if os.path.normpath(name) not in files:
            raise LogError(f"the log is broken: it does not hold the file {name!r}, which its scenario names")
    folder = _unpacked(tuple(sorted(files.items())))[1]
    model = replace(model, folder=folder, robot=replace(model.robot_setup, folder=folder))
    others = files.keys() ^ set(_file_names(model))
    if others:
        raise LogError(f"the log is broken: {min(others)!r} is held or named, but not both")
    return model


@functools.lru_cache(maxsize=8)
def _unpacked(files: tuple[tuple[str, str], ...]) -> tuple[tempfile.TemporaryDirectory[str], Path]:
    """Return the temporary directory, which is removed with its last reference, and the scenario's folder in it."""
    contents = {name: _decoded(name, text) for name, text in files}
    root = tempfile.TemporaryDirectory(prefix="prefplan-")
    # No path leads out of a folder that is nested deeper than the number of `..` in all paths.
    within = [
        Path(path).parts.count(os.pardir) for name, data in contents.items() for path in (name, *_paths(name, data))
    ]
    if sum(within) > 20:
        raise LogError("the log is broken: the paths of its files lead too far up")
    folder = Path(root.name).resolve().joinpath(*["above"] * sum(within))
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in contents.items():
        path = Path(os.path.normpath(folder / name))
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("xb") as file:
                file.write(data)
        except (OSError, ValueError):
            raise LogError(f"the log is broken: the file {name!r} cannot be unpacked") from None
    return root, folder


def _decoded(name: str, text: str) -> bytes:
    if not is_relative(name) or name != os.path.normpath(name):
        raise LogError(f"the log is broken: {name!r} is no valid path of a file")
    try:
        return base64.b64decode(text, validate=True)
    except ValueError:
        raise LogError(f"the log is broken: the file {name!r} cannot be unpacked") from None


def _paths(name: str, contents: bytes) -> Iterator[str]:
    """Yield the paths in a file if it is XML; raise `LogError` if it is no valid XML, or one is not relative."""
    if not contents.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
        return
    try:
        root = ElementTree.fromstring(contents.decode("utf-8-sig"))
    except (ElementTree.ParseError, ValueError):
        raise LogError(f"the log is broken: the file {name!r} is no valid XML") from None
    for element in root.iter():
        for path in paths(element):
            if not is_relative(path):
                raise LogError(f"the log is broken: {path!r} in {name!r} is no relative path")
            yield path
