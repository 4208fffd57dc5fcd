"""What tests of several commands share."""

from __future__ import annotations

import os
import shutil
from functools import partial
from pathlib import Path

import pytest
from command_line import Run, call
from scenario_texts import DETOUR, shipped, shipped_front

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
def chromium() -> tuple[str, str]:
    """Where Chromium and its driver are; without them skip, or fail where PREFPLAN_NEEDS_CHROMIUM says so."""
    found, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if found and driver:
        return found, driver
    missing = "no Chromium here: apt-get install chromium chromium-driver"
    if os.environ.get("PREFPLAN_NEEDS_CHROMIUM"):
        pytest.fail(missing)
    pytest.skip(missing)
