"""Scenario files that ship with prefplan, found by name."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from prefplan.errors import ScenarioError, choices
from prefplan.scenario.decode import Scenario, is_scenario, load

FOLDER = Path(str(files(__package__)))


def names() -> list[str]:
    """Return the names of the scenarios that ship."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def find(scenario: str, *, measured: bool = True) -> Scenario:
    """Load a scenario by the name of one that ships, or by a path, whose `.toml` may be left out.

    Names of scenarios that ship take precedence over files; `measured` is as in `prefplan.load`.

    Raises:
        ScenarioError: there is no such scenario, or it has a mistake.
    """
    if scenario in names():
        return load(FOLDER / f"{scenario}.toml", measured=measured)
    path, named = Path(scenario), Path(f"{scenario}.toml")
    if named.is_file() and not path.is_file():
        return load(named, measured=measured)
    if path.suffix or path.exists() or len(path.parts) > 1:
        return load(path, measured=measured)
    known = sorted({*names(), *(file.stem for file in Path().glob("*.toml") if is_scenario(file))})
    raise ScenarioError(f"no scenario named {scenario!r} ships or is in this folder {choices(scenario, known)}")
