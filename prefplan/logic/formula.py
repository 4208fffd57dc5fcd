"""Syntactically co-safe LTL (Definition 2) as syntax trees in negation normal form.

Counting operators, such as `F[0,5] a`, count actions. They are not expanded to nested `X`, which would make trees as
deep as the bound.
"""

from __future__ import annotations

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
    """Both hold."""

    left: Formula
    right: Formula


@dataclass(frozen=True)
class Or(_Node):
    """At least one holds."""

    left: Formula
    right: Formula


@dataclass(frozen=True)
class Next(_Node):
    """The operand holds at the next position."""

    operand: Formula


@dataclass(frozen=True)
class Until(_Node):
    """`right` holds at some position between `low` and `high`, and `left` at every earlier one; F a is true U a.

    Without a bound `high` is None.
    """

    left: Formula
    right: Formula
    low: int = 0
    high: int | None = None


@dataclass(frozen=True)
class BoundedRelease(_Node):
    """The dual of a bounded until: `right` holds from `low` to `high`, or to the first position where `left` holds.

    It is co-safe because of the bound. G[0,5] a is false R[0,5] a.
    """

    left: Formula
    right: Formula
    low: int
    high: int


Formula = Truth | Literal | And | Or | Next | Until | BoundedRelease

TRUE, FALSE = Truth(True), Truth(False)


def negate(formula: Formula) -> Formula:
    """Return the negation of a formula without temporal operators, in negation normal form."""
    match formula:
        case Truth(value):
            return Truth(not value)
        case Literal(name, positive):
            return Literal(name, not positive)
        case And(left, right):
            return Or(negate(left), negate(right))
        case Or(left, right):
            return And(negate(left), negate(right))
    raise ValueError(f"{formula} has a temporal operator")


def is_temporal(formula: Formula) -> bool:
    """Return whether a formula has a temporal operator."""
    match formula:
        case Next() | Until() | BoundedRelease():
            return True
        case And(left, right) | Or(left, right):
            return is_temporal(left) or is_temporal(right)
    return False


def propositions_of(formula: Formula) -> frozenset[str]:
    """Return the names of the atomic propositions in a formula."""
    match formula:
        case Literal(name):
            return frozenset({name})
        case Next(operand):
            return propositions_of(operand)
        case And(left, right) | Or(left, right) | Until(left, right) | BoundedRelease(left, right):
            return propositions_of(left) | propositions_of(right)
    return frozenset()


def later(formula: Until | BoundedRelease) -> Until | BoundedRelease:
    """Return a counting operator as it is at the next position: with its bounds less by one."""
    low = max(0, formula.low - 1)
    if isinstance(formula, Until):
        return replace(formula, low=low, high=None if formula.high is None else formula.high - 1)
    return replace(formula, low=low, high=formula.high - 1)


def holds(formula: Formula, label: frozenset[str]) -> bool:
    """Return whether a formula without temporal operators is true under a label."""
    match formula:
        case Truth(value):
            return value
        case Literal(name, positive):
            return (name in label) == positive
        case And(left, right):
            return holds(left, label) and holds(right, label)
        case Or(left, right):
            return holds(left, label) or holds(right, label)
    raise ValueError(f"{formula} has a temporal operator")


def _text(formula: Formula, strength: int) -> str:
    """Return a formula as text, in brackets if its operator binds weaker than a strength."""
    match formula:
        case Truth(value):
            return "true" if value else "false"
        case Literal(name, positive):
            return ("" if positive else "!") + (f'"{name}"' if split(name, None) else name)
        case And(left, right):
            text, own = f"{_text(left, 2)} & {_text(right, 3)}", 2
        case Or(left, right):
            text, own = f"{_text(left, 1)} | {_text(right, 2)}", 1
        case Next(operand):
            return f"X {_text(operand, 4)}"
        case Until(Truth(True), right, low, high) if low == high:
            return f"X[{low}] {_text(right, 4)}"
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
