"""`prefplan doctor`: what it finds, and that what it says mends it."""

from __future__ import annotations

import json
import platform
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import Run

from experiments.commands.machine import doctor
from experiments.doctor import diagnosis, gl_backends, mending
from experiments.doctor.diagnosis import OK, PROBLEM, WARNING, Diagnosis


def only(found: list[Diagnosis]) -> Diagnosis:
    (finding,) = found
    return finding


def test_this_machine_is_diagnosed(run: Run) -> None:
    """The suite runs here, so that planner, simulation and ffmpeg work; OpenGL may be missing."""
    result = run("doctor", "--json")
    found = {finding["name"]: finding for finding in result.json["findings"]}
    problems = {name for name, finding in found.items() if finding["status"] == PROBLEM}
    assert problems <= {"egl", "osmesa", "glfw", "cgl"}
    assert (result.status, result.json["well"]) == ((4, False) if problems else (0, True))
    assert found["simulation"]["found"].startswith("MuJoCo 3.")
    assert {"python", "packages", "planner", "ffmpeg", "meshes", "cores", "memory"} <= set(found)
    assert all(set(finding) == {"name", "status", "found", "mend"} for finding in found.values())
    assert all(finding["mend"] is None for finding in found.values() if finding["status"] == OK)


def test_people_read_a_line_for_each_and_what_mends_it(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    findings = [
        Diagnosis("tea", OK, "hot"),
        Diagnosis("milk", WARNING, "none", "fetch milk"),
        Diagnosis("cup", PROBLEM, "!"),
    ]
    monkeypatch.setattr(doctor, "CHECKS", (lambda: findings,))
    monkeypatch.setattr(doctor, "Bars", Silence)
    result = run("doctor")
    assert result.status == 4
    assert [line.split() for line in result.out.splitlines()] == [
        ["ok", "tea", "hot"],
        ["warning", "milk", "none"],
        ["mend:", "fetch", "milk"],
        ["problem", "cup", "!"],
    ]


def test_what_is_only_optional_has_status_0(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "CHECKS", (lambda: [Diagnosis("milk", WARNING, "none")],))
    monkeypatch.setattr(doctor, "Bars", Silence)
    assert run("doctor").status == 0


def test_a_machine_for_planning_alone_is_well(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "find_spec", lambda name: None)
    result = run("doctor", "--json")
    assert (result.status, result.json["well"]) == (0, True)
    assert not {"simulation", "egl", "ffmpeg", "meshes"} & {finding["name"] for finding in result.json["findings"]}


class Silence:
    """No bars."""

    def __enter__(self) -> Callable[..., None]:
        return lambda *what: None

    def __exit__(self, *what: object) -> None:
        return None


def test_missing_packages_are_named_with_the_command_that_installs_them(monkeypatch: pytest.MonkeyPatch) -> None:
    needs = ["numpy>=2", "numba>=99", "no-such-package", 'absent-here>=1; extra == "view"', 'odd; python_version < "3"']
    monkeypatch.setattr(diagnosis, "requires", lambda name: needs)
    monkeypatch.setattr(diagnosis, "_extras", lambda: {"view"})
    packages = only(diagnosis.packages())
    assert packages.status == PROBLEM
    assert "numba is of version" in packages.found and "no-such-package is missing" in packages.found
    assert packages.mend == f"{sys.executable} -m pip install 'numba>=99' no-such-package"
    view = only(diagnosis.extras())
    assert (view.name, view.status) == ("view", WARNING)
    assert view.mend == f"{sys.executable} -m pip install 'absent-here>=1'"


def test_an_uncompiled_planner_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("prefplan.warm_up.is_compiled", lambda: False)
    planner = only(diagnosis.planner())
    assert (planner.status, planner.mend) == (WARNING, f"{sys.executable} -m prefplan.warm_up")


def test_ffmpeg_is_really_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    assert only(diagnosis.ffmpeg()).status == OK
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "/bin/false")
    monkeypatch.setattr("imageio_ffmpeg.get_ffmpeg_exe", lambda: "/bin/false")
    broken = only(diagnosis.ffmpeg())
    assert (broken.status, broken.mend) == (PROBLEM, "unset IMAGEIO_FFMPEG_EXE")


