"""Whether a finite trace of labels satisfies a co-safe formula, decided on the formula itself.

A trace satisfies a formula if it is a *good prefix*: every infinite continuation satisfies the formula. So this module
searches for a continuation that falsifies the formula. To falsify a formula at a position:

- `a`: a does not hold there; `!a`: it does
- `f & g`: falsify f or falsify g
- `f | g`: falsify both
- `f U g`: falsify g, and either falsify f or falsify `f U g` at the next position
- `f R g`, bounded: falsify g, or falsify f and falsify `f R g` at the next position

A counting operator counts down: `f U[2,5] g` becomes `f U[1,4] g` at the next position, and `f U[0,1] g` becomes g;
g is not read before its lower bound is 0.

An obligation may be passed on to the next position for ever, so a word falsifies the formula exactly if obligations can
be passed on at every position. There are finitely many sets of obligations: such a word exists exactly if a set recurs.

The automata that the search follows share only the formulas with this module, so that each can check the other.
"""

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from copy import copy
from functools import cache
from itertools import tee

from prefplan.logic.formula import And, BoundedRelease, Formula, Literal, Or, Truth, Until, later, propositions_of

Label = frozenset[str]

_ObligationSet = frozenset[Formula]
"""Formulas to falsify from some position on."""


def satisfied_at(formula: Formula, trace: Sequence[Label]) -> int | None:
    """Return the first position whose label makes the trace up to it satisfy a formula, or None."""
    # Every continuation of a good prefix is a good prefix, too.
    position = bisect_left(range(len(trace)), True, key=lambda k: is_satisfied(formula, trace[: k + 1]))
    return position if position < len(trace) else None


def is_satisfied(formula: Formula, trace: Sequence[Label]) -> bool:
    """Return whether every infinite continuation of a trace satisfies a formula.

    Depth-first search over (position, obligations); all positions after the trace count as one. A cycle is a
    continuation that falsifies the formula. Each position keeps the sets of obligations that are known not to be
    falsifiable: a set that contains one of them is not falsifiable either.
    """
    mentioned = propositions_of(formula)
    read = [*(label & mentioned for label in trace), None]

    @cache
    def begun(obligations: _ObligationSet, label: Label | None) -> Iterator[_ObligationSet]:
        return tee(_passed_on(obligations, label), 1)[0]

    def passed_on(here: tuple[int, _ObligationSet]) -> Iterator[_ObligationSet]:
        # The same obligations meet the same label many times: what they pass on is computed once.
        return copy(begun(here[1], read[here[0]]))

    start = (0, frozenset({formula}))
    path, done = {start}, [list[_ObligationSet]() for _ in read]
    stack = [(start, passed_on(start))]
    while stack:
        here, options = stack[-1]
        following = min(here[0] + 1, len(trace))
        for obligations in options:
            there = (following, obligations)
            if there in path:
                return False
            if not any(fewer <= obligations for fewer in done[following]):
                path.add(there)
                stack.append((there, passed_on(there)))
                break
        else:
            stack.pop()
            path.remove(here)
            done[here[0]].append(here[1])
    return True


def _passed_on(obligations: _ObligationSet, label: Label | None) -> Iterator[_ObligationSet]:
    """Yield what is left to falsify at the next position, for every way to falsify some formulas at this one.

    `label` is the label of this position, None if any label will do.
    """
    pending = [(tuple(obligations), frozenset[Literal](), frozenset[Formula]())]
    met = set(pending)
    while pending:
        now, literals, due = pending.pop()
        if not now:
            yield due
            continue
        formula, rest = now[0], now[1:]
        options: list[tuple[tuple[Formula, ...], frozenset[Literal], frozenset[Formula]]] = []
        match formula:
            case Truth(False):
                options = [(rest, literals, due)]
            case Literal(name, positive) if label is not None:
                if (name in label) != positive:
                    options = [(rest, literals, due)]
            case Literal(name, positive) if Literal(name, not positive) not in literals:
                # No label falsifies both a and !a.
                options = [(rest, literals | {formula}, due)]
            case And(operands):
                options = [((operand, *rest), literals, due) for operand in reversed(operands)]
            case Or(operands):
                options = [((*operands, *rest), literals, due)]
            case Until(left, right, low):
                first = (right,) if low == 0 else ()
                options = [((*first, left, *rest), literals, due), ((*first, *rest), literals, due | {later(formula)})]
            case BoundedRelease(left, right, low):
                options = [((right, *rest), literals, due)] if low == 0 else []
                options += [((left, *rest), literals, due | {later(formula)})]
        for option in options:
            if option not in met:
                met.add(option)
                pending.append(option)
