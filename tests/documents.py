"""Pages of documentation read as a reader does: files are saved, commands and snippets are run in order."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]

FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """A block of code on a page."""

    language: str
    text: str

    @property
    def file_name(self) -> str | None:
        """The file that the block is to be saved as: its first comment begins with the name."""
        match = re.match(r"(?:#!.*\n)?# (\w+\.\w+)", self.text)
        return match[1] if match else None


def blocks(page: Path) -> list[Block]:
    """Return the blocks of a page in order."""
    return [Block(language, text) for language, text in FENCE.findall(page.read_text(encoding="utf-8"))]


def save(some: Sequence[Block], folder: Path) -> None:
    """Save the files that a page says to save."""
    for block in some:
        if block.file_name:
            (folder / block.file_name).write_text(block.text, encoding="utf-8")


def environment() -> dict[str, str]:
    """Return a reader's environment, in which the program is this working tree's."""
    programs = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    return os.environ | {"PATH": programs, "PYTHONPATH": str(ROOT)}


def shell(script: str, folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a script as a reader would who works in a folder.

    What the script leaves running in the background is ended, and does not keep this from returning.
    """
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        process = subprocess.Popen(
            ["sh", "-ec", script],
            cwd=folder,
            env=environment() | variables,
            stdout=out,
            stderr=err,
            start_new_session=True,
        )
        try:
            status = process.wait()
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
        out.seek(0)
        err.seek(0)
        return subprocess.CompletedProcess(script, status, out.read(), err.read())
