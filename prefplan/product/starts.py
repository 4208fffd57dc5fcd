"""The starts of a search: in what ways the automata may have read the labels up to the system's start."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, product

from prefplan.errors import ModelError
from prefplan.exact_costs import exact
from prefplan.logic.weighted_dfa import WeightedAutomaton
from prefplan.problem import Problem

READINGS_LIMIT = 2**20
"""Most readings of one label (each task relaxed or not) that the search enumerates."""


@dataclass(frozen=True)
class Start:
    """An initial state of the automata, with what was spent and price before the first action.

    Attributes:
        automata: (N + R,) states of the automata of N tasks and R rules, after the labels of the past and L(s0).
        spent: the first cost of the past, in units.
        finished: (N,) by task, what of that was spent when it was satisfied; None if it was not.
        violations: (P,) violation costs in units, of tasks and of rules that may be broken.
        relaxed: (N,) by task, the labels read with relaxations, by number, and those; None for a task that is skipped.
    """

    automata: tuple[int, ...]
    spent: int
    finished: tuple[int | None, ...]
    violations: tuple[int, ...]
    relaxed: tuple[tuple[tuple[int, int], ...] | None, ...]

    def task_costs(self, cost: int) -> list[int]:
        """Return (N,) the tasks' costs so far, in units of that cost: the past has the first cost only."""
        return [0 if cost else self.spent if c is None else c for c in self.finished]


@dataclass(frozen=True)
class _History:
    """One way in which a task's automaton may have read the past and L(s0); `finished` counts labels."""

    state: int = 0
    finished: int | None = None
    price: int = 0
    relaxed: tuple[tuple[int, int], ...] | None = ()


def starts_of(problem: Problem) -> tuple[Start, ...]:
    """Return the starts: one for each choice of skipped tasks and each way to read the past and L(s0).

    Raises:
        ModelError: if there are too many.
    """
    labels = [*problem.past.labels, problem.system.label(problem.system.start)]
    automata = problem.followers[len(problem.tasks) :]
    rules = [after for dfa in automata if (after := _rule_after(dfa, labels)) is not None]
    if len(rules) < len(automata):
        return ()
    histories = [_histories(dfa, labels, any_price=problem.is_general) for dfa in problem.weighted_automata]
    count = math.prod(map(len, histories))
    if count > READINGS_LIMIT:
        raise ModelError(
            f"the start can be read in {count:,} ways, each task skipped, relaxed or neither; "
            f"at most {READINGS_LIMIT:,} can be searched: let fewer tasks have skip or relax"
        )
    unit = problem.units.cost
    spent = list(accumulate((int(exact(cost) / unit) for cost in problem.past.costs), initial=0))
    states, tolls = [q for q, _ in rules], [price for _, price in rules]
    return tuple(
        Start(
            (*(history.state for history in each), *states),
            spent[-1],
            tuple(None if history.finished is None else spent[history.finished] for history in each),
            (*(history.price for history in each), *tolls[: len(problem.priced) - len(problem.tasks)]),
            tuple(history.relaxed for history in each),
        )
        for each in product(*histories)
    )


def _histories(dfa: WeightedAutomaton, labels: Sequence[frozenset[str]], *, any_price: bool) -> list[_History]:
    """Return how a task may have read some labels: of ways that lead to the same, the cheapest, or of any price."""
    histories = [_History()]
    for k, label in enumerate(labels):
        best: dict[tuple[int, int | None, int], _History] = {}
        for before in histories:
            for reading in dfa.readings(before.state, label):
                ends = before.finished is None and reading.state == dfa.automaton.accepting
                finished, price = k if ends else before.finished, before.price + reading.price
                relaxed = (*(before.relaxed or ()), *((k, relaxation) for relaxation in reading.relaxations))
                key = (reading.state, finished, price if any_price else 0)
                if key not in best or price < best[key].price:
                    best[key] = _History(reading.state, finished, price, relaxed)
        histories = list(best.values())
    if dfa.skip is not None and dfa.skipped is not None:
        histories.append(_History(dfa.skipped, None, dfa.skip, None))
    return histories


def _rule_after(dfa: WeightedAutomaton, labels: Sequence[frozenset[str]]) -> tuple[int, int] | None:
    """Return the state of a rule's automaton after some labels, and its price; None if no plan may break it so."""
    # Some rules are broken by whatever is read first: then this is no step to the accepting state.
    state = dfa.automaton.run(labels)[-1]
    price = dfa.price if state == dfa.automaton.accepting else 0
    return None if price is None else (state, price)
