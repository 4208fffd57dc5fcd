"""Fixtures for pytest, there for everybody who has prefplan installed: outcomes of plans as regression tests.

Nothing but pytest is loaded before a test asks for a fixture.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from experiments.runs.outcome import Outcome
    from prefplan.front import Front, Plan


@pytest.fixture(name="assert_front")
def _assert_front() -> Callable[..., Front]:
    """assert_front(scenario, points): its Pareto front has exactly these points (cost, preference)."""
    from experiments.regression.assertions import assert_front

    return assert_front


@pytest.fixture(name="assert_plan")
def _assert_plan() -> Callable[..., Plan]:
    """assert_plan(scenario, actions, plan="cost"): one of its plans takes exactly these actions."""
    from experiments.regression.assertions import assert_plan

    return assert_plan


@pytest.fixture(name="assert_completed")
def _assert_completed() -> Callable[..., Outcome]:
    """assert_completed(scenario, plan="cost", seed=1): the simulated arm carries a plan out."""
    from experiments.regression.assertions import assert_completed

    return assert_completed
