"""Minimal DFA of a task's good prefixes (Definition 6), by formula progression.

After reading some labels, what is left of a formula is a positive Boolean combination of *obligations*: subformulas
that must hold from now on. Such a combination has exactly one irredundant disjunctive form, an *antichain*: a set of
sets of obligations, none of which contains another. The states are antichains. There are finitely many, and every
infinite word that satisfies a co-safe formula reaches the antichain `true` after finitely many letters.

Implied obligations are redundant. As g implies f U g, a set that contains g needs no f U g, and the set {f U g} makes
the set {g} redundant. Nested U then need as many states as propositions, not as many as sets of propositions. No word
reaches `true` later because of this: f U g is met as soon as g is. The same holds for F[0,2] g and F[0,5] g.

Transitions are decision diagrams over the formula's propositions. Letters are never listed, so a formula may have many
propositions.

A state is *satisfied* when every infinite continuation satisfies the formula, i.e. when no infinite path avoids `true`.
As a state has finitely many successors, these states are the least fixpoint of "all successors are satisfied" (Koenig's
lemma). Partition refinement then merges states to the minimal automaton.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from itertools import accumulate

from prefplan.errors import FormulaError
from prefplan.limits import check_limits
from prefplan.logic.formula import (
    And,
    BoundedRelease,
    Formula,
    Literal,
    Or,
    Truth,
    Until,
    counts_steps,
    later,
    propositions_of,
)
from prefplan.logic.mtbdd import CHECKED_EVERY, Diagram, Diagrams, leaf, paths
from prefplan.logic.normal_form import parse

STATE_LIMIT = 20_000
"""Progression stops at this many states: the construction is doubly exponential in the worst case."""

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
        propositions: AP: the propositions that the formula mentions, sorted.
        transitions: delta: for each state, a decision diagram with states as leaves.
        accepting: F: the one absorbing state in which the task is satisfied, or None if there is no good prefix.
        dead: the one absorbing state from which the task can no longer be satisfied, or None.
        stutter_invariant: whether the formula counts no steps, so that reading a label once more changes nothing.
    """

    text: str
    propositions: tuple[str, ...]
    transitions: tuple[Diagram, ...]
    accepting: int | None
    dead: int | None
    stutter_invariant: bool

    @property
    def size(self) -> int:
        """Number of states."""
        return len(self.transitions)

    def step(self, state: int, label: frozenset[str]) -> int:
        """Return the state after reading a label."""
        return leaf(self.transitions[state], label)

    def run(self, labels: Iterable[frozenset[str]]) -> tuple[int, ...]:
        """Return the state after each of some labels."""
        return tuple(accumulate(labels, self.step, initial=0))[1:]

    def first_accepted(self, labels: Iterable[frozenset[str]]) -> int | None:
        """Return the index of the first label after which the state is accepting; None if there is none."""
        states = self.run(labels)
        return states.index(self.accepting) if self.accepting in states else None

    def guards(self, state: int) -> Iterator[tuple[dict[str, bool], int]]:
        """Yield each guard, as the propositions it fixes, with the state it leads to."""
        return paths(self.transitions[state])


def automaton(formula: str | Formula, *, text: str = "") -> Automaton:
    """Return the minimal DFA that accepts exactly the good prefixes of a formula; `text` is for messages.

    Raises:
        FormulaError: if the text is not a co-safe formula, or its automaton would be too large.
    """
    text = text or str(formula)
    tree = formula if isinstance(formula, Formula) else parse(formula)
    diagrams = Diagrams()
    transitions, successors, goal = _progress(tree, text, diagrams)
    satisfied = set() if goal is None else _unavoidable(successors, goal)
    merged, classes = _minimise(transitions, satisfied, diagrams)
    accepting = None if goal is None else classes[goal]
    dead = next((state for state, diagram in enumerate(merged) if diagram == state != accepting), None)
    names = tuple(sorted(propositions_of(tree)))
    return Automaton(text, names, tuple(merged), accepting, dead, not counts_steps(tree))


