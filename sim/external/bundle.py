"""The files that a scene is built from besides the scenario: packed into logs, and unpacked again."""

from __future__ import annotations

import base64
import binascii
import functools
import os
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import LogError, SimulationError
from sim.external.user_scene import scene_files


def packed(model: ManipulationModel) -> dict[str, str]:
    """Return the files of a model, encoded in base64, by their paths relative to the scenario's folder.

    Raises:
        SimulationError: one of them is missing.
    """
    found = {obj.file for obj in model.objects if obj.file is not None}
    for name in filter(None, (model.scene, model.robot_setup.mjcf)):
        beside, path = os.path.dirname(name), model.folder / name
        found |= {os.path.join(beside, os.path.relpath(part, path.parent)) for part in scene_files(path)}
    return {name: base64.b64encode(_contents(model.folder / name)).decode() for name in sorted(found)}


def _contents(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise SimulationError(f"{path}: {str(error.strerror).lower()}") from None


def in_folder(model: ManipulationModel, folder: Path) -> ManipulationModel:
    """Return a model whose files are looked for in a folder."""
    return replace(model, folder=folder, robot=replace(model.robot_setup, folder=folder))


def unpacked(files: Mapping[str, str]) -> Path:
    """Return a temporary folder with packed files at their relative paths; it is removed when the process ends.

    Raises:
        LogError: a path or the contents of a file are invalid.
    """
    return _unpacked(tuple(sorted(files.items())))[1]


@functools.lru_cache(maxsize=8)
def _unpacked(files: tuple[tuple[str, str], ...]) -> tuple[tempfile.TemporaryDirectory[str], Path]:
    """Return the temporary directory, which is removed with its last reference, and the scenario's folder in it."""
    root = tempfile.TemporaryDirectory(prefix="prefplan-")
    # A path may begin with `..`.
    above = max((Path(name).parts.count(os.pardir) for name, _ in files), default=0)
    folder = Path(root.name).resolve().joinpath(*["above"] * above)
    folder.mkdir(parents=True, exist_ok=True)
    for name, contents in files:
        path = Path(os.path.normpath(folder / name))
        if not path.is_relative_to(root.name) or "\0" in name:
            raise LogError(f"the log is broken: {name!r} is no valid path of a file")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(base64.b64decode(contents, validate=True))
        except (OSError, binascii.Error, ValueError):
            raise LogError(f"the log is broken: the file {name!r} cannot be unpacked") from None
    return root, folder
