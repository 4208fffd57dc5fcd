"""Weighted DFAs of tasks that may be relaxed (the paper's Remarks 1 to 6), and of rules.

Besides the transitions of the task's automaton there are those that relaxations allow: a label is read as if more
propositions were true, for a price. A task that may be skipped has one more state, entered before the first action.

The automaton of a rule has no state in which the rule is broken, so that nothing leads there, or one, at a price.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from prefplan.logic.dfa import Automaton
from prefplan.logic.formula import Formula, holds, propositions_of
from prefplan.logic.mtbdd import cheapest_leaves


@dataclass(frozen=True)
class Reading:
    """One way to read a label.

    Attributes:
        state: automaton state afterwards.
        price: violation cost in units.
        relaxations: those used, by number.
    """

    state: int
    price: int = 0
    relaxations: tuple[int, ...] = ()


@dataclass(frozen=True)
class WeightedAutomaton:
    """A task's automaton with relaxations.

    Attributes:
        automaton: the task's minimal DFA; its states are 0 .. n-1.
        relaxations: (assumed proposition, condition, price in units) each.
        skip: price in units of the extra state n, or None.
    """

    automaton: Automaton
    relaxations: tuple[tuple[str, Formula, int], ...] = ()
    skip: int | None = None

    @property
    def size(self) -> int:
        """Number of states, including the skipped one."""
        return self.automaton.size + (self.skip is not None)

    @property
    def skipped(self) -> int | None:
        """The state of a skipped task, None if the task may not be skipped."""
        return None if self.skip is None else self.automaton.size

    @property
    def propositions(self) -> frozenset[str]:
        """The propositions on which readings depend."""
        conditions = (propositions_of(when) | {assumed} for assumed, when, _ in self.relaxations)
        return frozenset(self.automaton.propositions).union(*conditions)

    def readings(self, state: int, label: frozenset[str]) -> list[Reading]:
        """Return the free reading of a label, then the cheapest one with relaxations for each other state.

        Nothing is relaxed once the task is satisfied or skipped. Ties go to fewer relaxations, then to the order in
        which they were written.
        """
        if state == self.skipped:
            return [Reading(state)]
        free = Reading(self.automaton.step(state, label))
        if state == self.automaton.accepting:
            return [free]
        offers: dict[str, tuple[int, int]] = {}
        for i, (assumed, when, price) in enumerate(self.relaxations):
            if assumed not in label and holds(when, label):
                offers[assumed] = min(offers.get(assumed, (price, i)), (price, i))
        if not offers:
            return [free]
        cheapest = cheapest_leaves(self.automaton.transitions[state], label, offers)
        relaxed = [Reading(after, price, used) for after, (price, _, used) in cheapest.items() if after != free.state]
        return [free, *sorted(relaxed, key=lambda reading: (len(reading.relaxations), reading.relaxations))]


@dataclass(frozen=True)
class RuleAutomaton:
    """A rule's automaton: the live states of its monitor and, if the rule may be broken, a last state for good.

    Attributes:
        monitor: the DFA of its bad prefixes.
        price: violation cost in units of breaking it; None if no plan may.
    """

    monitor: Automaton
    price: int | None = None

    @cached_property
    def _states(self) -> list[int]:
        """The monitor's states, the accepting one last."""
        return sorted(range(self.monitor.size), key=lambda q: (q == self.monitor.accepting, q))

    @property
    def size(self) -> int:
        """Number of states."""
        return self.monitor.size - (self.price is None and self.monitor.accepting is not None)

    @property
    def propositions(self) -> frozenset[str]:
        """The propositions on which readings depend."""
        return frozenset(self.monitor.propositions)

    def readings(self, state: int | None, label: frozenset[str]) -> list[Reading]:
        """Return the one reading of a label, or none if no plan may break the rule like this; state None is the start.

        Some rules are broken by whatever is read first; their monitors begin in the accepting state.
        """
        after = self._states.index(self.monitor.step(0 if state is None else self._states[state], label))
        if self._states[after] != self.monitor.accepting or after == state:
            return [Reading(after)]
        return [] if self.price is None else [Reading(after, self.price)]


Follower = WeightedAutomaton | RuleAutomaton
"""An automaton of the product."""
