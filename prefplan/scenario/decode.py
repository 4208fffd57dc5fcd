"""Scenario files: TOML decoded strictly into a model, tasks and a preference."""

from __future__ import annotations

import numbers
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from decimal import Decimal
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationError,
    model_validator,
)
from pydantic_core import PydanticCustomError

from prefplan.errors import PrefplanError, ScenarioError, choices
from prefplan.models.graph import GraphModel, Transition
from prefplan.models.grid import Box, GridModel
from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.models.manipulation.measured_costs import with_measured_costs
from prefplan.models.manipulation.model import Location, ManipulationModel, Object
from prefplan.preferences.kinds import Deadline, Due, Expression, Max, Order, Preference, Sum, WeightedSum
from prefplan.problem import Problem, Relaxation, Task
from prefplan.scenario.messages import first_problem

Model = GraphModel | GridModel | ManipulationModel


@dataclass(frozen=True)
class Scenario:
    """A scenario file's contents.

    Attributes:
        name: the file's name without its ending.
        path: where it was read.
        model: what the robot can do.
        tasks: in the order of the file.
        preference: how they would best be done.
        text: the file itself; empty for a scenario made in another way.
    """

    name: str
    path: Path
    model: Model
    tasks: tuple[Task, ...]
    preference: Preference
    text: str = field(default="", repr=False, compare=False)

    @cached_property
    def _problem(self) -> Problem:
        try:
            system = self.model.transition_system()
        except PrefplanError as error:
            raise ScenarioError(f"{self.path}: model.{error}") from None
        try:
            return Problem(system, self.tasks, self.preference)
        except PrefplanError as error:
            raise ScenarioError(f"{self.path}: {error}") from None

    def problem(self) -> Problem:
        """Return the planning problem, building the model's transition system at the first call.

        Raises:
            ScenarioError: if a formula or the preference does not fit; the message names the file and the key.
        """
        return self._problem


def load(path: str | Path, *, measured: bool = True) -> Scenario:
    """Read a scenario file.

    Args:
        path: of the file.
        measured: read the measurements that the costs are to be taken from; False to leave such costs empty.

    Raises:
        ScenarioError: if there is no such file, it is not TOML, or something in it is wrong; the message names the
            file and the key and says what would be valid.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise ScenarioError(f"{path}: no such file") from None
    except OSError as error:
        raise ScenarioError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError as error:
        raise ScenarioError(f"{path}: not TOML: {error}") from None
    return loads(text, name=path.stem, path=path, measured=measured)


def loads(text: str, *, name: str = "scenario", path: Path | None = None, measured: bool = True) -> Scenario:
    """Return the scenario that the text of a file describes.

    Args:
        text: the file's contents.
        name: what the scenario is called.
        path: where it was read; measurements are looked for beside it.
        measured: as in `load`.

    Raises:
        ScenarioError: as in `load`.
    """
    path = path or Path(name)
    try:
        data = tomllib.loads(text, parse_float=Decimal)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{path}: not TOML: {error}") from None
    except RecursionError:
        raise ScenarioError(f"{path}: lists or tables are nested too deep") from None
    except ValueError as error:
        # Python reads integers of at most some thousand digits.
        raise ScenarioError(f"{path}: a number is too long: {str(error).partition(';')[0]}") from None
    return replace(from_dict(data, name=name, path=path, measured=measured), text=text)


def from_dict(
    data: Mapping[str, Any], *, name: str = "scenario", path: Path | None = None, measured: bool = True
) -> Scenario:
    """Return a scenario from the contents of a file, as a TOML reader gives them.

    Args:
        data: the contents.
        name: what the scenario is called.
        path: where it was read; measurements are looked for beside it.
        measured: as in `load`.

    Raises:
        ScenarioError: as in `load`.
    """
    path = path or Path(name)
    try:
        file = _File.model_validate(data)
    except ValidationError as error:
        raise ScenarioError(f"{path}: {first_problem(error, data)}") from None
    try:
        model = file.model.build()
        if measured and isinstance(model, ManipulationModel):
            model = with_measured_costs(model, path)
    except PrefplanError as error:
        raise ScenarioError(f"{path}: model.{error}") from None
    tasks = tuple(task.build() for task in file.tasks)
    return Scenario(name, path, model, tasks, file.preference.build())


class _Table(BaseModel):
    """A table of the file: no unknown keys, no conversion between types."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, arbitrary_types_allowed=True)

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        if isinstance(data, Mapping):
            valid = [field.alias or name for name, field in cls.model_fields.items()]
            for key in data:
                if key not in valid:
                    raise PydanticCustomError(
                        "unknown_key",
                        "{message}",
                        {"key": key, "message": f"unknown key {choices(key, valid)}"},
                    )
        return data


def _number(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, (numbers.Real, Decimal)):
        raise PydanticCustomError("number", "must be a number, not {value}", {"value": repr(value)})
    return value


_Cost = Annotated[Any, BeforeValidator(_number)]
_Metres = Annotated[float, BeforeValidator(lambda value: float(_number(value)))]
_Tuple = BeforeValidator(lambda value: tuple(value) if isinstance(value, list) else value)
"""TOML has arrays only; everything else is left to the type's own error."""


def _boxes(value: Any) -> Any:
    """One box or several, as a tuple of tuples."""
    if isinstance(value, list) and value and not isinstance(value[0], list):
        value = [value]
    return tuple(tuple(box) if isinstance(box, list) else box for box in value) if isinstance(value, list) else value


_Boxes = Annotated[tuple[Box, ...], BeforeValidator(_boxes)]


class _Transition(_Table):
    source: str = Field(alias="from")
    target: str = Field(alias="to")
    action: str | None = None
    cost: _Cost = 1


