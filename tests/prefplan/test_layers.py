"""The planner stands on its own: an arrow between packages may only point down."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

PACKAGES_ABOVE = {"prefplan": {"sim", "experiments"}, "sim": {"experiments"}}
NOT_FOR_THE_PLANNER = {"mujoco", "mink", "mediapy", "imageio_ffmpeg", "trimesh", "fast_simplification"}


def sources(package: str) -> list[Path]:
    spec = find_spec(package)
    assert spec is not None and spec.origin is not None
    return sorted(Path(spec.origin).parent.rglob("*.py"))


def imported(source: Path) -> Iterator[str]:
    """Yield the top-level package of every import in a file, wherever it stands."""
    for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            yield node.module.split(".")[0]


@pytest.mark.parametrize("package", PACKAGES_ABOVE)
def test_no_file_imports_a_package_above_its_own(package: str) -> None:
    files = sources(package)
    assert files
    assert {
        f"{file.name} imports {name}" for file in files for name in imported(file) if name in PACKAGES_ABOVE[package]
    } == set()


def test_no_file_of_the_planner_imports_the_simulator() -> None:
    found = {name for file in sources("prefplan") for name in imported(file)}
    assert found & NOT_FOR_THE_PLANNER == set()


def test_no_file_of_the_planner_prints() -> None:
    calls = {
        (file.name, node.lineno)
        for file in sources("prefplan")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
    }
    assert calls == set()


def test_importing_the_planner_loads_neither_simulator_nor_programs(tmp_path: Path) -> None:
    unwanted = NOT_FOR_THE_PLANNER | PACKAGES_ABOVE["prefplan"]
    script = "import sys, prefplan; print(*sorted({name.split('.')[0] for name in sys.modules}))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    loaded = set(done.stdout.split())
    assert "prefplan" in loaded
    assert loaded & unwanted == set()
