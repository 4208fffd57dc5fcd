"""Results of long experiments: a header, then one JSON line per result; `kill -9` loses no finished result."""

import errno
import json
import os
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from reprlib import repr as brief
from typing import Any

from experiments.cli.files import cannot_be
from prefplan.errors import PrefplanError


class Journal:
    """A file of results in a folder of `only_writer`; `done` has the finished ones by number."""

    def __init__(self, path: Path, header: dict[str, Any], *, key: str) -> None:
        """Read or create a file; an incomplete last line is dropped.

        The header, JSON-ready and with an entry `prefplan`, is everything on which the results depend; a result's
        number is its entry `key`.

        Raises:
            PrefplanError: the file has another header, is damaged, or cannot be written.
        """
        self.path = path
        self.done: dict[int, dict[str, Any]] = {}
        self._key = key
        try:
            with open(path, "a+b") as file:
                file.seek(0)
                content = file.read()
                whole = content.rfind(b"\n") + 1
                file.truncate(whole)
        except OSError as error:
            raise cannot_be("written", path, error) from None
        if whole:
            self._read(content[:whole].splitlines(), header)
        else:
            self._write(header)

    def _read(self, lines: Sequence[bytes], header: dict[str, Any]) -> None:
        found = self._decode(lines[0], 1, "prefplan", "the header of an experiment")
        for i, line in enumerate(lines[1:], start=2):
            result = self._decode(line, i, self._key, f"the result of a {self._key}")
            self.done[result[self._key]] = result
        different = [key for key in sorted(header.keys() | found.keys()) if header.get(key) != found.get(key)]
        if different:
            told = ", ".join(f"{key} {brief(found.get(key))}, not {brief(header.get(key))}" for key in different)
            raise PrefplanError(f"{self.path}: holds another experiment ({told}); give another --out")

    def _decode(self, line: bytes, number: int, key: str, what: str) -> dict[str, Any]:
        """Return the JSON object of a line, which has a key."""
        with suppress(ValueError):
            value = json.loads(line)
            if isinstance(value, dict) and key in value:
                return value
        raise PrefplanError(f"{self.path}: line {number}: not {what}; the file is damaged or another one")

    def add(self, result: dict[str, Any]) -> None:
        """Write a result to the disk, or raise PrefplanError."""
        self._write(result)
        self.done[result[self._key]] = result

    def _write(self, value: dict[str, Any]) -> None:
        line = json.dumps(value).encode() + b"\n"
        try:
            # Without a buffer: on a full disk, closing the file must not fail a second time.
            with open(self.path, "ab", buffering=0) as file:
                if file.write(line) < len(line):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                os.fsync(file.fileno())
        except OSError as error:
            raise cannot_be("written", self.path, error) from None
