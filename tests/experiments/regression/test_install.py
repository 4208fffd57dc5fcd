"""prefplan installed, and used in a folder whose packages have the same names as some of ours."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest
from scenario_texts import PLACES_NEARBY, cup_scenario

ROOT = Path(__file__).parents[3]

COMMON = ("sim", "experiments", "assets")
"""Packages of ours that others may have, too."""

UNRELATED = """
import sys

import assets, experiments, sim
from sim import clock

LOADED = set(sys.modules)


def test_these_are_mine_and_nothing_else_is_loaded():
    assert [one.OWNER for one in (assets, experiments, sim, clock)] == ["me"] * 4
    assert not {"numba", "networkx", "pydantic"} & LOADED
"""

WITH_FIXTURES = """
import sys

import experiments, sim
import prefplan as pp

OTHERS = experiments, sim


def test_front(assert_front):
    path = sys.path[:]
    assert isinstance(assert_front("example", [(6, 4), (9, 3)]), pp.Front)
    assert sys.path == path


def test_a_front_that_differs(assert_front):
    assert_front("example", [(6, 4)])


def test_completed(assert_completed):
    assert assert_completed("cup.toml").run.completed
    import assets
    from sim import clock
    assert assets.OWNER == clock.OWNER == "me" and (sys.modules["experiments"], sys.modules["sim"]) == OTHERS
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The programs of an environment that has prefplan from its wheel, and what it needs from this environment."""
    folder = tmp_path_factory.mktemp("install")
    for name in ("prefplan", *COMMON):
        shutil.copytree(ROOT / name, folder / "source" / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder / "source")
    venv.create(folder / "venv", symlinks=True)
    programs = folder / "venv" / "bin"
    (packages,) = (folder / "venv").glob("lib/python*/site-packages")
    # Folders in a .pth file are searched last, and their own .pth files, such as that of an editable prefplan, are not
    # looked at.
    (packages / "needs.pth").write_text("\n".join({sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}))
    pip = [sys.executable, "-m", "pip", f"--python={programs / 'python'}", "--disable-pip-version-check"]
    options = ["--no-build-isolation", "--no-deps", "--no-index", "--ignore-installed", "--no-compile"]
    done = subprocess.run([*pip, "install", *options, str(folder / "source")], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    _bring_compiled(packages)
    return programs


def _bring_compiled(packages: Path) -> None:
    """Spare the tests a minute of compiling: bytecode and machine code fit a source of the same time and size."""
    for name in ("prefplan", *COMMON):
        for source in (ROOT / name).rglob("*"):
            copy = packages / source.relative_to(ROOT)
            if source.suffix in (".pyc", ".nbi", ".nbc", ".sha256"):
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(source, copy)
            elif source.suffix == ".py":
                shutil.copystat(source, copy)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A user's folder, with packages of theirs."""
    for name in COMMON:
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text('OWNER = "me"\n')
    (tmp_path / "sim" / "clock.py").write_text('OWNER = "me"\n')
    (tmp_path / "cup.toml").write_text(cup_scenario(places=PLACES_NEARBY))
    return tmp_path


def call(*command: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Call a program as a user does, without this checkout on the path."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "PYTEST"))}
    return subprocess.run(
        list(map(str, command)), cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )


@pytest.mark.slow
def test_the_fixtures_work_and_tests_of_others_are_left_alone(installed: Path, folder: Path) -> None:
    (folder / "test_mine.py").write_text(UNRELATED)  # is imported first, before anything is loaded
    (folder / "test_plans.py").write_text(WITH_FIXTURES)
    done = call(installed / "python", "-m", "pytest", "-q", "-p", "no:cacheprovider", cwd=folder)
    assert "1 failed, 3 passed" in done.stdout, done.stdout + done.stderr
    assert "AssertionError: example: the front is not the expected one" in done.stdout
    assert "pytest_plugin.py" not in done.stdout  # the traceback ends in the reader's own test


@pytest.mark.slow
def test_the_program_works_beside_packages_of_the_same_names(installed: Path, folder: Path) -> None:
    assert call(installed / "prefplan", "--version", cwd=folder).stdout.startswith("prefplan ")
    # A sweep starts processes, which must find our packages, too; with `-m`, this folder is the first to be searched.
    done = call(installed / "python", "-m", "prefplan", "sweep", "cup.toml", "--rollouts", "1", cwd=folder)
    assert done.returncode == 0 and "1 of 1 rollouts" in done.stdout, done.stdout + done.stderr


def test_what_the_set_up_looks_for_is_there(gl: None) -> None:
    """It hides errors of this line, and installs a renderer if there are any."""
    root = Path(__file__).parents[3]
    (check,) = re.findall(r"-c '(from sim.*)' 2>/dev/null", (root / ".ci" / "setup").read_text())
    subprocess.run([sys.executable, "-c", check], cwd=root, check=True)
