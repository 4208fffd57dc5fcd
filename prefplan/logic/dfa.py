"""Minimal DFA of a task's good prefixes (Definition 6), by formula progression.

After reading some labels, what is left of a formula is a positive Boolean combination of subformulas that must hold
from now on, the *obligations*. Such a combination has exactly one irredundant disjunctive form, an *antichain*: a set
of sets of obligations none of which contains another. Antichains are the states. There are finitely many, and every
infinite word that satisfies a co-safe formula reaches the antichain `true` after finitely many letters.

Since g implies f U g, a set with g needs no f U g, and the set {f U g} makes the set {g} redundant. The states of
nested U then are as many as propositions, not as many as sets of these. No word reaches `true` later because of this: g
is met no sooner than f U g. The same holds for F[0,2] g and F[0,5] g.

Transitions are decision diagrams over the formula's propositions: letters are never listed, so a formula may have
many propositions.

A state is *satisfied* when every infinite continuation satisfies the formula, i.e. when no infinite path avoids
`true`. As a state has finitely many successors, that is the least fixpoint of "all successors are satisfied"
(Koenig's lemma). Merging states by partition refinement then gives the minimal automaton.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from itertools import chain, combinations

from prefplan.errors import FormulaError
from prefplan.limits import check_limits
from prefplan.logic.formula import And, BoundedRelease, Formula, Literal, Next, Or, Truth, Until, later, propositions_of
from prefplan.logic.mtbdd import CHECKED_EVERY, Diagram, Diagrams, leaf, leaves, paths
from prefplan.logic.normal_form import parse

STATE_LIMIT = 20_000
"""Progression stops at this many states: the construction is doubly exponential in the worst case."""

DIAGRAMS_CHECKED_EVERY = 16
"""Number of diagrams that are searched for their leaves between two checks of the limits."""

READINGS_TRIED = 2**14
"""Most pairs of a state and a label for which idempotence is decided."""

Antichain = frozenset[frozenset[int]]
"""Sets of obligations, each a number of a subformula."""

_TRUE: Antichain = frozenset({frozenset()})
_FALSE: Antichain = frozenset()


@dataclass(frozen=True)
class Automaton:
    """Deterministic finite automaton A = (Q, q0, 2^AP, delta, F) of a formula's good prefixes (Definition 6).

    States are 0 .. n-1, numbered breadth-first from the initial state 0.

    Attributes:
        text: the formula as it was written.
        propositions: AP, sorted: those that the formula mentions.
        transitions: delta, by state: a decision diagram with states at its leaves.
        accepting: F: the one absorbing state in which the task is satisfied, or None if there is no good prefix.
        dead: the one absorbing state from which the task can no longer be satisfied, or None.
    """

    text: str
    propositions: tuple[str, ...]
    transitions: tuple[Diagram, ...]
    accepting: int | None
    dead: int | None

    @property
    def size(self) -> int:
        """Number of states."""
        return len(self.transitions)

    def step(self, state: int, label: frozenset[str]) -> int:
        """Return the state after reading a label."""
        return leaf(self.transitions[state], label)

    def guards(self, state: int) -> Iterator[tuple[dict[str, bool], int]]:
        """Yield each guard, as the propositions it fixes, with the state it leads to."""
        return paths(self.transitions[state])


def first_accepted(dfa: Automaton, labels: Iterable[frozenset[str]]) -> int | None:
    """Return the first position at which an automaton that reads some labels is in its accepting state, or None."""
    state = 0
    for position, label in enumerate(labels):
        state = dfa.step(state, label)
        if state == dfa.accepting:
            return position
    return None


def is_idempotent(dfa: Automaton) -> bool:
    """Return whether reading any label twice is the same as once; False also if there are too many labels to try.

    If so, the automaton's language is closed under stuttering, as that of every formula without X and bounds is.
    """
    if dfa.size << len(dfa.propositions) > READINGS_TRIED:
        return False
    sizes = range(len(dfa.propositions) + 1)
    labels = map(frozenset, chain.from_iterable(combinations(dfa.propositions, k) for k in sizes))
    return all(
        dfa.step(after, label) == after
        for label in labels
        for after in {dfa.step(state, label) for state in range(dfa.size)}
    )


def automaton(formula: str | Formula, *, text: str = "") -> Automaton:
    """Return the minimal DFA that accepts exactly the good prefixes of a co-safe formula.

    Args:
        formula: the formula, or its text.
        text: text of the formula for messages; if empty, that of `formula`.

    Raises:
        FormulaError: if the text is not a co-safe formula, or its automaton would be too large.
    """
    text = text or str(formula)
    tree = formula if isinstance(formula, Formula) else parse(formula)
    diagrams = Diagrams()
    transitions, goal = _progress(tree, text, diagrams)
    satisfied = set() if goal is None else _unavoidable(transitions, goal)
    return _minimise(transitions, satisfied, diagrams, text, tuple(sorted(propositions_of(tree))))


class _Obligations:
    """The obligations met so far, numbered, and which of them imply which."""

    def __init__(self) -> None:
        self.formulas: list[Formula] = []
        self._weaker: list[set[int]] = []
        self._weaker_than: dict[Formula, set[int]] = {}
        self._until: dict[tuple[Formula, Formula, int], list[tuple[float, int]]] = {}

    def add(self, formula: Formula) -> int:
        """Return the number of a new obligation."""
        number = len(self.formulas)
        self.formulas.append(formula)
        self._weaker.append(self._weaker_than.setdefault(formula, set()))
        if isinstance(formula, Until):
            self._add_until(number, formula)
        return number

    def _add_until(self, number: int, formula: Until) -> None:
        """Record which obligations imply an until, and which it implies."""
        if formula.low == 0:
            for stronger in _stronger(formula.right):
                self._weaker_than.setdefault(stronger, set()).add(number)
        # An until with an upper bound implies the one with a larger bound.
        high = math.inf if formula.high is None else formula.high
        others = self._until.setdefault((formula.left, formula.right, formula.low), [])
        for bound, other in others:
            if bound < high:
                self._weaker[other].add(number)
            else:
                self._weaker[number].add(other)
        others.append((high, number))

    def irredundant(self, clauses: Iterable[frozenset[int]]) -> Antichain:
        """Return the weakest of some sets of obligations, each without those that others in it imply."""
        whole = {clause: self._with_implied(clause) for clause in clauses}
        kept: list[frozenset[int]] = []
        for number, clause in enumerate(sorted(whole, key=lambda one: len(whole[one])), 1):
            if number % CHECKED_EVERY == 0:
                check_limits()
            if not any(other <= whole[clause] for other in kept):
                kept.append(clause)
        return frozenset(map(self._without_implied, kept))

    def _with_implied(self, clause: frozenset[int]) -> frozenset[int]:
        return clause.union(*(self._weaker[number] for number in clause))

    def _without_implied(self, clause: frozenset[int]) -> frozenset[int]:
        return clause.difference(*(self._weaker[number] for number in clause))


def _stronger(formula: Formula) -> frozenset[Formula]:
    """Return obligations within a formula each of which implies it."""
    match formula:
        case And(left, right):
            return _stronger(left) & _stronger(right)
        case Or(left, right):
            return _stronger(left) | _stronger(right)
        case Until(_, right, 0):
            return _stronger(right) | {formula}
    return frozenset({formula})


def _progress(formula: Formula, text: str, diagrams: Diagrams) -> tuple[list[Diagram], int | None]:
    """Return the transitions between antichains, and the number of the antichain `true` if it is reached."""
    met = _Obligations()
    either = diagrams.lift(lambda a, b: met.irredundant(a | b))
    both = diagrams.lift(lambda a, b: met.irredundant({x | y for x in a for y in b}))

    @cache
    def obligations(f: Formula) -> Diagram:
        """Return the antichain of a formula's obligations from the next letter on."""
        match f:
            case Truth(value):
                return _TRUE if value else _FALSE
            case And(left, right):
                return both(obligations(left), obligations(right))
            case Or(left, right):
                return either(obligations(left), obligations(right))
        return frozenset({frozenset({met.add(f)})})

    @cache
    def read(f: Formula) -> Diagram:
        """Return what is left of a formula after one letter, for every letter."""
        match f:
            case Literal(name, positive):
                return diagrams.branch(name, _TRUE if positive else _FALSE, _FALSE if positive else _TRUE)
            case Next(operand):
                return obligations(operand)
            case Until(left, right, low, high):
                goes_on = high is None or high > 0
                waits = both(read(left), obligations(later(f))) if goes_on else _FALSE
                return waits if low else either(read(right), waits)
            case BoundedRelease(left, right, low, high):
                waits = either(read(left), obligations(later(f))) if high else _TRUE
                return waits if low else both(read(right), waits)
            case And(left, right):
                return both(read(left), read(right))
            case Or(left, right):
                return either(read(left), read(right))
        return obligations(f)

    queue: list[Antichain] = [obligations(formula)]  # type: ignore[list-item]
    number = {queue[0]: 0}

    def enter(state: Antichain) -> int:
        if state not in number:
            number[state] = len(queue)
            queue.append(state)
            if len(queue) > STATE_LIMIT:
                raise FormulaError(f"'{text}' needs an automaton of more than {STATE_LIMIT} states")
        return number[state]

    transitions: list[Diagram] = []
    for state in queue:
        after: Diagram = _FALSE
        for clause in sorted(map(sorted, state)):
            together: Diagram = _TRUE
            for obligation in clause:
                together = both(together, read(met.formulas[obligation]))
            after = either(after, together)
        transitions.append(diagrams.map(after, enter))
    return transitions, number.get(_TRUE)


