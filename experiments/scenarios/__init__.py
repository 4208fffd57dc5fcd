"""Scenario files that ship with prefplan, found by name."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from prefplan.errors import ScenarioError, choices
from prefplan.scenario.decode import Scenario, load

FOLDER = Path(str(files(__package__)))


def names() -> list[str]:
    """Return the names of the scenarios that ship."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def find(scenario: str, *, measured: bool = True) -> Scenario:
    """Read a scenario by the name of one that ships, or by a path.

    Args:
        scenario: its name or path.
        measured: as in `prefplan.load`.

    Raises:
        ScenarioError: there is no such scenario, or it has a mistake.
    """
    if scenario in names():
        return load(FOLDER / f"{scenario}.toml", measured=measured)
    if Path(scenario).suffix or Path(scenario).exists() or len(Path(scenario).parts) > 1:
        return load(scenario, measured=measured)
    raise ScenarioError(f"no scenario named {scenario!r} {choices(scenario, names())}; a path ends in .toml")
