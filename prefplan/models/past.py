"""What was done and observed before a plan is made again."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from prefplan.exact_costs import Number, exact, to_number
from prefplan.models.system import System


@dataclass(frozen=True)
class Past:
    """K actions that were taken, each with the observation before it.

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

    @property
    def cost(self) -> Number:
        """The total cost so far."""
        return to_number(sum(map(exact, self.costs), Fraction(0)))

    def along(self, system: System, actions: Sequence[str]) -> tuple[list[frozenset[str]], list[tuple[Fraction, ...]]]:
        """Return the trace of actions that begin with these and go on from a system's start; see `along` there.

        Raises:
            ModelError: if an action is not applicable in its state.
        """
        labels, (first, *more) = system.along(actions[len(self.actions) :])
        return [*self.labels, *labels], [(*map(exact, self.costs), *first), *more]
