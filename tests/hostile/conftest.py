"""What several tests of hostile input share."""

from __future__ import annotations

import pytest
from hostile_bench import logged_bench

from sim.evidence.log import Log


@pytest.fixture(scope="session")
def bench_log(tmp_path_factory: pytest.TempPathFactory) -> Log:
    """The log of a run whose scene is of two MJCF files."""
    return logged_bench(tmp_path_factory.mktemp("bench"))