def test_missing_meshes_are_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sim.robots.meshes.mesh_folder", lambda: None)
    found = only(diagnosis.meshes())
    assert found.status == WARNING and found.mend is not None and found.mend.endswith("gymnasium-robotics")


def test_a_child_has_a_time_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnosis, "TIME_LIMIT", 0.2)
    sleeper = [sys.executable, "-c", "import time; time.sleep(60)"]
    assert diagnosis.in_a_child(sleeper) == ("no answer within 0 s", False)


@pytest.mark.parametrize(
    ("code", "said", "works"),
    [
        ("print(1); print(2)", "2", True),
        ("raise SystemExit('no')", "no", False),
        ("import os; os.abort()", "ended with status -6", False),
    ],
)
def test_what_a_child_says_last_counts(code: str, said: str, works: bool) -> None:
    assert diagnosis.in_a_child([sys.executable, "-c", code]) == (said, works)


def test_a_backend_that_does_not_exist_does_not_render() -> None:
    text, works = gl_backends.try_backend("nonsense")
    assert not works and "nonsense" in text


@pytest.mark.parametrize(
    ("chosen", "working", "expected"),
    [
        (None, {"egl"}, {"egl": (OK, None), "osmesa": (WARNING, "install osmesa")}),
        (None, {"osmesa"}, {"egl": (PROBLEM, "install egl"), "osmesa": (OK, None)}),
        ("osmesa", {"egl"}, {"egl": (OK, None), "osmesa": (PROBLEM, "export MUJOCO_GL=egl")}),
        ("osmesa", set(), {"egl": (WARNING, "install egl"), "osmesa": (PROBLEM, "install osmesa")}),
    ],
)
def test_only_the_backend_in_use_is_needed(
    chosen: str | None,
    working: set[str],
    expected: dict[str, tuple[str, str | None]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL"):
        monkeypatch.delenv(name, raising=False)
    if chosen:
        monkeypatch.setenv("MUJOCO_GL", chosen)
    monkeypatch.setattr(gl_backends, "try_backend", lambda name: ("text", name in working))
    monkeypatch.setattr(gl_backends, "installs", lambda name: f"install {name}")
    assert {one.name: (one.status, one.mend) for one in gl_backends.rendering()} == expected


def test_with_a_display_films_are_made_with_glfw(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setenv("DISPLAY", ":0")
    assert gl_backends.in_use() == "glfw"


@pytest.mark.parametrize(
    ("release", "what", "command"),
    [
        ({"ID": "debian", "VERSION_ID": "13"}, "egl", "sudo apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri"),
        ({"ID": "ubuntu", "ID_LIKE": "debian"}, "browser", "sudo snap install chromium"),
        ({"ID": "fedora", "VERSION_ID": "42"}, "egl", "sudo dnf install mesa-libEGL mesa-dri-drivers"),
        ({"ID": "debian", "VERSION_ID": "12"}, "osmesa", "sudo apt-get install libosmesa6"),
        ({"ID": "arch"}, "egl", None),
        ({"ID": "fedora"}, "osmesa", None),
    ],
)
def test_a_command_is_named_where_it_is_known(
    release: dict[str, str], what: str, command: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(platform, "freedesktop_os_release", lambda: release)
    assert mending.installs(what) == command


def test_a_missing_library_is_a_sentence_even_before_the_program_starts(tmp_path: Path) -> None:
    code = "import sys; sys.modules['rich'] = None; from experiments.program import main; sys.exit(main())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (4, "")
    assert len(done.stderr.splitlines()) == 1 and "-m pip install rich" in done.stderr


def test_json_is_one_object(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "CHECKS", (lambda: [Diagnosis("tea", OK, "hot")],))
    assert json.loads(run("doctor", "--json").out) == {
        "well": True,
        "findings": [{"name": "tea", "status": "ok", "found": "hot", "mend": None}],
    }
