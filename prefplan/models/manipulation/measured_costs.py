"""The file of measurements beside a scenario: what each of its actions took in simulation."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

from prefplan.errors import ModelError
from prefplan.exact_costs import Number
from prefplan.models.manipulation.action_costs import QUANTITIES, MeasuredCosts, Pair
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.manipulation.slots import hand_poses

COSMETIC = frozenset({"rgba"})
"""Attributes of objects that change nothing that is measured."""

DECIMALS = 3
"""Of what was measured, as it is written down."""

FORMAT = 2
"""Of the file: since 2 an action goes from and to slots, where a location has several."""


@dataclass(frozen=True)
class Measurement:
    """What one action took between two poses of the hand, on average.

    Attributes:
        pair: its kind, and the hand's pose before and after it.
        quantities: each of `QUANTITIES`, in its unit.
        samples: how many simulations that is the average of.
    """

    pair: Pair
    quantities: Mapping[str, Number]
    samples: int


@dataclass(frozen=True)
class Measurements:
    """What a file of measurements holds.

    Attributes:
        actions: what each action took.
        robot: name of the robot that was simulated.
        sources: a digest of what moved it; no plan depends on it, but it tells what was measured with other skills.
    """

    actions: tuple[Measurement, ...]
    robot: str
    sources: str


def measurements_file(scenario: Path) -> Path:
    """Return where a scenario's measurements are looked for: beside it."""
    return scenario.with_name(f"{scenario.stem}.measured.json")


def geometry(model: ManipulationModel, robot: str) -> str:
    """Return a digest of all that measurements are of: the locations, the objects, the start and the robot's name."""
    parts = {
        "robot": robot,
        "start": model.start,
        "locations": [_plain(place) for place in model.locations],
        "objects": [_plain(obj) for obj in model.objects],
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def to_json(model: ManipulationModel, measurements: Measurements) -> dict[str, Any]:
    """Return measurements of a model as the contents of their file, in a fixed order."""
    places = model.locations
    hands = hand_poses((place.name for place in places), (place.capacity for place in places), model.start)
    ordered = sorted(
        measurements.actions,
        key=lambda done: (model.kinds.index(done.pair[0]), *(hands.index(hand) for hand in done.pair[1:])),
    )
    return {
        "format": FORMAT,
        "robot": measurements.robot,
        "geometry": geometry(model, measurements.robot),
        "sources": measurements.sources,
        "actions": [
            dict(zip(("action", "from", "to"), done.pair, strict=True))
            | {name: round(float(done.quantities[name]), DECIMALS) for name in QUANTITIES}
            | {"samples": done.samples}
            for done in ordered
        ],
    }


def read_measurements(path: Path, model: ManipulationModel) -> Measurements:
    """Read the measurements of a model.

    Raises:
        ModelError: there is no such file, it cannot be read, is of another format, or was measured on another
            geometry; the message says how it is made.
    """
    remedy = f"`prefplan measure` with this scenario makes {path.name}"
    try:
        data = json.loads(path.read_text(encoding="utf-8"), parse_float=Decimal)
    except FileNotFoundError:
        raise ModelError(f"nothing was measured yet; {remedy}") from None
    except (OSError, ValueError):
        raise ModelError(f"the file of measurements cannot be read; {remedy} (delete it first)") from None
    try:
        # The first format did not say which it was.
        found = data.get("format", 1) if "actions" in data else None
        if found in range(1, FORMAT):
            raise ModelError(f"the measurements were made by an older version of prefplan; {remedy} anew")
        if found != FORMAT:
            raise ValueError(found)
        digest, robot, sources = data["geometry"], str(data["robot"]), str(data["sources"])
        actions = tuple(_measurement(entry) for entry in data["actions"])
    except (AttributeError, KeyError, TypeError, ValueError):
        raise ModelError(f"the file of measurements is damaged; {remedy} (delete it first)") from None
    if digest != geometry(model, robot):
        raise ModelError(f"the measurements were made with other locations or objects; {remedy}")
    return Measurements(actions, robot, sources)


def with_measured_costs(model: ManipulationModel, scenario: Path) -> ManipulationModel:
    """Return a model with the costs that were measured for it, if it asks for such.

    Args:
        model: whose `MeasuredCosts` say what quantity is wanted.
        scenario: file that the model comes from; the measurements lie beside it.

    Raises:
        ModelError: as in `read_measurements`; the message starts with the key.
    """
    if not isinstance(model.costs, MeasuredCosts):
        return model
    try:
        done = read_measurements(measurements_file(scenario), model)
    except ModelError as error:
        raise ModelError(f"costs.measured: {error}") from None
    quantity = model.costs.quantity
    costs = MeasuredCosts(quantity, {one.pair: one.quantities[quantity] for one in done.actions})
    return dataclasses.replace(model, costs=costs)


def _measurement(entry: Mapping[str, Any]) -> Measurement:
    pair = (str(entry["action"]), str(entry["from"]), str(entry["to"]))
    quantities = {name: entry[name] for name in QUANTITIES}
    if not all(isinstance(value, (int, Decimal)) for value in quantities.values()):
        raise ValueError(f"not numbers: {entry}")
    return Measurement(pair, quantities, int(entry["samples"]))


def _plain(part: Any) -> dict[str, Any]:
    """Return what a location or object says of itself, without what it does not say and what is only for show."""
    return {
        attribute.name: getattr(part, attribute.name)
        for attribute in dataclasses.fields(part)
        if attribute.name not in COSMETIC and getattr(part, attribute.name) != attribute.default
    }
