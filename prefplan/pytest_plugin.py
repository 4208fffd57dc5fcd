"""Fixtures for pytest, available wherever prefplan is installed: regression tests of plans and their execution.

Nothing but pytest is loaded before a test uses a fixture. The assertions are in `experiments.regression`, which is
imported by name: the planner must not depend on programs, and the tested project may have packages of the same names.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from prefplan.front import Front, Plan

FOLDER = Path(__file__).parents[1]
"""Folder in which the packages are installed."""

PACKAGES = ("assets", "experiments", "sim")
"""Packages of prefplan whose names other projects may use, too."""


@pytest.fixture(name="assert_front")
def _assert_front() -> Callable[..., Front]:
    """assert_front(scenario, points): the Pareto front has exactly these points (cost, preference)."""
    return _assertion("assert_front")


@pytest.fixture(name="assert_plan")
def _assert_plan() -> Callable[..., Plan]:
    """assert_plan(scenario, actions, plan="cost"): the chosen plan has exactly these actions."""
    return _assertion("assert_plan")


@pytest.fixture(name="assert_completed")
def _assert_completed() -> Callable[..., Any]:
    """assert_completed(scenario, plan="cost", seed=1): the simulated arm completes the plan."""
    return _assertion("assert_completed")


def _assertion(name: str) -> Callable[..., Any]:
    def check(*arguments: Any, **options: Any) -> Any:
        __tracebackhide__ = True
        with own_packages():
            return getattr(import_module("experiments.regression.assertions"), name)(*arguments, **options)

    return check


_own: dict[str, ModuleType] = {}
"""Modules of prefplan's packages, kept here while other packages of the same names are in use."""


@contextmanager
def own_packages() -> Iterator[None]:
    """Make `assets`, `experiments` and `sim` refer to prefplan's packages, not to those of the tested project."""
    if all(map(_is_own, PACKAGES)):
        yield
        return
    others, path = _taken_out(), sys.path[:]
    sys.modules.update(_own)
    sys.path.insert(0, str(FOLDER))
    try:
        yield
    finally:
        _own.update(_taken_out())
        sys.modules.update(others)
        sys.path[:] = path


def _is_own(name: str) -> bool:
    spec = getattr(sys.modules[name], "__spec__", None) if name in sys.modules else find_spec(name)
    return spec is not None and spec.origin == str(FOLDER / name / "__init__.py")


def _taken_out() -> dict[str, ModuleType]:
    """Unload the modules of `PACKAGES`, and return them."""
    loaded = [name for name in sys.modules if name.partition(".")[0] in PACKAGES]
    return {name: sys.modules.pop(name) for name in loaded}
