"""The record file of a sweep: a header, then one JSON line a rollout; `kill -9` loses nothing that was finished."""

from __future__ import annotations

import fcntl
import json
import os
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from experiments.sweep.job import Record
from prefplan.errors import PrefplanError


class Records:
    """The open record file of a sweep; one process at a time has it.

    Attributes:
        path: the file.
        done: the finished rollouts by number.
    """

    def __init__(self, path: Path, header: dict[str, Any]) -> None:
        """Open a file or begin it; a last line that was never finished is dropped.

        Args:
            path: the file.
            header: all that defines the sweep, JSON-ready.

        Raises:
            PrefplanError: it holds another sweep, is in use, is damaged, or cannot be written.
        """
        self.path = path
        self.done: dict[int, Record] = {}
        try:
            self._file: IO[bytes] = open(path, "a+b")
        except OSError as error:
            raise PrefplanError(f"{path}: cannot be written ({error.strerror})") from None
        try:
            self._open(header)
        except BaseException:
            self._file.close()
            raise

    def _open(self, header: dict[str, Any]) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise PrefplanError(
                f"{self.path}: another sweep is writing to it; wait for it or give another --out"
            ) from None
        self._file.seek(0)
        content = self._file.read()
        whole = content.rfind(b"\n") + 1
        self._file.truncate(whole)
        lines = content[:whole].splitlines()
        if not lines:
            self._write(header)
            return
        there, *records = (self._read(line, number) for number, line in enumerate(lines, start=1))
        if "prefplan" not in there:
            raise PrefplanError(f"{self.path}: line 1: not the header of a sweep")
        different = sorted(key for key in header.keys() | there.keys() if header.get(key) != there.get(key))
        if different:
            told = ", ".join(_difference(key, there.get(key), header.get(key)) for key in different)
            raise PrefplanError(f"{self.path}: holds another sweep ({told}); give another --out")
        for number, record in enumerate(records, start=2):
            if not isinstance(record.get("rollout"), int):
                raise PrefplanError(f"{self.path}: line {number}: not the record of a rollout")
            self.done[record["rollout"]] = record

    def _read(self, line: bytes, number: int) -> dict[str, Any]:
        try:
            value = json.loads(line)
        except ValueError:
            value = None
        if not isinstance(value, dict):
            raise PrefplanError(f"{self.path}: line {number}: not a JSON object; the file is damaged")
        return value

    def add(self, record: Record) -> None:
        """Keep a rollout: when this returns it is on the disk.

        Raises:
            PrefplanError: it cannot be written.
        """
        self._write(record)
        self.done[record["rollout"]] = record

    def _write(self, value: dict[str, Any]) -> None:
        try:
            self._file.write(json.dumps(value).encode() + b"\n")
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            raise PrefplanError(f"{self.path}: cannot be written ({error.strerror})") from None

    def __enter__(self) -> Records:
        """Return it open."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        self._file.close()


def _difference(key: str, there: Any, here: Any) -> str:
    """Return in what two sweeps differ, short enough for a message."""
    key = key.replace("_", " ")
    short = all(isinstance(value, (str, int, float)) and len(str(value)) < 60 for value in (there, here))
    return f"{key} {there}, not {here}" if short else f"other {key}"
