"""Fixtures for all tests."""

from __future__ import annotations

import atexit
import gc
import os
import shutil
import signal
import sys
from collections.abc import Iterator, Sequence
from typing import Any

import cloudpickle
import pytest
from scenario_texts import shipped

from prefplan import ManipulationModel


def pytest_configure() -> None:
    # A shell that starts the tests in the background may ignore Ctrl-C, and every program that they start inherits it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # So many objects live as long as the tests that looking through them all takes a twentieth of the time.
    gc.set_threshold(10_000)
    # Each process of the tests, and each program that they start, would compile all sources again.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False


def pytest_collection_finish() -> None:
    gc.freeze()  # nor need the modules and the tests be looked through
    atexit.register(gc.unfreeze)  # libraries complain of objects that outlive the process


@pytest.fixture(scope="session", autouse=True)
def few_pixels_per_m() -> Iterator[None]:
    """Print tables with few pixels: the picture is a quarter of the work for a scene, and every copy has it, too."""
    tabletop = sys.modules.get("sim.world.tabletop")  # it takes a second to load, and the planner needs none
    with pytest.MonkeyPatch.context() as patch:
        if tabletop:
            patch.setattr(tabletop, "PIXELS_PER_M", 300)
        yield


@pytest.fixture(scope="session")
def arch_model() -> ManipulationModel:
    """Case Study 3: blue and green carry pink; a sanitizer, two bins and a spare spot."""
    model = shipped("case_study_3").model
    assert isinstance(model, ManipulationModel)
    return model


@pytest.fixture(scope="session")
def gl() -> None:
    """Skip where nothing can be rendered."""
    # MuJoCo takes a second to load; tests of the planner alone do without.
    from sim.rendering.opengl import probe

    try:
        probe()
    except Exception as error:
        pytest.skip(f"nothing can be rendered: {error}")


@pytest.fixture
def rendered_here(gl: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Render videos in this process: those that render for the program take seconds to load the simulation."""
    from sim.rendering import video

    def one_by_one(jobs: Sequence[Any], workers: int) -> Iterator[int]:
        return (render(*arguments, **options) for render, arguments, options in map(handed_over, jobs))

    def handed_over(job: Any) -> Any:
        return cloudpickle.loads(cloudpickle.dumps(job))

    monkeypatch.setattr(video, "_in_processes", one_by_one)
    monkeypatch.setenv("LP_NUM_THREADS", "0")  # as the renderer does for good


@pytest.fixture(scope="session")
def chromium() -> tuple[str, str]:
    """Paths of Chromium and its driver; without them skip, or fail if PREFPLAN_NEEDS_CHROMIUM is set."""
    found, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if found and driver:
        return found, driver
    missing = "no Chromium here: apt-get install chromium chromium-driver"
    if os.environ.get("PREFPLAN_NEEDS_CHROMIUM"):
        pytest.fail(missing)
    pytest.skip(missing)
