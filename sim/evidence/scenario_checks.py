"""Check of the scenario in a log against a given one."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator
from typing import Any

from prefplan.claims import Check
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import Scenario
from sim.evidence.log import Log, measured_costs
from sim.external.bundle import packed

MISSING = object()


def check_scenario(log: Log, scenario: Scenario) -> Check:
    """Check that a log is of a given scenario, comments and spacing aside."""
    differences = [*_differences(tomllib.loads(log.about.text), tomllib.loads(scenario.text), "")]
    costs = scenario.model.costs if isinstance(scenario.model, ManipulationModel) else None
    measured = [{" ".join(row[:3]): row[3] for row in rows} for rows in (log.about.measured, measured_costs(costs))]
    differences += _differences(measured[0], measured[1], "measured cost of ")
    files = packed(scenario.model) if isinstance(scenario.model, ManipulationModel) else {}
    differences += (f"the file {name} is another" for name in files if log.about.files.get(name) != files[name])
    if differences:
        more = f" (and {len(differences) - 1} more)" if len(differences) > 1 else ""
        return Check("scenario", False, f"the log is of another one: {differences[0]}{more}")
    return Check("scenario", True, f"the given one, with {_conditions(log)}")


def _conditions(log: Log) -> str:
    """Return what the run, not the scenario, decided, in words."""
    about = log.about
    given = {key: value for key, value in about.setting.items() if value}
    return ", ".join([f"the robot {about.robot}", *(f"{key} {value}" for key, value in sorted(given.items()))])


def _differences(said: Any, given: Any, key: str) -> Iterator[str]:
    """Yield each difference of two values read from TOML, in words."""
    if isinstance(said, dict) and isinstance(given, dict):
        for name in {**said, **given}:
            inner = f"{key}.{name}" if key and not key.endswith(" ") else f"{key}{name}"
            yield from _differences(said.get(name, MISSING), given.get(name, MISSING), inner)
    elif isinstance(said, list) and isinstance(given, list) and len(said) == len(given):
        for i, (one, other) in enumerate(zip(said, given, strict=True)):
            yield from _differences(one, other, f"{key}[{i}]")
    elif said is MISSING or given is MISSING:
        yield f"{key} is only in {'the given one' if said is MISSING else 'the log'}"
    elif said != given:
        yield f"{key} is {json.dumps(said, default=str)} in the log, {json.dumps(given, default=str)} in the given one"
