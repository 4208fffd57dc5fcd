"""`prefplan doctor`: what it finds, and that the commands that it names repair it."""

from __future__ import annotations

import subprocess
import sys

import pytest
from command_line import Run

from experiments.checks import diagnosis
from experiments.checks.diagnosis import OK, PROBLEM, WARNING, Diagnosis
from sim.errors import RenderingError


def test_this_machine_is_diagnosed(run: Run) -> None:
    """The suite runs here, so that planner, simulation and ffmpeg work; OpenGL may be missing."""
    result = run("doctor", "--json")
    found = {finding["name"]: finding for finding in result.json["findings"]}
    problems = {name for name, finding in found.items() if finding["status"] == PROBLEM}
    assert problems <= {"rendering"}
    assert (result.status, result.json["well"]) == ((4, False) if problems else (0, True))
    assert found["simulation"]["found"].startswith("MuJoCo 3.")
    names = ["python", "planner", "simulation", "rendering", "ffmpeg", "meshes"]
    assert list(found) == names
    assert all(set(finding) == {"name", "status", "found", "fix"} for finding in found.values())
    assert all(finding["fix"] is None for finding in found.values() if finding["status"] == OK)


@pytest.mark.parametrize(
    ("checks", "status", "lines"),
    [
        (
            [Diagnosis("tea", OK, "hot"), Diagnosis("cup", PROBLEM, "!", "buy one")],
            4,
            [["ok", "tea", "hot"], ["problem", "cup", "!"], ["fix:", "buy", "one"]],
        ),
        ([Diagnosis("milk", WARNING, "none")], 0, [["warning", "milk", "none"]]),
    ],
)
def test_people_read_a_line_for_each_check_and_what_fixes_it(
    checks: list[Diagnosis], status: int, lines: list[list[str]], run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def check() -> Diagnosis:
        return remaining.pop(0)

    remaining = list(checks)
    monkeypatch.setattr(diagnosis, "CHECKS", (check,) * len(checks))
    result = run("doctor")
    assert result.status == status
    assert [line.split() for line in result.out.splitlines()] == lines


def test_a_machine_for_planning_alone_is_well(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnosis, "has_simulation", lambda: False)
    result = run("doctor", "--json")
    assert (result.status, result.json["well"]) == (0, True)
    last = result.json["findings"][-1]
    assert (last["name"], last["status"], last["fix"]) == ("simulation", WARNING, "pip install '.[sim]'")


def test_an_uncompiled_planner_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("prefplan.warm_up.is_compiled", lambda: False)
    planner = diagnosis.planner()
    assert (planner.status, planner.fix) == (WARNING, f"{sys.executable} -m prefplan.warm_up")


def test_ffmpeg_is_really_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    assert diagnosis.ffmpeg().status == OK
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "/bin/false")
    monkeypatch.setattr("imageio_ffmpeg.get_ffmpeg_exe", lambda: "/bin/false")
    broken = diagnosis.ffmpeg()
    assert (broken.status, broken.fix) == (PROBLEM, "unset IMAGEIO_FFMPEG_EXE")


def test_missing_meshes_are_a_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    found = diagnosis.meshes()
    assert found.status == PROBLEM and found.fix is not None and found.fix.endswith("gymnasium-robotics")


@pytest.mark.parametrize(("chosen", "fix"), [("", diagnosis.INSTALL_GL), ("nonsense", "unset MUJOCO_GL")])
def test_a_machine_that_cannot_render_is_told_why(chosen: str, fix: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse() -> None:
        raise RenderingError("no OpenGL here (no display); install one")

    monkeypatch.setenv("MUJOCO_GL", chosen)
    monkeypatch.setattr("sim.rendering.opengl.check_rendering", refuse)
    assert diagnosis.rendering() == Diagnosis("rendering", PROBLEM, "no OpenGL here (no display)", fix)


def test_a_missing_library_is_a_sentence_even_before_the_program_starts() -> None:
    code = "import sys; sys.modules['rich'] = None; from experiments.program import main; sys.exit(main())"
    done = subprocess.run([sys.executable, "-c", code, "list"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (4, "")
    assert len(done.stderr.splitlines()) == 1 and "-m pip install rich" in done.stderr
