"""Models and problems that several tests of the planner share."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from prefplan import Location, ManipulationModel, Object


@pytest.fixture(scope="session")
def case_study_3_model() -> ManipulationModel:
    """The paper's Case Study 3: blue on the left base, pink on top, green on the right base."""
    return ManipulationModel(
        start="home",
        costs={"transit": 3, "grasp": 1, "transport": 5, "release": 1},
        locations=(
            Location("top", on=("left", "right")),
            Location("left", at=(0.50, 0.03)),
            Location("right", at=(0.50, -0.03)),
            Location("san", at=(0.45, 0.30), marks="sanitized"),
            Location("bin1", at=(0.38, -0.30), capacity=2),
            Location("bin2", at=(0.56, -0.30), capacity=2),
            Location("table", at=(0.62, 0.20)),
        ),
        objects=(Object("blue", "left"), Object("pink", "top"), Object("green", "right")),
    )


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Where a test may write a scenario."""
    return tmp_path / "case.toml"


@pytest.fixture
def rng() -> random.Random:
    return random.Random(7)