class _Progression:
    """Formula progression: numbers the obligations, and finds what is left of a formula after one letter."""

    def __init__(self, diagrams: Diagrams) -> None:
        self.formulas: list[Formula] = []
        self._branch = diagrams.branch
        self._either = diagrams.lift(lambda a, b: self._irredundant(a | b))
        self._both = diagrams.lift(lambda a, b: self._irredundant({x | y for x in a for y in b}))
        self._implies = cache(lambda one, other: implies(self.formulas[one], self.formulas[other]))
        self.asked, self._read = cache(self._asked), cache(self._rest)

    def after(self, state: Antichain) -> Diagram:
        """Return what is left of a state after one letter, for every letter."""
        clauses = [[self._read(self.formulas[k]) for k in clause] for clause in sorted(map(sorted, state))]
        return self._either(_FALSE, *(self._both(_TRUE, *clause) for clause in clauses))

    def _asked(self, f: Formula) -> Diagram:
        """Return the antichain of a formula's obligations from the next letter on."""
        match f:
            case Truth(value):
                return _TRUE if value else _FALSE
            case And(operands):
                return self._both(*map(self.asked, operands))
            case Or(operands):
                return self._either(*map(self.asked, operands))
        self.formulas.append(f)
        return frozenset({frozenset({len(self.formulas) - 1})})

    def _rest(self, f: Formula) -> Diagram:
        """Return what is left of a formula after one letter, for every letter."""
        match f:
            case Literal(name, positive):
                return self._branch(name, _TRUE if positive else _FALSE, _FALSE if positive else _TRUE)
            case And(operands):
                return self._both(*map(self._read, operands))
            case Or(operands):
                return self._either(*map(self._read, operands))
            case Until(left, right, low):
                waits = self._both(self._read(left), self.asked(later(f)))
                return waits if low else self._either(self._read(right), waits)
            case BoundedRelease(left, right, low):
                waits = self._either(self._read(left), self.asked(later(f)))
                return waits if low else self._both(self._read(right), waits)
        return self.asked(f)

    def _irredundant(self, clauses: Iterable[frozenset[int]]) -> Antichain:
        """Return the weakest of some sets of obligations, each without the obligations that others in the set imply."""
        clauses = list(clauses)
        numbers = frozenset[int]().union(*clauses)
        weaker = {one: {other for other in numbers if other != one and self._implies(one, other)} for one in numbers}
        implied = {clause: clause.union(*(weaker[number] for number in clause)) for clause in clauses}
        kept: list[frozenset[int]] = []
        for number, clause in enumerate(sorted(implied, key=lambda one: len(implied[one])), 1):
            if number % CHECKED_EVERY == 0:
                check_limits()
            if not any(other <= implied[clause] for other in kept):
                kept.append(clause)
        return frozenset(clause.difference(*(weaker[number] for number in clause)) for clause in kept)


def implies(one: Formula, other: Formula) -> bool:
    """Return whether the operators show that an obligation implies a formula."""
    match other:
        case And(operands):
            return all(implies(one, operand) for operand in operands)
        case Or(operands):
            return any(implies(one, operand) for operand in operands)
        case Until(left, right, low, high):
            if isinstance(one, Until) and (one.left, one.right, one.low) == (left, right, low):
                return high is None or (one.high is not None and one.high <= high)
            return low == 0 and implies(one, right)
    return one == other


def _progress(formula: Formula, text: str, diagrams: Diagrams) -> tuple[list[Diagram], list[set[int]], int | None]:
    """Return the transitions between antichains, their successors, and the number of `true` if it is reached."""
    progression = _Progression(diagrams)
    queue: list[Antichain] = [progression.asked(formula)]  # type: ignore[list-item]
    number = {queue[0]: 0}

    def enter(state: Antichain) -> int:
        if state not in number:
            number[state] = len(queue)
            queue.append(state)
            if len(queue) > STATE_LIMIT:
                raise FormulaError(f"'{text}' needs an automaton of more than {STATE_LIMIT} states")
        successors[-1].add(number[state])
        return number[state]

    transitions: list[Diagram] = []
    successors: list[set[int]] = []
    for state in queue:
        successors.append(set())
        transitions.append(diagrams.map(progression.after(state), enter))
    return transitions, successors, number.get(_TRUE)


def _unavoidable(successors: list[set[int]], goal: int) -> set[int]:
    """Return the states from which every infinite path meets the goal."""
    met, size = {goal}, 0
    while len(met) > size:
        size = len(met)
        # Successors usually have larger numbers, so one or two passes are enough.
        for state in reversed(range(len(successors))):
            if successors[state] <= met:
                met.add(state)
    return met


def _minimise(transitions: list[Diagram], satisfied: set[int], diagrams: Diagrams) -> tuple[list[Diagram], list[int]]:
    """Return the transitions between classes of equivalent states, and the class of each state.

    Partition refinement (Moore). Classes are numbered by their first states, hence breadth-first, too.
    """
    classes: list[int] = []
    refined = [int(state in satisfied) for state in range(len(transitions))]
    while refined != classes:
        classes, rows = refined, dict[tuple[int, Diagram], int]()
        into: Callable[[int], int] = classes.__getitem__
        keys = ((classes[state], diagrams.map(diagram, into)) for state, diagram in enumerate(transitions))
        refined = [rows.setdefault(key, len(rows)) for key in keys]
    return [diagram for _, diagram in rows], classes
