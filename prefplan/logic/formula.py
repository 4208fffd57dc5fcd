"""Syntactically co-safe LTL (Definition 2): text to syntax tree in positive normal form."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import reduce

from prefplan.errors import FormulaError, choices


class _Node:
    """A part of a formula."""

    def __str__(self) -> str:
        """Return the formula as text."""
        match self:
            case Truth(value):
                return "true" if value else "false"
            case Literal(name, positive):
                return name if positive else f"!{name}"
            case And(left, right):
                return f"({left} & {right})"
            case Or(left, right):
                return f"({left} | {right})"
            case Next(operand):
                return f"X {operand}"
            case Until(left, right):
                return f"F {right}" if left == TRUE else f"({left} U {right})"
        raise AssertionError(repr(self))


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
    """`right` holds at some position, and `left` at every earlier one; F a is true U a."""

    left: Formula
    right: Formula


Formula = Truth | Literal | And | Or | Next | Until

TRUE = Truth(True)


def parse(text: str, *, propositions: Iterable[str] | None = None) -> Formula:
    """Read an scLTL formula.

    Unary `!`, `X` and `F` bind tightest, then `U` (to the right), `&`, `|` and `->` (to the right). `!` and the left
    side of `->` take formulas without temporal operators only.

    Args:
        text: the formula.
        propositions: if given, the only names that may be used.

    Returns:
        The syntax tree in positive normal form.

    Raises:
        FormulaError: for a syntax error (with the column, counted from 1), an unknown proposition (with the nearest
            valid one), or a part that is not co-safe (naming it).
    """
    return _Parser(text, None if propositions is None else sorted(propositions)).read()


def negate(formula: Formula) -> Formula:
    """Return the negation of a formula without temporal operators, in positive normal form."""
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
        case Next() | Until():
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
        case And(left, right) | Or(left, right) | Until(left, right):
            return propositions_of(left) | propositions_of(right)
    return frozenset()


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


_TOKEN = re.compile(r"[A-Za-z_]\w*|->|\S", re.ASCII)
_SYMBOL = re.compile(r"[A-Za-z_]\w*|->|[!&|()]", re.ASCII)
_NOT_COSAFE = {"G": "'always'", "R": "'release'", "W": "'weak until'"}
_NESTING = 120
"""Deeper formulas are refused rather than left to overflow the interpreter's stack."""


def _balanced(operator: type[And] | type[Or], operands: list[Formula]) -> Formula:
    """Join operands from the left, or to a shallow tree where that would be a deep one."""
    if len(operands) <= _NESTING:
        return reduce(operator, operands)
    while len(operands) > 1:
        pairs = zip(operands[::2], operands[1::2], strict=False)
        joined: list[Formula] = [operator(left, right) for left, right in pairs]
        operands = joined + operands[len(joined) * 2 :]
    return operands[0]


@dataclass(frozen=True)
class _Token:
    text: str
    start: int
    end: int


class _Parser:
    """Recursive descent, one method for each level of precedence."""

    def __init__(self, text: str, propositions: list[str] | None) -> None:
        self.text, self.propositions = re.sub(r"\s", " ", text), propositions
        self.tokens = self.scan()
        self.position = 0
        self.depth = 0
        self.opened: list[_Token] = []

    def error(self, message: str, column: int) -> FormulaError:
        """Return an error that points at a column (0-based here, 1-based for people)."""
        return FormulaError(f"{message}, at column {column + 1}\n    {self.text}\n    {' ' * column}^")

    def scan(self) -> list[_Token]:
        tokens = [_Token(found[0], found.start(), found.end()) for found in _TOKEN.finditer(self.text)]
        for token in tokens:
            if not _SYMBOL.fullmatch(token.text):
                raise self.error(f"{token.text!r} means nothing in a formula", token.start)
        return [*tokens, _Token("", len(self.text.rstrip()), len(self.text))]

    @property
    def token(self) -> _Token:
        return self.tokens[self.position]

    def advance(self) -> _Token:
        self.position += 1
        return self.tokens[self.position - 1]

    def part(self, start: int) -> str:
        """Return the text from a column to the last token read."""
        return self.text[start : self.tokens[self.position - 1].end]

    def read(self) -> Formula:
        formula = self.implication()
        if self.token.text == ")":
            raise self.error("')' closes no bracket", self.token.start)
        if self.token.text:
            raise self.error(f"expected an operator, not {self.token.text!r}", self.token.start)
        return formula

    def implication(self) -> Formula:
        start = self.token.start
        left = self.disjunction()
        if self.token.text != "->":
            return left
        premise = self.part(start)
        self.advance()
        self.nest(start)
        right = self.implication()
        self.depth -= 1
        if is_temporal(left):
            whole = self.part(start)
            raise self.error(f"not co-safe: '{whole}' negates '{premise}', which has a temporal operator", start)
        return Or(negate(left), right)

    def disjunction(self) -> Formula:
        return self.joined("|", Or, lambda: self.joined("&", And, self.until))

    def joined(self, symbol: str, operator: type[And] | type[Or], operand: Callable[[], Formula]) -> Formula:
        """Read operands with one symbol between them."""
        operands = [operand()]
        while self.token.text == symbol:
            self.advance()
            operands.append(operand())
        return _balanced(operator, operands)

    def until(self) -> Formula:
        start = self.token.start
        left = self.unary()
        if self.token.text not in ("U", "R", "W"):
            return left
        operator = self.advance().text
        self.nest(start)
        right = self.until()
        self.depth -= 1
        if operator != "U":
            raise self.error(f"not co-safe: '{self.part(start)}' uses {operator} ({_NOT_COSAFE[operator]})", start)
        return Until(left, right)

    def unary(self) -> Formula:
        token = self.advance()
        if token.text in ("!", "X", "F", "G"):
            self.nest(token.start)
            operand = self.unary()
            self.depth -= 1
            return self.apply(token, operand)
        if token.text == "(":
            self.nest(token.start)
            self.opened.append(token)
            formula = self.implication()
            if self.token.text != ")":
                if self.token.text:
                    raise self.error(f"expected an operator or ')', not {self.token.text!r}", self.token.start)
                raise self.error("'(' is never closed", token.start)
            self.advance()
            self.opened.pop()
            self.depth -= 1
            return formula
        return self.atom(token)

    def apply(self, token: _Token, operand: Formula) -> Formula:
        if token.text == "X":
            return Next(operand)
        if token.text == "F":
            return Until(TRUE, operand)
        part = self.part(token.start)
        if token.text == "G":
            raise self.error(f"not co-safe: '{part}' uses G ({_NOT_COSAFE['G']})", token.start)
        if is_temporal(operand):
            raise self.error(f"not co-safe: '{part}' negates a temporal operator", token.start)
        return negate(operand)

    def atom(self, token: _Token) -> Formula:
        name = token.text
        if name in ("true", "false"):
            return Truth(name == "true")
        if name in ("U", "R", "W", "&", "|", "->", ")", ""):
            what = f"not {name!r}" if name else "but the formula ends"
            if not name and self.opened:
                what += f" (the '(' at column {self.opened[-1].start + 1} is never closed)"
            raise self.error(f"expected a formula, {what}", token.start)
        if self.propositions is not None and name not in self.propositions:
            raise self.error(f"unknown proposition {name!r} {choices(name, self.propositions)}", token.start)
        return Literal(name)

    def nest(self, column: int) -> None:
        self.depth += 1
        if self.depth > _NESTING:
            raise self.error(f"nested more than {_NESTING} deep", column)
