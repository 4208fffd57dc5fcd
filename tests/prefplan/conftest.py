"""Models and problems that several tests of the planner share."""

from __future__ import annotations

import random
from pathlib import Path

import pytest


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Path where a test may write a scenario."""
    return tmp_path / "case.toml"


@pytest.fixture
def rng() -> random.Random:
    return random.Random(7)
