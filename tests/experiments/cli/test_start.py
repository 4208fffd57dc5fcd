"""The first search after an installation, when no kernel is compiled."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from experiments.cli import start

PROGRAM = (sys.executable, "-P", "-m", "experiments.program", "front", "example", "--json")


def test_while_nothing_is_compiled_a_front_is_searched_in_python(tmp_path: Path) -> None:
    empty = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    first = subprocess.run(PROGRAM, env=empty, capture_output=True, text=True)
    later = subprocess.run(PROGRAM, capture_output=True, text=True)
    assert first.stderr == "prefplan: nothing is compiled yet: searching in Python for up to 5 seconds\n"
    assert not list(tmp_path.rglob("*.nbi"))
    assert _points(first.stdout) == _points(later.stdout) != []


def _points(text: str) -> list[object]:
    plans: list[object] = json.loads(text)["front"]
    return plans


def test_a_long_search_starts_again_with_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    class StartedAgainError(Exception):
        pass

    def started(program: str, arguments: list[str], environment: Mapping[str, str]) -> None:
        raise StartedAgainError(environment["NUMBA_DISABLE_JIT"], environment[start.ATTEMPT])

    monkeypatch.setattr(os, "execve", started)
    monkeypatch.setattr(start, "INTERPRETED_S", 1)
    monkeypatch.setenv(start.ATTEMPT, "1")
    with pytest.raises(StartedAgainError) as again, start.planner_at_once(quiet=True, is_program=True):
        signal.pause()
    assert again.value.args == ("0", "0")
