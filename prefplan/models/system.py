"""Weighted transition systems (Definition 1), whether or not their states are listed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Hashable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from prefplan.drawing.cell_map import CellMap
from prefplan.exact_costs import Number, to_number
from prefplan.text.names import DisplayNames

if TYPE_CHECKING:
    from prefplan.models.transition_system import TransitionSystem

Barred = Collection[tuple[frozenset[str], str]]
"""(propositions, action): the action does not exist in states where all the propositions hold."""

Trajectory = tuple[tuple[str, ...], tuple[Hashable, ...]]
"""(K,) actions, and the (K + 1,) states before the first action and after each."""


@dataclass(frozen=True)
class Quotient:
    """A smaller system that has, for some propositions, the same plans with the same costs as another.

    Attributes:
        system: the smaller system.
        lift: maps a trajectory of the smaller system to one of the other, with the same costs and propositions.
    """

    system: TransitionSystem
    lift: Callable[[Trajectory], Trajectory]


class System(ABC):
    """A weighted transition system T = (S, s0, A, delta, c, AP, L) (Definition 1).

    A state is whatever the system uses for one: a number if states are listed.

    Attributes:
        start: s0.
        propositions: every name that a formula over this system may use.
        resolution: costs were rounded to multiples of this, in the user's units; None if they were not rounded.
        map: of a grid, for pictures.
        display: what people are shown in place of names of objects and locations in actions.
    """

    start: Any
    propositions: frozenset[str]
    resolution: Fraction | None
    map: CellMap | None
    display: DisplayNames

    @property
    @abstractmethod
    def is_large(self) -> bool:
        """Whether there may be too many states to list."""

    @property
    @abstractmethod
    def listed(self) -> TransitionSystem:
        """The same system with all its states listed."""

    @property
    @abstractmethod
    def cost_names(self) -> tuple[str, ...]:
        """The names of the costs."""

    @property
    @abstractmethod
    def shared_units(self) -> tuple[Fraction, ...]:
        """For each cost, the largest unit of which all its values are multiples, in the user's units."""

    @property
    @abstractmethod
    def greatest_costs(self) -> tuple[Fraction, ...]:
        """For each cost, a bound of what a plan costs that meets no state twice, in the user's units."""

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

    def along(self, actions: Iterable[str]) -> tuple[list[frozenset[str]], list[tuple[Fraction, ...]]]:
        """Return the trace of K actions from the start, (K + 1,) labels, and for each cost its (K,) values.

        Raises:
            ModelError: if an action is not applicable in its state.
        """
        state, costs, labels = self.start, list[tuple[Fraction, ...]](), [self.label(self.start)]
        for action in actions:
            state, each = self.steps(state, action)
            costs.append(each)
            labels.append(self.label(state))
        return labels, [tuple(each[d] for each in costs) for d in range(len(self.cost_names))]

    @abstractmethod
    def with_first_cost(self) -> System:
        """Return the system without its further costs."""

    @abstractmethod
    def knowing(self, propositions: frozenset[str]) -> System:
        """Return the system with other `propositions`."""

    @abstractmethod
    def without(self, barred: Barred) -> System:
        """Return the system without some actions in some states; see `Barred`."""

    @abstractmethod
    def quotient(self, names: Collection[str], *, stutter_invariant: bool) -> Quotient:
        """Return a system to search in place of this one if only some propositions matter.

        Args:
            names: the propositions that matter.
            stutter_invariant: whether actions that change none of them may be left out, which never makes a plan worse.
        """
