"""A manipulation model as a transition system: listed, or with too many states to list."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

from prefplan.errors import ModelError
from prefplan.limits import check_limits
from prefplan.models.costs import UNMEASURED
from prefplan.models.kernels import compile_kernels
from prefplan.models.manipulation.action_costs import MeasuredCosts, cost_tables
from prefplan.models.manipulation.codes import StateCodes
from prefplan.models.manipulation.listing import listed, moves_of
from prefplan.models.manipulation.operators import STANDARD_OPERATORS
from prefplan.models.manipulation.successors import Moves, canonical
from prefplan.models.manipulation.symbolic import Action, Barred, ManipulationState, last_place
from prefplan.models.manipulation.symmetry import Symmetry, most_states
from prefplan.models.system import System
from prefplan.models.transition_system import TransitionSystem

if TYPE_CHECKING:
    from prefplan.models.manipulation.model import ManipulationModel

Transition = tuple[ManipulationState, str, ManipulationState, Mapping[str, Fraction]]
"""A state, an action, the successor, and the costs of the action by name."""


def transition_system(model: ManipulationModel) -> ManipulationSystem:
    """Return the reachable states of a model as a system; none of them is listed yet.

    Raises:
        ModelError: the start is not a state of the model.
    """
    symmetry = Symmetry(model, model.own_propositions, places_alike=False)
    space = StateCodes(model, symmetry.visible)
    return ManipulationSystem(
        start=replace(space.start, origin=model.initial_state.origin),
        costs=cost_tables(model, space.hands),
        propositions=model.valid_propositions,
        left_out=model.costs.note if isinstance(model.costs, MeasuredCosts) else "",
        display=model.display,
        space=space,
        symmetry=symmetry,
    )


@dataclass(frozen=True, kw_only=True)
class ManipulationSystem(System):
    """A manipulation model whose states are generated one at a time; a state is a `ManipulationState`.

    It may be a smaller model that is equivalent to another one for some propositions. Then each canonical state stands
    for all states of its orbit (see `prefplan.models.manipulation.symmetry`).

    Attributes:
        space: the encoding of the states.
        symmetry: the model, the propositions that are kept, what may be exchanged, and the actions that do not exist.
    """

    space: StateCodes
    symmetry: Symmetry

    @cached_property
    def moves(self) -> Moves:
        """The model as arrays.

        Raises:
            ModelError: there are too many states for 64-bit integers.
        """
        self.space.require_small()
        compile_kernels()
        return moves_of(self.space, self.symmetry)

    def canonical(self, state: ManipulationState) -> int:
        """Return the code of the canonical state of a state."""
        return int(canonical(self.moves, self.space.encode(state, where="state")))

    @cached_property
    def listed(self) -> TransitionSystem:
        """The same system with all its canonical states listed.

        Raises:
            ModelError: a state does not fit an integer.
        """
        if tuple(self.space.model.operators) == STANDARD_OPERATORS:
            system, _ = listed(self.space, self.moves, self.costs, self.canonical(self.start), self.symmetry.visible)
        else:
            system = self._listed_by_operators()
        return replace(system, propositions=self.propositions, left_out=self.left_out, display=self.display)

    @property
    def small(self) -> TransitionSystem | None:
        """See `System.small` and `ManipulationModel.listed_states`; models with other operators are always listed."""
        model = self.space.model
        is_large = tuple(model.operators) == STANDARD_OPERATORS and most_states(model) > model.listed_states
        return None if is_large else self.listed

    def _listed_by_operators(self) -> TransitionSystem:
        """List all states by the operators of the model, which may be others than the standard ones."""
        transitions, states = list[Transition](), [self.start]
        met = set(states)
        for before in states:
            check_limits()
            for action, outcome, costs in self.outcomes(before):
                after = self.space.decode(self.space.encode(outcome, where=f"after `{action}`"))
                transitions.append((before, str(action), after, dict(zip(self.cost_names, costs, strict=True))))
                if after not in met:
                    met.add(after)
                    states.append(after)
        labels = {state: state.label for state in states}
        return TransitionSystem.from_transitions(transitions, start=self.start, labels=labels)

    @property
    def most_states(self) -> int:
        """Number of codes of states."""
        return self.space.bound

    def without(self, barred: Barred) -> ManipulationSystem:
        """Return the system without some actions in some states; see `Barred`.

        Raises:
            ModelError: an action is of an unknown kind, or has not the names that its kind has.
        """
        old = self.symmetry
        symmetry = Symmetry(old.model, old.visible, (*old.barred, *barred), places_alike=False)
        return replace(self, symmetry=symmetry, space=StateCodes(old.model, symmetry.visible, symmetry.origins))

    def after(self, states: Sequence[Hashable]) -> ManipulationSystem:
        """See `System.after`; the start remembers where the object in the hand was grasped."""
        origin = last_place(self.start.held, states)
        return replace(self, start=replace(self.start, origin=origin)) if origin else self

    def decode(self, state: ManipulationState) -> ManipulationState:
        """See `System.decode`; the state has its `origin` only if exclusions depend on it."""
        return state if (state.held, state.origin) in self.symmetry.origins else replace(state, origin=None)

    def label(self, state: ManipulationState) -> frozenset[str]:
        """See `System.label`."""
        return state.label

    def outcomes(self, state: ManipulationState) -> Iterator[tuple[Action, ManipulationState, tuple[Fraction, ...]]]:
        """Yield the applicable actions of a state, in the order of the model, each with its successor and its costs.

        Raises:
            ModelError: an operator yields an action of another kind, or a state that is not of the model.
        """
        told = state.conditions
        barred = {action for conditions, action in self.symmetry.barred if conditions <= told}
        for k, operator in enumerate(self.space.model.operators):
            for action, after in operator.outcomes(self.space.model, state):
                if action.kind != operator.kind:
                    raise ModelError(f"operator {operator.kind!r} yields `{action}`, an action of another kind")
                i, j = (self.space.hand(each, where=f"after `{action}`") for each in (state, after))
                entries = [each.entries[k, i, j] for each in self.costs]
                if str(action) not in barred and UNMEASURED not in entries:
                    origin = state.origin if state.held else state.place.get(after.held or "")
                    costs = tuple(int(entry) * each.unit for entry, each in zip(entries, self.costs, strict=True))
                    yield action, replace(after, origin=origin if after.held else None), costs

    def steps(self, state: ManipulationState, action: str) -> tuple[ManipulationState, tuple[Fraction, ...]]:
        """See `System.steps`.

        Raises:
            ModelError: the action does not exist in that state.
        """
        for each, after, costs in self.outcomes(state):
            if str(each) == action:
                return after, costs
        raise ModelError(f"action {action!r} does not exist in state {state!r}")

    def reduced(self, names: Collection[str], *, stutter_invariant: bool) -> ManipulationSystem:
        """Return a smaller system to search, with the same costs of plans, if only the propositions `names` matter.

        If plans are `stutter_invariant`, leaving out actions that change none of these never makes a plan worse.
        """
        model = self.space.model
        symmetry = Symmetry(model, names, self.symmetry.barred, places_alike=not isinstance(model.costs, MeasuredCosts))
        if stutter_invariant:
            symmetry = symmetry.relevant()
        space = StateCodes(symmetry.model, symmetry.visible, symmetry.origins)
        hands = [self.space.hands.index(hand) for hand in space.hands]
        return replace(
            self,
            start=replace(space.start, origin=self.start.origin),
            costs=tuple(replace(costs, entries=costs.entries[:, hands][:, :, hands]) for costs in self.costs),
            space=space,
            symmetry=symmetry,
        )

    def actions_through(self, codes: Sequence[int]) -> list[str]:
        """Return actions that lead through canonical states, given by their codes; the first is that of the start.

        A larger model that was reduced to this one has the same actions, with the same costs.
        """
        state, actions = self.start, list[str]()
        for wanted in codes[1:]:
            # The successor determines the action's kind and the poses of the hand, and so its cost.
            action, state, _ = next(each for each in self.outcomes(state) if self.canonical(each[1]) == wanted)
            actions.append(str(action))
        return actions