class _Graph(_Table):
    kind: Literal["graph"]
    start: str
    transitions: Annotated[tuple[_Transition, ...], _Tuple]
    labels: dict[str, list[str]] = {}
    propositions: list[str] = []
    resolution: _Cost | None = None

    def build(self) -> GraphModel:
        edges = tuple(Transition(t.source, t.target, t.action, t.cost) for t in self.transitions)
        return GraphModel(self.start, edges, self.labels, frozenset(self.propositions), self.resolution)


class _Grid(_Table):
    kind: Literal["grid"]
    size: Annotated[tuple[int, int], _Tuple]
    start: Annotated[tuple[int, int], _Tuple]
    cost: _Cost = 1
    regions: dict[str, _Boxes] = {}
    obstacles: dict[str, _Boxes] = {}
    propositions: list[str] = []

    def build(self) -> GridModel:
        propositions = frozenset(self.propositions)
        return GridModel(self.size, self.start, self.cost, self.regions, self.obstacles, propositions)


class _Location(_Table):
    at: Annotated[tuple[_Metres, _Metres] | None, _Tuple] = None
    on: Annotated[tuple[str, ...], _Tuple] = ()
    capacity: int = 1
    marks: str | None = None
    kind: str | None = None


def _sizes(value: Any) -> Any:
    """One length or several, as a tuple."""
    return tuple(value) if isinstance(value, list) else (_number(value),)


class _Object(_Table):
    start: str
    fixed: bool = False
    rgba: Annotated[tuple[_Metres, _Metres, _Metres, _Metres] | None, _Tuple] = None
    kind: str = "cube"
    size: Annotated[tuple[_Metres, ...], BeforeValidator(_sizes)] | None = None


class _Measured(_Table):
    measured: str

    def build(self) -> MeasuredCosts:
        return MeasuredCosts(self.measured)


def _says_measured(value: Any) -> str:
    return "<measured>" if isinstance(value, Mapping) and "measured" in value else "<numbers>"


_Costs = Annotated[
    Annotated[dict[str, _Cost], Tag("<numbers>")] | Annotated[_Measured, Tag("<measured>")],
    Discriminator(_says_measured),
]
"""The tags are no keys that a file could have, so that they are left out of messages."""


class _Manipulation(_Table):
    kind: Literal["manipulation"]
    start: str
    costs: _Costs
    locations: dict[str, _Location]
    objects: dict[str, _Object]
    propositions: list[str] = []

    def build(self) -> ManipulationModel:
        return ManipulationModel(
            self.start,
            self.costs.build() if isinstance(self.costs, _Measured) else self.costs,
            tuple(Location(name, x.at, x.on, x.capacity, x.marks, x.kind) for name, x in self.locations.items()),
            tuple(Object(name, x.start, x.fixed, x.rgba, x.kind, x.size) for name, x in self.objects.items()),
            frozenset(self.propositions),
        )


class _Relaxation(_Table):
    assume: str
    when: str
    cost: _Cost


class _Task(_Table):
    name: str
    formula: str
    relax: Annotated[tuple[_Relaxation, ...], _Tuple] = ()
    skip: _Cost | None = None

    def build(self) -> Task:
        relax = tuple(Relaxation(r.assume, r.when, r.cost) for r in self.relax)
        return Task(self.name, self.formula, relax, self.skip)


def _groups(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(tuple(entry) if isinstance(entry, list) else entry for entry in value)
    return value


class _Order(_Table):
    kind: Literal["order"]
    order: Annotated[tuple[str | tuple[str, ...], ...] | None, BeforeValidator(_groups)] = None

    def build(self) -> Order:
        return Order(self.order)


_Over = Literal["cost", "violation"]


class _WeightedSum(_Table):
    kind: Literal["weighted-sum"]
    weights: dict[str, _Cost]
    over: _Over = "cost"

    def build(self) -> WeightedSum:
        return WeightedSum(self.weights, self.over)


class _Max(_Table):
    kind: Literal["max"]
    weights: dict[str, _Cost] = {}
    over: _Over = "cost"

    def build(self) -> Max:
        return Max(self.weights, self.over)


class _Due(_Table):
    by: _Cost
    weight: _Cost = 1


class _Deadline(_Table):
    kind: Literal["deadline"]
    deadlines: dict[str, _Due]
    over: _Over = "cost"

    def build(self) -> Deadline:
        return Deadline({name: Due(due.by, due.weight) for name, due in self.deadlines.items()}, self.over)


class _Expression(_Table):
    kind: Literal["expression"]
    expression: str
    contract: Literal["additive", "convex", "componentwise", "general"] | None = None
    over: _Over = "cost"

    def build(self) -> Expression:
        return Expression(self.expression, self.contract, self.over)


class _OrderTerm(_Order):
    weight: _Cost = 1


class _WeightedSumTerm(_WeightedSum):
    weight: _Cost = 1


class _MaxTerm(_Max):
    weight: _Cost = 1


class _DeadlineTerm(_Deadline):
    weight: _Cost = 1


class _ExpressionTerm(_Expression):
    weight: _Cost = 1


_Term = Annotated[
    _OrderTerm | _WeightedSumTerm | _MaxTerm | _DeadlineTerm | _ExpressionTerm, Field(discriminator="kind")
]


class _Sum(_Table):
    kind: Literal["sum"]
    terms: Annotated[tuple[_Term, ...], _Tuple]

    def build(self) -> Sum:
        return Sum(tuple((term.build(), term.weight) for term in self.terms))


class _File(_Table):
    model: Annotated[_Graph | _Grid | _Manipulation, Field(discriminator="kind")]
    tasks: Annotated[tuple[_Task, ...], _Tuple]
    preference: Annotated[_Order | _WeightedSum | _Max | _Deadline | _Expression | _Sum, Field(discriminator="kind")]
