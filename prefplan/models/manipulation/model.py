"""Manipulation model: an arm moves one object at a time between named locations."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

from prefplan.errors import ModelError
from prefplan.models.manipulation.action import Action
from prefplan.models.manipulation.action_costs import check_costs, cost_names
from prefplan.models.manipulation.description import Description, Location, Object
from prefplan.models.manipulation.operators import STANDARD_OPERATORS, Operator, parameters_of, read_action
from prefplan.models.manipulation.state import ManipulationState
from prefplan.models.manipulation.system import transition_system
from prefplan.models.system import System
from prefplan.text.names import DisplayNames

__all__ = ["Location", "ManipulationModel", "ManipulationState", "Object"]


@dataclass(frozen=True)
class ManipulationModel(Description):
    """Locations, objects, operators and their costs; `transition_system` makes the WTS.

    Attributes are those of `Description`, and:

    Attributes:
        operators: the kinds of actions, in the order in which plans of equal worth prefer them; after the standard
            ones there may be others.
        listed_states: a model of no more states, by an upper bound, is searched as it is: listing these takes about a
            second.

    Raises:
        ModelError: (on construction) as `Description`; for two operators of one kind, and for missing, unknown or
            negative costs.
    """

    kind: ClassVar[str] = "manipulation"

    operators: tuple[Operator, ...] = field(default=STANDARD_OPERATORS, metadata={"key": None})
    listed_states: int = field(default=300_000, metadata={"key": None})

    def __post_init__(self) -> None:
        """Check that the parts fit together."""
        for kind in self.kinds:
            if self.kinds.count(kind) > 1:
                raise ModelError(f"operators: {kind!r} is listed twice")
        check_costs(self.costs, self.kinds)
        super().__post_init__()

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
        """What people are shown in place of names."""
        return replace(super().display, parameters=parameters_of(self.operators))

    def operator(self, kind: str) -> Operator:
        """Return the operator of a kind of action."""
        return next(operator for operator in self.operators if operator.kind == kind)

    def action(self, text: str) -> Action:
        """Return the action with a text; see `read_action`."""
        return read_action(text, self.operators)

    def effect(self, action: Action) -> frozenset[str]:
        """Return the propositions that an action makes true whenever it succeeds."""
        return self.operator(action.kind).effect(action)

    def transition_system(self, *, start: ManipulationState | None = None) -> System:
        """Return the reachable states as a weighted transition system, listed if there are at most `listed_states`.

        Each state is a `ManipulationState`; actions are in the order of the operators, then in file order.

        Args:
            start: the initial state; None for `initial_state`.

        Raises:
            ModelError: the state has names that are not of the model, or leaves an object without a place.
        """
        return transition_system(self, self.operators, start or self.initial_state, self.listed_states)
