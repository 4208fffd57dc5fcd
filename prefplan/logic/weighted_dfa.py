"""Weighted DFAs of tasks that may be relaxed (the paper's Remarks 1 to 6), and of rules.

Relaxations add transitions to the task's automaton: for a price, a label is read as if more propositions were true. A
task that may be skipped has one more state, entered before the first action.

A rule's automaton accepts its bad prefixes: its accepting state is entered at a price, or never.
"""

from dataclasses import dataclass

from prefplan.logic.dfa import Automaton
from prefplan.logic.formula import Formula, holds, propositions_of
from prefplan.logic.mtbdd import cheapest_leaves


@dataclass(frozen=True)
class Reading:
    """One way to read a label.

    Attributes:
        state: automaton state afterwards.
        price: violation cost in units.
        relaxations: numbers of the relaxations used.
    """

    state: int
    price: int = 0
    relaxations: tuple[int, ...] = ()


@dataclass(frozen=True)
class WeightedAutomaton:
    """The automaton of a task, with relaxations, or of a rule.

    Attributes:
        automaton: the minimal DFA of the task's good or the rule's bad prefixes; its states are 0 .. n-1.
        relaxations: (assumed proposition, condition, price in units) each.
        skip: price of skipping the task, in units, by the extra state n; None if it may not be skipped.
        price: price of entering the accepting state, in units: 0 for a task; None for a rule that no plan may break.
    """

    automaton: Automaton
    relaxations: tuple[tuple[str, Formula, int], ...] = ()
    skip: int | None = None
    price: int | None = 0

    @property
    def size(self) -> int:
        """Number of states, including the skipped one."""
        return self.automaton.size + (self.skip is not None)

    @property
    def live(self) -> int:
        """Number of states that a plan may enter: all but the accepting state of a rule that no plan may break."""
        return self.size - (self.price is None and self.automaton.accepting is not None)

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
        """Return the reading of a label without relaxations, then the cheapest with relaxations to each other state.

        There is no reading where the label would break a rule that no plan may break. Nothing is relaxed once the task
        is satisfied or skipped. Ties go to fewer relaxations, then to the order in which they were written.
        """
        if state in (self.skipped, self.automaton.accepting):
            return [Reading(state)]
        free = Reading(self.automaton.step(state, label))
        if free.state == self.automaton.accepting and self.price != 0:
            return [] if self.price is None else [Reading(free.state, self.price)]
        offers: dict[str, tuple[int, int]] = {}
        for i, (assumed, when, price) in enumerate(self.relaxations):
            if assumed not in label and holds(when, label):
                offers[assumed] = min(offers.get(assumed, (price, i)), (price, i))
        if not offers:
            return [free]
        cheapest = cheapest_leaves(self.automaton.transitions[state], label, offers)
        relaxed = [Reading(after, price, used) for after, (price, _, used) in cheapest.items() if after != free.state]
        return [free, *sorted(relaxed, key=lambda reading: (len(reading.relaxations), reading.relaxations))]
