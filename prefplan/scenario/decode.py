"""Scenario files: TOML decoded strictly into a model, tasks and a preference."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from decimal import Decimal
from functools import cached_property
from pathlib import Path
from typing import Any

from prefplan.errors import ModelError, ScenarioError, prefixed
from prefplan.exact_costs import Number
from prefplan.logic.tasks import Rule, Task
from prefplan.models.graph import GraphModel
from prefplan.models.graph_files.model import GraphFileModel
from prefplan.models.grid import GridModel
from prefplan.models.manipulation.measured_costs import with_measured_costs
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.preferences.kinds import Deadline, Expression, Max, Order, Preference, Sum, WeightedSum
from prefplan.preferences.objective import DEFAULT_PREFERENCE, NamedPreference
from prefplan.problem import Problem
from prefplan.scenario.tables import chosen, decode, decode_table

Model = GraphModel | GraphFileModel | GridModel | ManipulationModel

MODELS: dict[str, type[Model]] = {model.kind: model for model in (GraphModel, GridModel, ManipulationModel)}

PREFERENCES: dict[str, type[Preference]] = {
    "order": Order,
    "weighted-sum": WeightedSum,
    "max": Max,
    "deadline": Deadline,
    "expression": Expression,
    "sum": Sum,
}


@dataclass(frozen=True)
class Scenario:
    """A scenario file's contents.

    Attributes:
        name: the file's name without its suffix.
        path: path of the file.
        model: the robot's model.
        tasks: in the order of the file.
        preference: the preference; the first of several.
        rules: in the order of the file.
        text: the file's text; empty for a scenario that was not read from text.
        preferences: all preferences, with their names; None if `preference` is the only one.
    """

    name: str
    path: Path
    model: Model
    tasks: tuple[Task, ...]
    preference: Preference
    rules: tuple[Rule, ...] = ()
    text: str = field(default="", repr=False, compare=False)
    preferences: tuple[NamedPreference, ...] | None = None

    @cached_property
    def _problem(self) -> Problem:
        with prefixed(f"{self.path}: model.", new=ScenarioError):
            system = self.model.transition_system()
        with prefixed(f"{self.path}: ", new=ScenarioError):
            preferences = self.preference if self.preferences is None else self.preferences
            return Problem(system, self.tasks, preferences, rules=self.rules)

    def problem(self) -> Problem:
        """Return the planning problem, building the model's transition system at the first call.

        Raises:
            ScenarioError: if the model, a formula or the preference is invalid; the message names the file and the key.
            LimitError: a limit was reached while the system was built.
        """
        return self._problem


def load(path: str | Path, *, measured: bool = True) -> Scenario:
    """Read a scenario file.

    Args:
        path: path of the file.
        measured: whether to read the file of measured costs, if the model has such costs; else they stay empty.

    Raises:
        ScenarioError: if there is no such file, it is not TOML, or its contents are invalid; the message names the
            file and the key and says what would be valid.
    """
    path = Path(path)
    return loads(_text(path), name=path.stem, path=path, measured=measured)


def is_scenario(path: Path) -> bool:
    """Return whether a file is TOML and has the top-level keys that every scenario needs."""
    try:
        data = _contents(_text(path), path)
    except ScenarioError:
        return False
    return all(field.name in data for field in fields(_File) if field.default is MISSING)


def loads(text: str, *, name: str = "scenario", path: Path | None = None, measured: bool = True) -> Scenario:
    """Return the scenario that the text of a file describes.

    Args:
        text: the file's contents.
        name: the scenario's name.
        path: path of the file; the model's other files are read from its folder.
        measured: as in `load`.

    Raises:
        ScenarioError: as in `load`.
    """
    path = path or Path(name)
    return replace(from_dict(_contents(text, path), name=name, path=path, measured=measured), text=text)


def from_dict(
    data: Mapping[str, Any], *, name: str = "scenario", path: Path | None = None, measured: bool = True
) -> Scenario:
    """Return a scenario from the contents of a file, as a TOML parser returns them.

    Arguments are those of `loads`.

    Raises:
        ScenarioError: as in `load`.
        LimitError: a limit was reached while the model's files were read.
    """
    path = path or Path(name)
    with prefixed(f"{path}: ", ScenarioError):
        file = decode_table(_File, dict(data), "")
        with prefixed("model.", ModelError, new=ScenarioError):
            model = _model(file.model, path.parent)
            if measured and isinstance(model, ManipulationModel):
                model = with_measured_costs(model, path)
            known = model.known_propositions
        preferences = _preferences(file)
        if not preferences and len(model.cost_names) == 1:
            raise ScenarioError("preference: missing")
    tasks = tuple(replace(task, known=known) for task in file.tasks)
    rules = tuple(replace(rule, known=known) for rule in file.rules)
    first = preferences[0].preference if preferences else WeightedSum({})
    several = None if [NamedPreference(DEFAULT_PREFERENCE, first)] == preferences else tuple(preferences)
    return Scenario(name, path, model, tasks, first, rules, preferences=several)


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise ScenarioError(f"{path}: no such file") from None
    except OSError as error:
        raise ScenarioError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError as error:
        raise ScenarioError(f"{path}: not TOML: {error}") from None


def _contents(text: str, path: Path) -> dict[str, Any]:
    """Return the parsed text of a TOML file."""
    try:
        return tomllib.loads(text, parse_float=Decimal)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{path}: not TOML: {error}") from None
    except RecursionError:
        raise ScenarioError(f"{path}: lists or tables are nested too deep") from None
    except ValueError as error:
        # Python refuses to parse integers of thousands of digits.
        raise ScenarioError(f"{path}: a number is too long: {str(error).partition(';')[0]}") from None


@dataclass(frozen=True)
class _File:
    model: Any
    tasks: tuple[Task, ...]
    preference: Any = None
    preferences: tuple[Any, ...] = ()
    rules: tuple[Rule, ...] = ()


def _model(table: Any, folder: Path) -> Model:
    """Return a model; graphs, scenes and robots may be in files of the scenario's folder."""
    kind = chosen(MODELS, table, "model")
    if kind is GraphModel and "file" in table:
        return decode_table(GraphFileModel, table, "model", also=("kind",), folder=folder)
    given = {"folder": folder} if kind is ManipulationModel else {}
    model = decode_table(kind, table, "model", also=("kind",), **given)
    if isinstance(model, ManipulationModel) and model.robot_setup.mjcf:
        return replace(model, robot=replace(model.robot_setup, folder=folder.absolute()))
    return model


