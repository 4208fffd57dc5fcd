"""The first search after an installation, when no kernel is compiled."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

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
