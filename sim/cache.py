"""Files that are kept from run to run in the user's cache; where it is not writable, nothing is kept."""

import io
import os
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from zipfile import BadZipFile

import numpy as np


def cache_folder(name: str) -> Path:
    """Return the folder of the user's cache for files of a kind; it need not exist."""
    return Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser() / "prefplan" / name


def keep(path: Path, contents: bytes) -> None:
    """Write a file of the cache if that is writable; it appears only when it is complete."""
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            part = Path(folder, path.name)
            part.write_bytes(contents)
            os.replace(part, path)


def add_line(path: Path, line: str) -> None:
    """Append a line to a file of the cache if that is writable; a line before it that was cut off does no harm."""
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("ab", buffering=0) as file:
            file.write(f"\n{line}".encode())


def kept_arrays(path: Path, make: Callable[[], Sequence[np.ndarray]]) -> list[np.ndarray]:
    """Return the arrays in a file of the cache; where it is missing or damaged, make and keep them."""
    try:
        with np.load(path, allow_pickle=False) as kept:
            return [kept[name] for name in kept.files]
    except (OSError, ValueError, EOFError, BadZipFile):
        made, archive = list(make()), io.BytesIO()
        np.savez_compressed(archive, *made)
        keep(path, archive.getvalue())
        return made
