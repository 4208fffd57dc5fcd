"""What every test may count on."""

from __future__ import annotations

import signal

import pytest

from prefplan.models.manipulation.model import Location, ManipulationModel, Object


def pytest_configure() -> None:
    # Whoever starts the tests in the background may have Ctrl-C ignored, and so would the programs they interrupt.
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def arch_model() -> ManipulationModel:
    """Case Study 3: blue and green carry pink; a sanitizer, two bins and a spare spot."""
    return ManipulationModel(
        start="home",
        costs={"transit": 3, "grasp": 1, "transport": 5, "release": 1},
        locations=(
            Location("top", on=("left", "right")),
            Location("left", at=(0.50, 0.03)),
            Location("right", at=(0.50, -0.03)),
            Location("san", at=(0.45, 0.30), marks="sanitized"),
            Location("bin1", at=(0.38, -0.30), capacity=2, kind="bin"),
            Location("bin2", at=(0.56, -0.30), capacity=2, kind="bin"),
            Location("table", at=(0.62, 0.20)),
        ),
        objects=(
            Object("blue", "left", rgba=(0.10, 0.30, 0.90, 1)),
            Object("pink", "top", rgba=(0.95, 0.40, 0.65, 1)),
            Object("green", "right", rgba=(0.15, 0.65, 0.30, 1)),
        ),
    )


@pytest.fixture(scope="session")
def gl() -> None:
    """Skip where nothing can be rendered."""
    # MuJoCo takes a second to load, which tests of the planner alone are spared.
    from sim.errors import RenderingError
    from sim.rendering.renderer import check_rendering

    try:
        check_rendering()
    except RenderingError as error:
        pytest.skip(str(error))