def _preferences(file: _File) -> list[NamedPreference]:
    """Return the preferences of `[preference]` and `[[preferences]]` in this order."""
    only = [] if file.preference is None else [_named(file.preference, "preference", name=DEFAULT_PREFERENCE)]
    return only + [_named(table, f"preferences[{i}]") for i, table in enumerate(file.preferences)]


def _named(table: Any, where: str, **given: str) -> NamedPreference:
    """Return a preference and what its table says beside; a name that is given is none of its keys."""
    beside = tuple(key for key in ("name", "of") if key not in given)
    preference = _preference(PREFERENCES, table, where, beside)
    said = {key: table[key] for key in beside if key in table}
    return decode_table(NamedPreference, given | said, where, preference=preference)


def _preference(kinds: Mapping[str, type[Preference]], table: Any, where: str, also: tuple[str, ...]) -> Preference:
    """Return a preference, or a term of a sum; its table may have some more keys."""
    kind = chosen(kinds, table, where)
    if kind is not Sum:
        return decode_table(kind, table, where, also=("kind", *also))
    single = {name: kind for name, kind in PREFERENCES.items() if kind is not Sum}
    terms = decode_table(_Terms, table, where, also=("kind", *also)).terms
    parts = []
    for i, term in enumerate(terms):
        at = f"{where}.terms[{i}]"
        part = _preference(single, term, at, ("weight",))
        parts.append((part, decode(Number, term.get("weight", 1), f"{at}.weight")))
    return Sum(tuple(parts))


@dataclass(frozen=True)
class _Terms:
    terms: tuple[Any, ...]
