"""Results on disk."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from prefplan.errors import PrefplanError


def make_folder(path: Path) -> None:
    """Make a folder for results.

    Raises:
        PrefplanError: it cannot be made or written to.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PrefplanError(f"{path}: cannot be made ({error.strerror})") from None
    if not os.access(path, os.W_OK | os.X_OK):
        raise PrefplanError(f"{path}: cannot be written to")


def check_new(path: Path, *, force: bool = False, mend: str = "--force replaces it") -> None:
    """Raise PrefplanError if there is something at a path that must not be replaced."""
    if path.exists() and not force:
        raise PrefplanError(f"{path}: already exists; {mend}")


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file atomically: it appears only when it is complete.

    Raises:
        PrefplanError: it cannot be written.
    """
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        draft.write_bytes(data)
        os.replace(draft, path)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise PrefplanError(f"{path}: cannot be written ({error.strerror})") from None


def write_json(path: Path, value: dict[str, Any]) -> None:
    """Write a JSON file atomically.

    Raises:
        PrefplanError: it cannot be written.
    """
    write_bytes(path, (json.dumps(value, indent=1) + "\n").encode())
