"""The file of measurements of a scenario: the time, travel and energy of each action in simulation."""

import dataclasses
import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path
from typing import Any

from prefplan.errors import ModelError, prefixed
from prefplan.exact_costs import Number
from prefplan.limits import bounded
from prefplan.models.costs import Cost
from prefplan.models.manipulation.action_costs import QUANTITIES, MeasuredCosts, Pair
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.slots import hand_poses
from prefplan.models.manipulation.surroundings import RobotSetup

IRRELEVANT = frozenset({"rgba", "folder"})
"""Attributes of parts of the model that do not affect measurements."""

DECIMALS = 3
"""Decimal places of quantities in the file."""

MOST_BYTES = 20_000_000
"""Greatest size of the file, which is read in a second; each action takes 150 bytes."""

FORMAT = 3
"""Version of the format: since 2, hand poses are over slots where a location has several; since 3, the file has
`failed` and `interrupted`."""

ENDS = "action", "from", "to"
"""Keys of a pair in the file."""


@dataclass(frozen=True)
class Measurement:
    """The mean measured quantities of one kind of action between two poses of the hand.

    Attributes:
        pair: the kind, and the hand's poses before and after it.
        quantities: each of `QUANTITIES`, in its unit.
        samples: number of simulations in the mean.
    """

    pair: Pair
    quantities: Mapping[str, Number]
    samples: int


@dataclass(frozen=True)
class Measurements:
    """The contents of a file of measurements.

    Attributes:
        actions: the measurements of all actions.
        sources: digest of the simulation's source code; a measurement is continued only with the same code.
        files: SHA-256 of each file that the scene was built from, by its path relative to the scenario's folder.
        failed: why other actions could not be measured.
        interrupted: whether the measurement ended before all actions were tried.
    """

    actions: tuple[Measurement, ...]
    sources: str
    files: Mapping[str, str] = field(default_factory=dict)
    failed: Mapping[Pair, str] = field(default_factory=dict)
    interrupted: bool = False


def measurements_file(scenario: Path) -> Path:
    """Return the path of a scenario's measurements, in the scenario's folder."""
    return scenario.with_name(f"{scenario.stem}.measured.json")


def geometry(model: ManipulationModel) -> str:
    """Return a digest of the locations, the objects, the start, the robot and what stands around it."""
    parts: dict[str, Any] = {
        "robot": model.robot_setup.source,
        "start": model.start,
        "locations": [_plain(place) for place in model.locations],
        "objects": [_plain(obj) for obj in model.objects],
        "fixtures": [_plain(fixture) for fixture in model.fixtures],
        "setup": _plain(model.robot) if isinstance(model.robot, RobotSetup) else {},
        "scene": model.scene,
    }
    given = {name: part for name, part in parts.items() if part or name in ("locations", "objects")}
    return hashlib.sha256(json.dumps(given, sort_keys=True, default=dataclasses.asdict).encode()).hexdigest()


def to_json(model: ManipulationModel, measurements: Measurements) -> dict[str, Any]:
    """Return the contents of a file of measurements, in the order of the model's kinds and poses of the hand."""
    hands = hand_poses({place.name: place.capacity for place in model.locations}, model.start)

    def rank(pair: Pair) -> list[int]:
        return [model.kinds.index(pair[0]), *map(hands.index, pair[1:])]

    return {
        "format": FORMAT,
        "robot": model.robot_setup.source,
        "geometry": geometry(model),
        "files": dict(measurements.files),
        "sources": measurements.sources,
        "interrupted": measurements.interrupted,
        "actions": [
            dict(zip(ENDS, done.pair, strict=True))
            | {name: round(float(done.quantities[name]), DECIMALS) for name in QUANTITIES}
            | {"samples": done.samples}
            for done in sorted(measurements.actions, key=lambda done: rank(done.pair))
        ],
        "failed": [
            dict(zip(ENDS, pair, strict=True)) | {"reason": measurements.failed[pair]}
            for pair in sorted(measurements.failed, key=rank)
        ],
    }


