"""The first second of the program: what is loaded, and a search while no kernel is compiled."""

from __future__ import annotations

import contextlib
import json
import os
import pty
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = (sys.executable, "-P", "-m", "experiments.program", "front", "example", "--json")


def test_while_nothing_is_compiled_a_front_is_searched_in_python(tmp_path: Path) -> None:
    empty = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    first = subprocess.run(PROGRAM, env=empty, capture_output=True, text=True)
    later = subprocess.run(PROGRAM, capture_output=True, text=True)
    assert first.stderr == "" and not list(tmp_path.rglob("*.nbi"))
    assert _points(first.stdout) == _points(later.stdout) != []


def _points(text: str) -> list[object]:
    plans: list[object] = json.loads(text)["front"]
    return plans


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&-", "<&- >&- 2>&-"])
def test_closed_streams_do_not_matter(closed: str) -> None:
    done = subprocess.run(f"{shlex.join(PROGRAM)} {closed}", shell=True, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert (len(_points(done.stdout)) > 0) if ">&-" not in closed.split() else not done.stdout


@pytest.mark.parametrize("more", [(), ("-q",)])
def test_on_a_terminal_what_is_loaded_is_named_at_once_and_erased(more: tuple[str, ...]) -> None:
    ours, theirs = pty.openpty()
    command = (sys.executable, "-P", "-m", "experiments.program", "verify", "no_such.npz", *more)
    with subprocess.Popen(command, stderr=theirs):
        os.close(theirs)
        shown = b""
        with contextlib.suppress(OSError):  # the program has ended
            while read := os.read(ours, 1024):
                shown += read
    os.close(ours)
    assert shown.startswith(b"loading the simulation ...\r\x1b[K") != bool(more)
    assert shown.endswith(b"no_such.npz: no such file or directory\r\n")
