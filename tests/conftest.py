"""Fixtures for all tests."""

from __future__ import annotations

import os
import signal

import pytest
from scenario_texts import shipped

from prefplan import ManipulationModel


def pytest_configure() -> None:
    # A shell that starts the tests in the background may ignore Ctrl-C, and every program that they start inherits it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # Each program that the tests start would compile all sources again.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


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
    from sim.errors import RenderingError
    from sim.rendering.renderer import check_rendering

    try:
        check_rendering()
    except RenderingError as error:
        pytest.skip(str(error))
