"""A manipulation model as a transition system: listed, or with too many states to list."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

from prefplan.errors import ModelError
from prefplan.models.manipulation.action_costs import cost_matrices
from prefplan.models.manipulation.codes import StateCodes
from prefplan.models.manipulation.description import Description
from prefplan.models.manipulation.listing import ActionModel, listed, moves_of, table
from prefplan.models.manipulation.operators import STANDARD_OPERATORS, Operator, parameters_of
from prefplan.models.manipulation.state import ManipulationState
from prefplan.models.manipulation.symmetry import ReducedModel, most_states
from prefplan.models.system import Barred, Quotient, System
from prefplan.models.transition_system import TransitionSystem
from prefplan.text.names import DisplayNames


def transition_system(
    model: Description, operators: Sequence[Operator], start: ManipulationState, listed_states: int
) -> System:
    """Return the states that can be reached from one, listed unless they may be too many.

    Args:
        model: the model.
        operators: the kinds of actions; all states are listed if there are others than the standard ones.
        start: the initial state.
        listed_states: how many states may be listed, by an upper bound of their number.

    Raises:
        ModelError: the start is not a state of the model, or a state does not fit an integer.
    """
    space = StateCodes(model, start)
    start = space.decode(space.encode(start, where="start"))
    costs = cost_matrices(model, [operator.kind for operator in operators], space.hands)
    system = ManipulationSystem(
        actions=ActionModel(space, tuple(operators), costs),
        start=start,
        propositions=model.own_propositions | model.propositions,
        display=replace(model.display, parameters=parameters_of(operators)),
    )
    if system.actions.operators == STANDARD_OPERATORS and most_states(model, start) > listed_states:
        return system
    return system.listed


@dataclass(frozen=True)
class ManipulationSystem(System):
    """A manipulation model of the standard operators with too many states to list; a state is a `ManipulationState`.

    Attributes:
        actions: its actions.
        start: the initial state.
        propositions: every name that a formula may use.
        display: as in `System`.
        barred: actions that do not exist where some propositions hold.
        resolution: None, as costs are not rounded.
        map: None.
    """

    actions: ActionModel
    start: ManipulationState
    propositions: frozenset[str]
    display: DisplayNames
    barred: Barred = ()
    resolution: None = None
    map: None = None

    @property
    def is_large(self) -> bool:
        """See `System.is_large`."""
        return True

    @cached_property
    def listed(self) -> TransitionSystem:
        """See `System.listed`.

        Raises:
            ModelError: a state does not fit an integer, or the cost of an action was not measured.
        """
        space = self.actions.space
        if self.actions.operators == STANDARD_OPERATORS:
            states = listed(space, moves_of(space), space.encode(self.start, where="start"))
        else:
            states = self.actions.listed(self.start)
        system = table(space, states, self.actions.costs, None).without(self.barred)
        return replace(system, propositions=self.propositions, display=self.display)

    @property
    def size(self) -> int:
        """Number of states, all of which are listed."""
        return self.listed.size

    @property
    def cost_names(self) -> tuple[str, ...]:
        """See `System.cost_names`."""
        return tuple(matrix.name for matrix in self.actions.costs)

    @property
    def shared_units(self) -> tuple[Fraction, ...]:
        """See `System.shared_units`; here of all costs that an action may have, reachable or not."""
        return tuple(matrix.shared_unit for matrix in self.actions.costs)

    @property
    def greatest_costs(self) -> tuple[Fraction, ...]:
        """See `System.greatest_costs`."""
        return tuple(
            matrix.unit * int(matrix.entries.max()) * self.actions.space.bound for matrix in self.actions.costs
        )

    def with_first_cost(self) -> ManipulationSystem:
        """See `System.with_first_cost`."""
        return replace(self, actions=replace(self.actions, costs=self.actions.costs[:1]))

    def knowing(self, propositions: frozenset[str]) -> ManipulationSystem:
        """See `System.knowing`."""
        return replace(self, propositions=propositions)

    def without(self, barred: Barred) -> ManipulationSystem:
        """See `System.without`."""
        return replace(self, barred=(*self.barred, *barred))

    def decode(self, state: ManipulationState) -> ManipulationState:
        """See `System.decode`."""
        return state

    def label(self, state: ManipulationState) -> frozenset[str]:
        """See `System.label`."""
        return state.label

    def steps(self, state: ManipulationState, action: str) -> tuple[ManipulationState, tuple[Fraction, ...]]:
        """See `System.steps`."""
        barred = any(action == name and names <= state.label for names, name in self.barred)
        step = None if barred else self.actions.step(state, action)
        if step is None:
            raise ModelError(f"action {action!r} does not exist in state {state!r}")
        return step

    def reduced(self, names: Collection[str], *, stutter_invariant: bool) -> ReducedModel:
        """Return a smaller model to search instead; arguments as in `System.quotient`."""
        return ReducedModel(self.actions, self.start, self.barred, names, stutter_invariant=stutter_invariant)

    def quotient(self, names: Collection[str], *, stutter_invariant: bool) -> Quotient:
        """See `System.quotient`."""
        quotient = self.reduced(names, stutter_invariant=stutter_invariant).quotient()
        return replace(quotient, system=quotient.system.knowing(self.propositions))
