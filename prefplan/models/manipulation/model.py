"""Manipulation model: an arm moves one object at a time between named locations."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, ClassVar

from prefplan.errors import ModelError
from prefplan.models.manipulation.action_costs import ActionCosts, MeasuredCosts, check_costs, cost_names
from prefplan.models.manipulation.description import (
    Location,
    Object,
    check_locations,
    check_objects,
    check_propositions,
    check_scene,
)
from prefplan.models.manipulation.operators import STANDARD_OPERATORS, Operator, parameters_of, read_action
from prefplan.models.manipulation.surroundings import Fixture, RobotSetup
from prefplan.models.manipulation.symbolic import Action, ManipulationState, at, holding, marked
from prefplan.models.manipulation.system import ManipulationSystem, transition_system
from prefplan.text.forms import Form, check_fields
from prefplan.text.names import DisplayNames, Names, labels_of

__all__ = ["Location", "ManipulationModel", "ManipulationState", "Object"]


@dataclass(frozen=True)
class ManipulationModel:
    """Locations, objects, operators and their costs; `transition_system` makes the WTS.

    Attributes:
        start: the hand's initial location, or any other word for a pose to which it never returns.
        costs: cost of each kind of action, or measured costs.
        locations: in the order of the file.
        objects: in the order of the file.
        propositions: further names that formulas may use, although they hold in no state.
        fixtures: obstacles and furniture, in the order of the file.
        robot: the robot and the pose of its base, or its name alone.
        abstract: whether plans are made without checking that an arm can carry them out.
        scene: path of the user's MJCF scene, relative to the scenario, in place of the table.
        folder: folder of the scenario file, to which paths are relative.
        begin: the initial state; None for the hand at `start` and every object at its own `start`.
        operators: the kinds of actions, in the order that decides between plans of equal worth; others may follow the
            standard ones.
        listed_states: a model of at most this many states (an upper bound) is listed to be searched, in about a second.

    Raises:
        ModelError: (on construction) for names that clash, unknown supports, overfull or unsupported starts, two
            operators of one kind, and missing, unknown or negative costs. The message starts with the key as in a
            scenario file.
    """

    kind: ClassVar[str] = "manipulation"

    start: str
    costs: ActionCosts
    locations: Annotated[
        tuple[Location, ...],
        Form(
            "tables by name, such as spot = { at = [0.5, 0.1] }", 'a tuple such as (Location("spot", at=(0.5, 0.1)),)'
        ),
    ]
    objects: Annotated[
        tuple[Object, ...],
        Form('tables by name, such as cup = { start = "spot" }', 'a tuple such as (Object("cup", start="spot"),)'),
    ]
    propositions: Names = field(default_factory=frozenset)
    fixtures: tuple[Fixture, ...] = ()
    robot: str | RobotSetup = RobotSetup()
    abstract: bool = False
    scene: str | None = None
    folder: Path = field(default=Path(), metadata={"key": None}, compare=False)
    begin: ManipulationState | None = field(default=None, metadata={"key": None})
    operators: tuple[Operator, ...] = field(default=STANDARD_OPERATORS, metadata={"key": None})
    listed_states: int = field(default=300_000, metadata={"key": None})

    def __post_init__(self) -> None:
        """Check that the parts fit together."""
        for kind in self.kinds:
            if self.kinds.count(kind) > 1:
                raise ModelError(f"operators: {kind!r} is listed twice")
        check_costs(self.costs, self.kinds)
        check_fields(self, ModelError)
        check_locations(self.locations)
        check_objects(self)
        check_propositions(self)
        check_scene(self)
        _ = self.display

    @property
    def movable(self) -> frozenset[str]:
        """The objects that are not fixed."""
        return frozenset(obj.name for obj in self.objects if not obj.fixed)

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of actions."""
        return tuple(operator.kind for operator in self.operators)

    @property
    def cost_names(self) -> tuple[str, ...]:
        """The names of the costs."""
        return cost_names(self.costs)

    @property
    def display(self) -> DisplayNames:
        """The names to display; raise ModelError for a label that is invalid."""
        return DisplayNames(
            objects=labels_of("object", [(f"objects.{obj.name}", obj.name, obj.label) for obj in self.objects]),
            locations=labels_of(
                "location", [(f"locations.{place.name}", place.name, place.label) for place in self.locations]
            ),
            parameters=parameters_of(self.operators),
        )

    @property
    def robot_setup(self) -> RobotSetup:
        """The robot and the pose of its base."""
        return RobotSetup(self.robot) if isinstance(self.robot, str) else self.robot

    @property
    def files(self) -> tuple[str, ...]:
        """The files that the model names, by their paths relative to its folder."""
        return tuple(filter(None, (self.scene, self.robot_setup.mjcf, *(obj.file for obj in self.objects))))

    def location(self, name: str) -> Location:
        """Return the location with a name."""
        return next(place for place in self.locations if place.name == name)

    def propositions_of(self, obj: str) -> list[tuple[str, str]]:
        """Return every proposition about an object, each with its meaning in words."""
        names = [(holding(obj), f"holding {obj!r}")]
        names += [(at(obj, place.name), f"{obj!r} at {place.name!r}") for place in self.locations]
        return names + [(marked(obj, mark), f"{obj!r} marked {mark!r}") for mark in self.marks]

    @property
    def marks(self) -> tuple[str, ...]:
        """The distinct marks that locations give, in the order of the file."""
        return tuple(dict.fromkeys(place.marks for place in self.locations if place.marks))

    @property
    def own_propositions(self) -> frozenset[str]:
        """Every proposition that a state's label may have."""
        return frozenset(name for obj in self.objects for name, _ in self.propositions_of(obj.name))

    @property
    def valid_propositions(self) -> frozenset[str]:
        """Every name that a formula may use."""
        return self.own_propositions | self.propositions

    @property
    def slot_counts(self) -> dict[str, int]:
        """Number of distinguished slots of each location: its capacity where costs are measured, otherwise 1."""
        apart = isinstance(self.costs, MeasuredCosts)
        return {place.name: place.capacity if apart else 1 for place in self.locations}

    @property
    def initial_state(self) -> ManipulationState:
        """The initial state: `begin`, or else the hand at `start`, every object at its own `start`, no marks."""
        places = tuple((obj.name, obj.start) for obj in self.objects)
        return self.begin or ManipulationState(self.start, None, places)

    def operator(self, kind: str) -> Operator:
        """Return the operator of a kind of action."""
        return next(operator for operator in self.operators if operator.kind == kind)

    def action(self, text: str) -> Action:
        """Return the action with a text; see `read_action`."""
        return read_action(text, self.operators)

    def effect(self, action: Action) -> frozenset[str]:
        """Return the propositions that an action makes true whenever it succeeds."""
        return self.operator(action.kind).effect(action)

    def transition_system(self) -> ManipulationSystem:
        """Return the states reachable from `initial_state` as a system; none of them is listed yet.

        Each state is a `ManipulationState`; actions are in the order of the operators, and in the order of each.

        Raises:
            ModelError: `begin` has names that are not of the model, or leaves an object without a place.
        """
        return transition_system(self)
