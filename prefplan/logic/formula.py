"""Syntactically co-safe LTL (Definition 2) in negation normal form.

Counting operators, such as `F[0,5] a`, count actions. They are not expanded to nested next operators, which would make
formulas as deep as the bound.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from prefplan.logic.syntax import split


class _Node:
    """A part of a formula."""

    def __str__(self) -> str:
        """Return the formula as text that parses to the same formula."""
        return _text(self, 0)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Truth(_Node):
    """`true` or `false`."""

    value: bool


@dataclass(frozen=True)
class Literal(_Node):
    """An atomic proposition or its negation."""

    name: str
    positive: bool = True


@dataclass(frozen=True)
class And(_Node):
    """All operands hold, two or more; none of them is an `And`."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True)
class Or(_Node):
    """At least one operand holds, of two or more; none of them is an `Or`."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True)
class Until(_Node):
    """`right` holds at some position between `low` and `high` >= 1, and `left` at every earlier one.

    Without a bound `high` is None. F a is true U a, and X a is true U[1,1] a.
    """

    left: Formula
    right: Formula
    low: int = 0
    high: int | None = None


@dataclass(frozen=True)
class BoundedRelease(_Node):
    """The dual of a bounded until: `right` holds from `low` to `high`, or to the first position where `left` holds.

    It is co-safe because of the bound, which is at least 1. G[0,5] a is false R[0,5] a.
    """

    left: Formula
    right: Formula
    low: int
    high: int


Formula = Truth | Literal | And | Or | Until | BoundedRelease

TRUE, FALSE = Truth(True), Truth(False)


def joined(connective: type[And] | type[Or], operands: Iterable[Formula]) -> And | Or:
    """Return the conjunction or disjunction of two or more formulas."""
    flat: list[Formula] = []
    for operand in operands:
        flat += operand.operands if isinstance(operand, connective) else [operand]
    return connective(tuple(flat))


def operands_of(formula: Formula) -> tuple[Formula, ...]:
    """Return the formulas that a formula's outermost operator joins."""
    match formula:
        case And(operands) | Or(operands):
            return operands
        case Until(left, right) | BoundedRelease(left, right):
            return left, right
    return ()


def is_temporal(formula: Formula) -> bool:
    """Return whether a formula has a temporal operator."""
    return isinstance(formula, Until | BoundedRelease) or any(map(is_temporal, operands_of(formula)))


def counts_steps(formula: Formula) -> bool:
    """Return whether a formula has an operator with a bound."""
    bounded = isinstance(formula, Until | BoundedRelease) and (formula.low, formula.high) != (0, None)
    return bounded or any(map(counts_steps, operands_of(formula)))


def propositions_of(formula: Formula) -> frozenset[str]:
    """Return the names of the atomic propositions in a formula."""
    if isinstance(formula, Literal):
        return frozenset({formula.name})
    return frozenset().union(*map(propositions_of, operands_of(formula)))


def later(formula: Until | BoundedRelease) -> Formula:
    """Return what is left of a temporal operator at the next position: its bounds are one less there."""
    if formula.high == 1:
        return formula.right
    low = max(0, formula.low - 1)
    return replace(formula, low=low) if formula.high is None else replace(formula, low=low, high=formula.high - 1)


def holds(formula: Formula, label: frozenset[str]) -> bool:
    """Return whether a formula without temporal operators is true under a label."""
    match formula:
        case Truth(value):
            return value
        case Literal(name, positive):
            return (name in label) == positive
        case And(operands):
            return all(holds(operand, label) for operand in operands)
        case Or(operands):
            return any(holds(operand, label) for operand in operands)
    raise ValueError(f"{formula} has a temporal operator")


def _text(formula: Formula, strength: int) -> str:
    """Return a formula as text, in brackets if its operator binds weaker than a strength."""
    match formula:
        case Truth(value):
            return "true" if value else "false"
        case Literal(name, positive):
            return ("" if positive else "!") + (f'"{name}"' if split(name, None) else name)
        case And(operands):
            text, own = " & ".join(_text(operand, 3) for operand in operands), 2
        case Or(operands):
            text, own = " | ".join(_text(operand, 2) for operand in operands), 1
        case Until(Truth(True), right, low, high) if low == high:
            return f"X{'' if low == 1 else f'[{low}]'} {_text(right, 4)}"
        case Until(Truth(True), right, low, high):
            return f"F{_bounds(low, high)} {_text(right, 4)}"
        case BoundedRelease(Truth(False), right, low, high):
            return f"G{_bounds(low, high)} {_text(right, 4)}"
        case Until(left, right, low, high) | BoundedRelease(left, right, low, high):
            sign = "U" if isinstance(formula, Until) else "R"
            text, own = f"{_text(left, 4)} {sign}{_bounds(low, high)} {_text(right, 3)}", 3
    return f"({text})" if own < strength else text


def _bounds(low: int, high: int | None) -> str:
    return "" if (low, high) == (0, None) else f"[{low},{'' if high is None else high}]"
