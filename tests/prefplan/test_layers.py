"""The planner is independent: it prints nothing, and loads neither simulator nor programs."""

from __future__ import annotations

import ast
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

NOT_FOR_THE_PLANNER = {"mujoco", "mink", "mediapy", "imageio_ffmpeg", "trimesh", "fast_simplification"}


def sources(package: str) -> list[Path]:
    spec = find_spec(package)
    assert spec is not None and spec.origin is not None
    return sorted(Path(spec.origin).parent.rglob("*.py"))


def test_no_file_of_the_planner_prints() -> None:
    calls = {
        (file.name, node.lineno)
        for file in sources("prefplan")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
    }
    assert calls == set()


def test_importing_the_planner_loads_neither_simulator_nor_programs(tmp_path: Path) -> None:
    unwanted = NOT_FOR_THE_PLANNER | {"sim", "experiments"}
    script = "import sys, prefplan; print(*sorted({name.split('.')[0] for name in sys.modules}))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    loaded = set(done.stdout.split())
    assert "prefplan" in loaded
    assert loaded & unwanted == set()
