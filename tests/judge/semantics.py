"""Whether a trace satisfies a formula, by the definition of LTL (Definition 2) and a tableau of the formula's negation.

A finite trace is a good prefix of f when every infinite continuation satisfies f, that is when none satisfies !f.
With f co-safe, the negation normal form of !f has only literals, `and`, `or`, `X`, `G`, `R`: no eventuality. Its
tableau keeps *clauses*, sets of formulas that the rest of the word must satisfy, and reads a letter by
`G f = f & X G f` and `f R g = g & (f | X (f R g))`.

1. An infinite word satisfies a clause exactly when the tableau has an infinite run over it from that clause: a word
   that satisfies it says which disjunct to follow at each step; and along an infinite run every obligation is met
   step by step, which is all that `G` and `R` ask for.
2. There are finitely many clauses (sets of parts of !f), so some word satisfies a clause exactly when the clause is
   *live*: it reaches a cycle, i.e. survives the removal, again and again, of clauses without a successor.
3. Hence a trace is a good prefix exactly when no live clause can be reached by reading it.

Clauses that contain another of the same set are left out: a word that satisfies them satisfies the smaller one too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from itertools import combinations

from judge.syntax import Formula, is_co_safe, propositions_of

Label = frozenset[str]
Clause = frozenset[Formula]

_NOTHING: frozenset[Clause] = frozenset()
_ANYTHING: frozenset[Clause] = frozenset({frozenset()})


def powerset(items: Iterable[str]) -> list[Label]:
    """Return every subset."""
    pool = sorted(items)
    return [frozenset(chosen) for size in range(len(pool) + 1) for chosen in combinations(pool, size)]


def holds_now(formula: Formula, label: Label) -> bool:
    """Evaluate a formula without temporal operators on one label."""
    kind = formula[0]
    if kind == "ap":
        return formula[1] in label
    values = [holds_now(part, label) for part in formula[1:]]
    return {
        "true": lambda: True,
        "false": lambda: False,
        "not": lambda: not values[0],
        "and": lambda: all(values),
        "or": lambda: any(values),
        "implies": lambda: not values[0] or values[1],
    }[kind]()


def holds(formula: Formula, stem: Sequence[Label], loop: Sequence[Label]) -> bool:
    """Evaluate a formula on the infinite word stem loop loop loop ..., straight from the definition of LTL."""
    word = [*stem, *loop]
    following = [*range(1, len(word)), len(stem)]

    def until(left: list[bool], right: list[bool]) -> list[bool]:
        values = right
        for _ in word:
            values = [right[k] or (left[k] and values[following[k]]) for k in range(len(word))]
        return values

    def evaluate(part: Formula) -> list[bool]:
        kind = part[0]
        if kind in {"true", "false", "ap"}:
            return [holds_now(part, label) for label in word]
        first = evaluate(part[1])
        if kind == "not":
            return [not value for value in first]
        if kind == "X":
            return [first[k] for k in following]
        if kind == "F":
            return until([True] * len(word), first)
        second = evaluate(part[2])
        if kind == "U":
            return until(first, second)
        combine: dict[str, Callable[[bool, bool], bool]] = {
            "and": lambda x, y: x and y,
            "or": lambda x, y: x or y,
            "implies": lambda x, y: not x or y,
        }
        return [combine[kind](x, y) for x, y in zip(first, second, strict=True)]

    return evaluate(formula)[0]


def normal(formula: Formula, *, negated: bool) -> Formula:
    """Return the formula, or its negation, with `!` at the atoms only, over literals, and, or, X, G, R."""
    kind = formula[0]
    if kind in {"true", "false"}:
        return ("true",) if (kind == "true") != negated else ("false",)
    if kind == "ap":
        return ("literal", formula[1], not negated)
    if kind == "not":
        return normal(formula[1], negated=not negated)
    if kind == "implies":
        left, right = normal(formula[1], negated=not negated), normal(formula[2], negated=negated)
        return ("and" if negated else "or", left, right)
    if kind in {"and", "or"}:
        dual = {"and": "or", "or": "and"}[kind] if negated else kind
        return (dual, normal(formula[1], negated=negated), normal(formula[2], negated=negated))
    if not negated:
        raise ValueError(f"{kind} stands where a formula without temporal operators should")
    if kind == "U":
        return ("R", normal(formula[1], negated=True), normal(formula[2], negated=True))
    return ({"X": "X", "F": "G"}[kind], normal(formula[1], negated=True))


def _smallest(clauses: Iterable[Clause]) -> frozenset[Clause]:
    kept: list[Clause] = []
    for clause in sorted(set(clauses), key=len):
        if not any(other <= clause for other in kept):
            kept.append(clause)
    return frozenset(kept)


def _both(first: frozenset[Clause], second: frozenset[Clause]) -> frozenset[Clause]:
    return _smallest(one | other for one in first for other in second)


class Monitor:
    """Reads a trace letter by letter and detects when it is a good prefix of a co-safe formula.

    States are integers, `start` before anything is read. Two traces in the same state have the same continuations.
    """

    def __init__(self, formula: Formula) -> None:
        """Build the tableau of the negation; raises ValueError when the formula is not co-safe."""
        if not is_co_safe(formula):
            raise ValueError("not a co-safe formula")
        self.propositions = propositions_of(formula)
        self._expansions: dict[tuple[Formula, Label], frozenset[Clause]] = {}
        self._successors: dict[tuple[Clause, Label], frozenset[Clause]] = {}
        first = frozenset({normal(formula, negated=True)})
        self._live = self._live_clauses(first)
        self._sets: list[frozenset[Clause]] = []
        self._numbers: dict[frozenset[Clause], int] = {}
        self._steps: dict[tuple[int, Label], int] = {}
        self.start = self._number(_smallest({first} & self._live))

    def satisfied(self, state: int) -> bool:
        """Say whether every continuation satisfies the formula."""
        return not self._sets[state]

    def step(self, state: int, label: Label) -> int:
        """Return the state after reading one more label."""
        key = (state, label)
        if key not in self._steps:
            letter = label & self.propositions
            reached = (self._successors_of(clause, letter) for clause in self._sets[state])
            self._steps[key] = self._number(_smallest(_NOTHING.union(*reached) & self._live))
        return self._steps[key]

    def _number(self, clauses: frozenset[Clause]) -> int:
        if clauses not in self._numbers:
            self._numbers[clauses] = len(self._sets)
            self._sets.append(clauses)
        return self._numbers[clauses]

    def _live_clauses(self, first: Clause) -> frozenset[Clause]:
        letters = powerset(self.propositions)
        followers: dict[Clause, set[Clause]] = {}
        pending = [first]
        while pending:
            clause = pending.pop()
            if clause not in followers:
                followers[clause] = set().union(*(self._successors_of(clause, letter) for letter in letters))
                pending.extend(followers[clause])
        live = set(followers)
        while dead := {clause for clause in live if not followers[clause] & live}:
            live -= dead
        return frozenset(live)

    def _successors_of(self, clause: Clause, letter: Label) -> frozenset[Clause]:
        key = (clause, letter)
        if key not in self._successors:
            reached = _ANYTHING
            for part in clause:
                reached = _both(reached, self._expand(part, letter))
            self._successors[key] = reached
        return self._successors[key]

    def _expand(self, part: Formula, letter: Label) -> frozenset[Clause]:
        """Return what may be left to satisfy after a letter is read with `part` to be satisfied."""
        key = (part, letter)
        if key not in self._expansions:
            self._expansions[key] = self._expand_new(part, letter)
        return self._expansions[key]

    def _expand_new(self, part: Formula, letter: Label) -> frozenset[Clause]:
        kind, again = part[0], frozenset({frozenset({part})})
        if kind == "literal":
            return _ANYTHING if (part[1] in letter) == part[2] else _NOTHING
        if kind in {"true", "false"}:
            return _ANYTHING if kind == "true" else _NOTHING
        if kind == "X":
            return frozenset({frozenset({part[1]})})
        if kind == "G":
            return _both(self._expand(part[1], letter), again)
        if kind == "and":
            return _both(self._expand(part[1], letter), self._expand(part[2], letter))
        if kind == "or":
            return _smallest(self._expand(part[1], letter) | self._expand(part[2], letter))
        return _both(self._expand(part[2], letter), _smallest(self._expand(part[1], letter) | again))


@cache
def monitor(formula: Formula) -> Monitor:
    """Return the monitor of a formula, built once."""
    return Monitor(formula)


def satisfaction_index(formula: Formula, trace: Sequence[Label]) -> int | None:
    """Return the smallest k for which trace[:k + 1] is a good prefix, or None."""
    judge = monitor(formula)
    state = judge.start
    for k, label in enumerate(trace):
        state = judge.step(state, label)
        if judge.satisfied(state):
            return k
    return None
