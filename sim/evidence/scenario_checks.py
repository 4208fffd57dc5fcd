"""Check of the scenario in a log against a given one."""

import json
import tomllib
from typing import Any

from prefplan.claims import Check
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import Scenario
from sim.evidence.log import Log, measured_costs
from sim.evidence.rebuilt import refusing
from sim.external.bundle import packed


def check_scenario(log: Log, scenario: Scenario) -> Check:
    """Check that a log is of a given scenario, comments and spacing aside."""
    about, model = log.about, scenario.model if isinstance(scenario.model, ManipulationModel) else None
    with refusing("the scenario in the log cannot be used"):
        said = _leaves(tomllib.loads(about.text))
    said |= {f"measured cost of {' '.join(pair)}": cost for *pair, cost in about.measured}
    given = _leaves(tomllib.loads(scenario.text))
    given |= {
        f"measured cost of {' '.join(pair)}": cost for *pair, cost in measured_costs(model.costs if model else None)
    }
    differences = [
        f"{key} is {_shown(said, key, 'the log')}, {_shown(given, key, 'the given one')}"
        for key in {**said, **given}
        if key not in said or key not in given or said[key] != given[key]
    ]
    files = packed(model) if model else {}
    differences += [f"the file {name} is another" for name in files if about.files.get(name) != files[name]]
    differences += [f"the file {name} is not named there" for name in about.files.keys() - files.keys()]
    if differences:
        more = f" (and {len(differences) - 1} more)" if len(differences) > 1 else ""
        return Check("scenario", False, f"the log is of another one: {differences[0]}{more}")
    conditions = [f"{key} {value}" for key, value in sorted(about.setting.items()) if value and key != "faults"]
    return Check("scenario", True, f"the given one, with {', '.join([f'the robot {about.robot}', *conditions])}")


def _leaves(value: Any, key: str = "") -> dict[str, Any]:
    """Return what a value read from TOML holds, by its key in the file."""
    if isinstance(value, dict) and (value or not key):
        inner = [_leaves(part, f"{key}.{name}" if key else name) for name, part in value.items()]
    elif isinstance(value, list) and value:
        inner = [_leaves(part, f"{key}[{i}]") for i, part in enumerate(value)]
    else:
        return {key: value}
    return {name: leaf for leaves in inner for name, leaf in leaves.items()}


def _shown(leaves: dict[str, Any], key: str, where: str) -> str:
    return f"{json.dumps(leaves[key], default=str)} in {where}" if key in leaves else f"not in {where}"
