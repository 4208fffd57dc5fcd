"""Fixtures for all tests."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Iterator

import pytest
from scenario_texts import shipped

from prefplan import ManipulationModel


def pytest_configure() -> None:
    # A shell that starts the tests in the background may ignore Ctrl-C, and every program that they start inherits it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # So many objects live as long as the tests that looking through them all takes a twentieth of the time.
    gc.set_threshold(10_000)
    # Each program that the tests start would compile all sources again.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


@pytest.fixture(scope="session", autouse=True)
def usual_pixels_per_m() -> Iterator[int]:
    """Print tables with few pixels: the picture is a quarter of the work for a scene, and every copy has it, too.

    Returns how many there are in other processes, which draw the same picture again where they render.
    """
    tabletop = sys.modules.get("sim.world.tabletop")  # it takes a second to load, and the planner needs none
    with pytest.MonkeyPatch.context() as patch:
        usual = tabletop.PIXELS_PER_M if tabletop else 0
        if tabletop:
            patch.setattr(tabletop, "PIXELS_PER_M", 300)
        yield usual


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
    from sim.rendering.renderer import probe

    try:
        probe()
    except Exception as error:
        pytest.skip(f"nothing can be rendered: {error}")
