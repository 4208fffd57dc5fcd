"""The smaller model that is searched in place of a manipulation model (see `prefplan.models.manipulation.symmetry`)."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import cached_property

from prefplan.models.manipulation.action_costs import ActionCosts, MeasuredCosts, cost_names
from prefplan.models.manipulation.codes import StateCodes
from prefplan.models.manipulation.listing import Actions, listed, moves_of, table
from prefplan.models.manipulation.operators import read_action
from prefplan.models.manipulation.state import ManipulationState
from prefplan.models.manipulation.successors import Moves, canonical
from prefplan.models.manipulation.symmetry import Symmetry
from prefplan.models.several_costs import amount
from prefplan.models.system import Barred, Quotient, Trajectory


class ReducedModel:
    """A smaller model that is equivalent to another for the propositions that are seen.

    Attributes:
        symmetry: the smaller model, and which of its parts may be exchanged.
        actions: the actions of the smaller model.
        start: its initial state.
        seen: the propositions that are seen.
        barred: actions that do not exist where some propositions hold.
    """

    def __init__(
        self,
        whole: Actions,
        start: ManipulationState,
        barred: Barred,
        names: Collection[str],
        *,
        stutter_invariant: bool,
    ) -> None:
        """Make a model smaller.

        Args:
            whole: the actions of the other model.
            start: its initial state.
            barred: actions that do not exist where some propositions hold.
            names: the propositions that are seen.
            stutter_invariant: as in `System.quotient`.
        """
        self._whole, self._whole_start, self.barred = whole, start, barred
        model = whole.space.model
        self.seen = frozenset(names).union(*(conditions for conditions, _ in barred))
        actions = [read_action(text) for _, text in barred]
        told = frozenset(name for action in actions for name in (action.obj, action.location))
        alike = not isinstance(model.costs, MeasuredCosts)
        symmetry = Symmetry(model, self.seen, told, places_alike=alike)
        if stutter_invariant and not barred and _loads_cost(model.costs):
            symmetry, start = symmetry.relevant(start)
        self.symmetry, self.start = symmetry, start
        space = StateCodes(symmetry.model, start, symmetry.sees_mark)
        hands = [whole.space.hands.index(hand) for hand in space.hands]
        costs = tuple(matrix.between(hands) for matrix in whole.costs)
        self.actions = Actions(space, whole.operators, costs)

    @property
    def space(self) -> StateCodes:
        """The encoding of its states."""
        return self.actions.space

    @cached_property
    def moves(self) -> Moves:
        """The smaller model as arrays; its codes must be small."""
        return moves_of(self.space, self.symmetry.neutral, self.symmetry.unseen)

    @property
    def first(self) -> int:
        """The code of the canonical state of `start`.

        Raises:
            ModelError: there are too many states for 64-bit integers.
        """
        self.space.require_small()
        return self._canonical(self.start)

    def _canonical(self, state: ManipulationState) -> int:
        return int(canonical(self.moves, self.space.encode(state, where="state")))

    def require_measured(self, code: int) -> None:
        """Raise ModelError if the cost of some action of a state was not measured."""
        self.actions.require_measured(self.space.decode(code))

    def quotient(self) -> Quotient:
        """Return the canonical states, listed."""
        system = table(self.space, listed(self.space, self.moves, self.first), self.actions.costs, self.seen)

        def lift(trajectory: Trajectory) -> Trajectory:
            return self.lift([self.space.encode(state, where="state") for state in trajectory[1]])  # type: ignore[arg-type]

        return Quotient(system.without(self.barred), lift)

    def lift(self, codes: Sequence[int]) -> Trajectory:
        """Return the trajectory of the other model that corresponds to one through canonical states, given by codes."""
        state, actions = self.space.decode(self.space.encode(self.start, where="start")), list[str]()
        for wanted in codes[1:]:
            # The successor determines the action's kind and the poses of the hand, and so its cost.
            action, state = next(each for each in self.actions.of(state) if self._canonical(each[1]) == wanted)
            actions.append(str(action))
        states = [self._whole_start]
        for text in actions:
            states.append(next(after for action, after in self._whole.of(states[-1]) if str(action) == text))
        return tuple(actions), tuple(states)


def _loads_cost(costs: ActionCosts) -> bool:
    """Return whether costs do not depend on locations, and a transport costs at least as much as a transit."""
    if isinstance(costs, MeasuredCosts):
        return False
    return all(amount(costs["transit"], name) <= amount(costs["transport"], name) for name in cost_names(costs))