def _unavoidable(transitions: list[Diagram], goal: int) -> set[int]:
    """Return the states from which every infinite path meets the goal."""
    predecessors: list[list[int]] = [[] for _ in transitions]
    missing = []
    for state, diagram in enumerate(transitions):
        if state % DIAGRAMS_CHECKED_EVERY == DIAGRAMS_CHECKED_EVERY - 1:
            check_limits()
        after = leaves(diagram)
        missing.append(len(after))
        for end in after:
            predecessors[end].append(state)
    found, queue = {goal}, [goal]
    for state in queue:
        for before in predecessors[state]:
            missing[before] -= 1
            if missing[before] == 0 and before not in found:
                found.add(before)
                queue.append(before)
    return found


def _minimise(
    transitions: list[Diagram], satisfied: set[int], diagrams: Diagrams, text: str, names: tuple[str, ...]
) -> Automaton:
    """Merge equivalent states by partition refinement and number them breadth-first."""
    goal = min(satisfied, default=None)
    transitions = [goal if state in satisfied else diagram for state, diagram in enumerate(transitions)]
    block = [int(state in satisfied) for state in range(len(transitions))]
    while True:
        into: Callable[[int], int] = block.__getitem__
        keys: dict[tuple[int, Diagram], int] = {}
        refined = [
            keys.setdefault((block[state], diagrams.map(diagram, into)), len(keys))
            for state, diagram in enumerate(transitions)
        ]
        if len(keys) == len(set(block)):
            break
        block = refined
    representative = {b: state for state, b in reversed(list(enumerate(block)))}
    queue, number = [block[0]], {block[0]: 0}
    merged = []
    for b in queue:
        merged.append(diagrams.map(transitions[representative[b]], block.__getitem__))
        for end in leaves(merged[-1]):
            if end not in number:
                number[end] = len(number)
                queue.append(end)
    numbered = tuple(diagrams.map(diagram, number.__getitem__) for diagram in merged)
    accepting = None if goal is None else number[block[goal]]
    dead = next((s for s, diagram in enumerate(numbered) if diagram == s != accepting), None)
    return Automaton(text, names, numbered, accepting, dead)