def read_measurements(path: Path, model: ManipulationModel) -> Measurements:
    """Read the measurements of a model.

    Raises:
        ModelError: there is no such file, it cannot be read, has another format, or was measured with another
            `geometry` or other files; the message says how to make it.
    """
    remedy = f"`prefplan measure` with this scenario makes {path.name}"
    try:
        data = json.loads(bounded(path, MOST_BYTES).read_text(encoding="utf-8"), parse_float=Decimal)
        # Files of format 1 lack the key `format`.
        if "actions" in data and data.get("format", 1) in range(1, FORMAT):
            raise ModelError(f"the measurements were made by an older version of prefplan; {remedy} again")
        if data["format"] != FORMAT:
            raise ValueError(data["format"])
        made_with, sources, files = (data["geometry"], data["robot"]), str(data["sources"]), dict(data.get("files", {}))
        actions = tuple(map(_measurement, data["actions"]))
        failed = {_pair(entry): str(entry["reason"]) for entry in data["failed"]}
        interrupted = data["interrupted"] is not False
        if len({*(one.pair for one in actions), *failed}) < len(actions) + len(failed):
            raise ValueError("an action is there twice")
    except FileNotFoundError:
        raise ModelError(f"nothing was measured yet; {remedy}") from None
    except (AttributeError, KeyError, OSError, RecursionError, TypeError, ValueError):
        raise ModelError(f"the file of measurements cannot be read or is damaged; {remedy} (delete it first)") from None
    if made_with != (geometry(model), model.robot_setup.source):
        raise ModelError(f"the measurements were made with other locations, objects or surroundings; {remedy}")
    for name in sorted({*files, *map(os.path.normpath, model.files)}):
        if files.get(name) != _sha256(model.folder / name):
            raise ModelError(f"the measurements were made with another {name}; {remedy}")
    return Measurements(actions, sources, files, failed, interrupted)


def with_measured_costs(model: ManipulationModel, scenario: Path) -> ManipulationModel:
    """Return a model with the measured costs from the file beside its scenario, or as it is without `MeasuredCosts`.

    Raises:
        ModelError: as in `read_measurements`, or the measurement was interrupted; the message starts with the key.
    """
    if not isinstance(model.costs, MeasuredCosts):
        return model
    with prefixed("costs.measured: ", ModelError):
        file = measurements_file(scenario)
        done = read_measurements(file, model)
        if done.interrupted:
            raise ModelError("the measurement was interrupted; `prefplan measure` with this scenario continues it")
    wanted = model.costs.measured
    entries: dict[Pair, Cost] = {
        one.pair: one.quantities[wanted] if isinstance(wanted, str) else {name: one.quantities[name] for name in wanted}
        for one in done.actions
    }
    return dataclasses.replace(model, costs=MeasuredCosts(wanted, entries, done.failed))


def _measurement(entry: Mapping[str, Any]) -> Measurement:
    quantities = {name: entry[name] for name in QUANTITIES}
    if not all(isinstance(value, (int, Decimal)) for value in quantities.values()):
        raise ValueError(f"not numbers: {entry}")
    return Measurement(_pair(entry), quantities, int(entry["samples"]))


def _pair(entry: Mapping[str, Any]) -> Pair:
    action, before, after = (str(entry[key]) for key in ENDS)
    return action, before, after


def _sha256(path: Path) -> str:
    """Return the SHA-256 of a file; empty if it cannot be read."""
    try:
        return hashlib.sha256(bounded(path).read_bytes()).hexdigest()
    except (OSError, ValueError):
        return ""


def _plain(part: Any) -> dict[str, Any]:
    """Return the attributes of a part of the model that matter and are not the default."""
    return {
        attribute.name: getattr(part, attribute.name)
        for attribute in dataclasses.fields(part)
        if attribute.name not in IRRELEVANT and getattr(part, attribute.name) != attribute.default
    }
