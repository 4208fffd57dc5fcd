"""Scenario files: TOML decoded strictly into a model, tasks and a preference."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from prefplan.errors import ModelError, PrefplanError, ScenarioError, describe, prefixed
from prefplan.exact_costs import Number
from prefplan.logic.tasks import Rule, Task
from prefplan.models.feasibility import Feasible
from prefplan.models.graph import GraphModel
from prefplan.models.graph_file import GraphFileModel
from prefplan.models.grid import GridModel
from prefplan.models.manipulation.measured_costs import with_measured_costs
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.preferences.kinds import Deadline, Expression, Max, Order, Preference, Sum, WeightedSum
from prefplan.preferences.objective import DEFAULT_PREFERENCE, NamedPreference
from prefplan.problem import Problem
from prefplan.scenario.files import contents, path_of, text_of
from prefplan.scenario.tables import chosen, decode, decode_table
from prefplan.text.forms import Form

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
        feasible: what the arm can do; None if the planner does not ask for it.
    """

    name: str
    path: Path
    model: Model
    tasks: tuple[Task, ...]
    preference: Preference
    rules: tuple[Rule, ...] = ()
    text: str = field(default="", repr=False, compare=False)
    preferences: tuple[NamedPreference, ...] | None = None
    feasible: Feasible | None = field(default=None, repr=False, compare=False)

    @cached_property
    def _problem(self) -> Problem:
        with prefixed(f"{self.path}: model.", new=ScenarioError):
            system = self.model.transition_system()
        with prefixed(f"{self.path}: ", new=ScenarioError):
            preferences = self.preference if self.preferences is None else self.preferences
            return Problem(system, self.tasks, preferences, rules=self.rules, feasible=self.feasible)

    def problem(self) -> Problem:
        """Return the planning problem, building the model's transition system at the first call.

        Raises:
            ScenarioError: if the model, a formula or the preference is invalid; the message names the file and the key.
            LimitError: a limit was reached while the system was built.
        """
        return self._problem


ProblemLike = Problem | Scenario | str | Path
"""What a user may give for a problem, see `problem_of`."""


def load(scenario: str | Path, *, measured: bool = True) -> Scenario:
    """Read a scenario that ships, or a scenario file.

    Args:
        scenario: the name of one that ships, such as `case_study_3`, or the path of a file, whose `.toml` may be left
            out in a string.
        measured: whether to read the file of measured costs, if the model has such costs; else they stay empty.

    Raises:
        ScenarioError: if there is no such scenario or file, it is not TOML, or its contents are invalid; the message
            names the file and the key and says what would be valid.
    """
    path = path_of(scenario)
    return loads(text_of(path), name=path.stem, path=path, measured=measured)


def problem_of(given: ProblemLike) -> Problem:
    """Return the problem that is given as such, as a scenario, or by a name or path that `load` takes.

    Raises:
        PrefplanError: it is something else, or as in `load` and `Scenario.problem`.
    """
    if isinstance(given, str | Path):
        given = load(given)
    if isinstance(given, Scenario):
        return given.problem()
    if isinstance(given, Problem):
        return given
    raise PrefplanError(
        f"problem: must be a Problem, a scenario, or the name or path of one, not {describe(given)}; "
        "Problem(system, tasks, preference) makes one"
    )


def loads(text: str, *, name: str = "scenario", path: Path | None = None, measured: bool = True) -> Scenario:
    """Return the scenario in the text of a file; the model's other files are read from the folder of `path`.

    Raises:
        ScenarioError: as in `load`.
    """
    path = path or Path(name)
    return replace(from_dict(contents(text, path), name=name, path=path, measured=measured), text=text)


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
            propositions = model.valid_propositions
        preferences = _preferences(file)
        if not preferences and len(model.cost_names) == 1:
            raise ScenarioError('preference: missing; write [preference] and below it, for example, kind = "order"')
    tasks = tuple(replace(task, propositions=propositions) for task in file.tasks)
    rules = tuple(replace(rule, propositions=propositions) for rule in file.rules)
    first = preferences[0].preference if preferences else WeightedSum({})
    several = None if [NamedPreference(DEFAULT_PREFERENCE, first)] == preferences else tuple(preferences)
    return Scenario(name, path, model, tasks, first, rules, preferences=several)


@dataclass(frozen=True)
class _File:
    model: Any
    tasks: Annotated[tuple[Task, ...], Form("tables: write [[tasks]] above each")]
    preference: Any = None
    preferences: Annotated[tuple[Any, ...], Form("tables: write [[preferences]] above each")] = ()
    rules: Annotated[tuple[Rule, ...], Form("tables: write [[rules]] above each")] = ()


def _model(table: Any, folder: Path) -> Model:
    """Return a model; graphs, scenes and robots may be in files of the scenario's folder."""
    kind = chosen(MODELS, table, "model")
    if kind is GraphModel and "file" in table:
        if "transitions" in table:
            raise ScenarioError("model.transitions: these are in the file already; leave out this key or `file`")
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
    """Return the preference of a table with its `name` and `of`; what is `given` is no key of the table."""
    beside = tuple(key for key in ("name", "of") if key not in given)
    preference = _preference(PREFERENCES, table, where, beside)
    said = {key: table[key] for key in beside if key in table}
    return decode_table(NamedPreference, given | said, where, preference=preference)


def _preference(kinds: Mapping[str, type[Preference]], table: Any, where: str, also: tuple[str, ...]) -> Preference:
    """Return a preference, or a term of a sum; `also` are further keys of its table."""
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
