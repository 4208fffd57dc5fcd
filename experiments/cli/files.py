"""Results on disk."""

import errno
import fcntl
import json
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from prefplan.errors import PrefplanError

DRAFT = re.compile(r"\..+\.(\d+)\.part|\.(?:video|clip)-(\d+)-.*")
"""Names of files and folders that are not complete yet, with the number of the process that writes them."""

DISK_IS_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""Error numbers of writing for which neither the user nor the program is to blame."""


class FullDiskError(PrefplanError):
    """A result for which the disk has no space."""


def cannot_be(done: str, path: Path, error: OSError) -> PrefplanError:
    """Return the error to raise if something cannot be `done`, made or written, at a path."""
    kind = FullDiskError if error.errno in DISK_IS_FULL else PrefplanError
    return kind(f"{path}: cannot be {done} ({error.strerror})")


def make_folder(path: Path) -> None:
    """Make a folder for results, or raise PrefplanError; remove what killed processes have left in it."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_be("made", path, error) from None
    if not os.access(path, os.W_OK | os.X_OK):
        raise PrefplanError(f"{path}: cannot be written to")
    for entry in path.iterdir():
        draft = DRAFT.fullmatch(entry.name)
        if draft is not None and not _is_alive(int(draft[1] or draft[2])):
            shutil.rmtree(entry, ignore_errors=True) if entry.is_dir() else entry.unlink(missing_ok=True)


def _is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        pass
    return True


@contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Make a folder for results, or raise PrefplanError if another process writes to it meanwhile."""
    make_folder(folder)
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            fix = "wait for it or give another --out"
            raise PrefplanError(f"{folder}: another process is writing to it; {fix}") from None
        yield
    finally:
        os.close(descriptor)


def check_new(path: Path, *, force: bool = False, fix: str = "--force replaces it") -> None:
    """Raise PrefplanError if there is something at a path that must not be replaced."""
    if os.path.lexists(path) and not force:
        raise PrefplanError(f"{path}: already exists; {fix}")


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file atomically, or raise PrefplanError: it appears only when it is complete."""
    draft = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        draft.write_bytes(data)
        os.replace(draft, path)
    except OSError as error:
        with suppress(OSError):
            draft.unlink(missing_ok=True)
        raise cannot_be("written", path, error) from None


def write_json(path: Path, value: dict[str, Any]) -> None:
    """Write a JSON file with `write_bytes`."""
    write_bytes(path, (json.dumps(value, indent=1) + "\n").encode())
