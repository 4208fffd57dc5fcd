"""The door of a log: a ZIP archive of arrays, of which nothing is unpacked before its header was checked."""

from __future__ import annotations

import hashlib
import zipfile
import zlib
from collections.abc import Collection
from math import prod
from pathlib import Path

import numpy as np
from numpy.lib import format as npy

from sim.errors import LogError

MAX_BYTES = 2**29
"""Greatest size of all arrays of a log in memory, 8 bytes a number: more than an hour of the simulated arm."""

MAX_NAME = 40
"""Most characters of a foreign name in a message."""

ENDING = ".npy"


def read_arrays(path: str | Path, names: Collection[str]) -> tuple[dict[str, np.ndarray], str]:
    """Return the arrays of a log that are in its file, by name, and the file's SHA-256.

    Raises:
        LogError: the file is missing or broken, or has parts that no log has or that are larger than a log's; the
            message names the file.
    """
    try:
        with open(path, "rb") as file, zipfile.ZipFile(file) as archive:
            _check_members(path, archive, names)
            arrays = {part.filename.removesuffix(ENDING): _read(archive, part) for part in archive.infolist()}
            file.seek(0)
            return arrays, hashlib.file_digest(file, "sha256").hexdigest()
    except (FileNotFoundError, IsADirectoryError, PermissionError) as error:
        raise LogError(f"{path}: {str(error.strerror).lower()}") from None
    except MemoryError:
        raise LogError(f"{path}: broken: it claims to be larger than the memory") from None
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, TypeError, RuntimeError):
        raise LogError(f"{path}: broken, or not a log of `prefplan run`") from None


def _check_members(path: str | Path, archive: zipfile.ZipFile, names: Collection[str]) -> None:
    """Raise LogError unless every part of an archive is a log's, and as large as its header says."""
    left = {f"{name}{ENDING}" for name in names}
    total = 0
    for part in archive.infolist():
        if part.filename not in left:
            raise LogError(f"{path}: not a log of `prefplan run`: it holds {part.filename[:MAX_NAME]!r}")
        left.remove(part.filename)
        shape, itemsize, header = _header(archive, part)
        if part.file_size != header + prod(shape) * itemsize:
            raise LogError(f"{path}: broken: {part.filename} is not as long as its header says")
        total += prod(shape) * (1 if itemsize == 1 and len(shape) == 1 else 8)
    if total > MAX_BYTES:
        raise LogError(f"{path}: too large: its arrays have {total / 2**20:.0f} MiB, {MAX_BYTES / 2**20:.0f} at most")


def _header(archive: zipfile.ZipFile, part: zipfile.ZipInfo) -> tuple[tuple[int, ...], int, int]:
    """Return the shape of an array, the bytes of one of its items, and those of its header."""
    with archive.open(part) as file:
        version = npy.read_magic(file)
        read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, _, dtype = read(file)
        if dtype.hasobject or min(shape, default=0) < 0:
            raise ValueError(dtype)
        return shape, dtype.itemsize, file.tell()


def _read(archive: zipfile.ZipFile, part: zipfile.ZipInfo) -> np.ndarray:
    with archive.open(part) as file:
        return np.asarray(npy.read_array(file, allow_pickle=False))
