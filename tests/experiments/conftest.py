"""Fixtures for tests of several commands."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest
from command_line import Run, call, main
from scenario_texts import CUP, DETOUR, shipped, shipped_front

from prefplan import Front, Scenario


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Run:
    """Return a function that runs the program from an empty folder, on a wide terminal."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")

    return partial(call, capsys)


@pytest.fixture(scope="session")
def example() -> Scenario:
    """The paper's example: three tasks on a small grid."""
    return shipped("example")


@pytest.fixture(scope="session")
def arch() -> Scenario:
    """Case Study 3."""
    return shipped("case_study_3")


@pytest.fixture(scope="session")
def arch_front() -> Front:
    return shipped_front("case_study_3")


@pytest.fixture
def detour(run: Run, tmp_path: Path) -> Path:
    """A scenario in the current folder: bread on the way, or money first at a higher cost."""
    file = tmp_path / "detour.toml"
    file.write_text(DETOUR)
    return file


@pytest.fixture(scope="session")
def run_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of a run, with only its certificate beside it."""
    folder = tmp_path_factory.mktemp("cup")
    (folder / "cup.toml").write_text(CUP)
    how = ["--no-video", "--seed", "3", "--out", str(folder)]
    assert main(["run", str(folder / "cup.toml"), *how]) == 0
    (folder / "cup.toml").unlink()
    (folder / "cost.json").unlink()
    return folder / "cost.npz"
