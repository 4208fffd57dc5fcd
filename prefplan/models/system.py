"""Weighted transition systems (Definition 1), whether or not their states are listed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Self

from prefplan.exact_costs import Number, exact, to_number
from prefplan.models.costs import CostTable
from prefplan.text.names import DisplayNames

if TYPE_CHECKING:
    from prefplan.models.transition_system import TransitionSystem

Trajectory = tuple[tuple[str, ...], tuple[Hashable, ...], list[frozenset[str]], list[tuple[Fraction, ...]]]
"""K actions, the K + 1 states along them, the K + 1 labels of these states, and for each cost its K values."""


@dataclass(frozen=True, kw_only=True)
class System(ABC):
    """A weighted transition system T = (S, s0, A, delta, c, AP, L) (Definition 1).

    The type of states depends on the system: numbers if states are listed.

    Attributes:
        start: s0.
        costs: every cost of the actions, the first one first.
        propositions: every name that a formula over this system may use.
        resolution: costs were rounded to multiples of this, in the user's units; None if they were not rounded.
        left_out: a sentence on the actions left out because their costs could not be measured; empty if there are none.
        display: names to display for the objects and locations in actions.
    """

    start: Any
    costs: tuple[CostTable, ...]
    propositions: frozenset[str]
    resolution: Fraction | None = None
    left_out: str = ""
    display: DisplayNames = DisplayNames()

    @property
    @abstractmethod
    def listed(self) -> TransitionSystem:
        """The same system with all its states listed."""

    @property
    @abstractmethod
    def small(self) -> TransitionSystem | None:
        """The same as `listed` if the system is small enough to be searched like this; else None."""

    @property
    @abstractmethod
    def most_states(self) -> int:
        """An upper bound of the number of states."""

    @property
    def cost_names(self) -> tuple[str, ...]:
        """The names of the costs."""
        return tuple(table.name for table in self.costs)

    @abstractmethod
    def decode(self, state: Any) -> Hashable:
        """Return the name of a state in plans."""

    @abstractmethod
    def label(self, state: Any) -> frozenset[str]:
        """Return L(state): the propositions true in a state."""

    @abstractmethod
    def steps(self, state: Any, action: str) -> tuple[Any, tuple[Fraction, ...]]:
        """Return the state that an action leads to, and every cost of it in the user's units.

        Raises:
            ModelError: if the action does not exist in that state.
        """

    def step(self, state: Any, action: str) -> tuple[Any, Number]:
        """Return the same as `steps`, with the first cost alone."""
        target, costs = self.steps(state, action)
        return target, to_number(costs[0])

    def trajectory(self, actions: Iterable[str]) -> Trajectory:
        """Return the trajectory of K actions from the start.

        Raises:
            ModelError: if an action is not applicable in its state.
        """
        states, actions, costs = [self.start], tuple(actions), list[tuple[Fraction, ...]]()
        for action in actions:
            state, each = self.steps(states[-1], action)
            states.append(state)
            costs.append(each)
        columns = [tuple(each[d] for each in costs) for d in range(len(self.costs))]
        return actions, tuple(map(self.decode, states)), list(map(self.label, states)), columns

    def after(self, states: Sequence[Hashable]) -> Self:
        """Return the system with what its start must remember of the states before it, given by name."""
        return self


@dataclass(frozen=True)
class Past:
    """The K actions of an execution before replanning, each with the observation before it.

    Attributes:
        actions: (K,) in order.
        costs: (K,) cost of each, whether or not it succeeded.
        states: (K,) state before each; the first is the initial state.
        labels: (K,) the propositions that held in these states.
    """

    actions: tuple[str, ...] = ()
    costs: tuple[Number, ...] = ()
    states: tuple[Hashable, ...] = ()
    labels: tuple[frozenset[str], ...] = ()

    def along(self, system: System, actions: Sequence[str]) -> Trajectory:
        """Return the trajectory of actions that begin with the past and go on from a system's start.

        Raises:
            ModelError: if an action is not applicable in its state.
        """
        _, states, labels, (first, *more) = system.trajectory(actions[len(self.actions) :])
        costs = [(*map(exact, self.costs), *first), *more]
        return tuple(actions), (*self.states, *states), [*self.labels, *labels], costs
