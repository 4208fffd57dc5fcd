"""Expressions over task costs: `+ - * /`, `min max abs`, numbers, brackets, task names, and nothing else."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any

from prefplan.errors import PreferenceError, choices
from prefplan.exact_costs import common_unit

FUNCTIONS: dict[str, Callable[[Any], Any]] = {"min": min, "max": max, "abs": abs}


@dataclass(frozen=True)
class Constant:
    """A number."""

    value: Fraction


@dataclass(frozen=True)
class Variable:
    """A task's cost, or its violation cost."""

    task: int
    violation: bool = False


@dataclass(frozen=True)
class Operation:
    """`+ - * /` of two operands, or `min max abs` of some."""

    name: str
    operands: tuple[Tree, ...]


Tree = Constant | Variable | Operation


def parse(text: str, tasks: Sequence[str], *, violation: bool = False) -> Tree:
    """Read an expression over the costs (or violation costs) of tasks.

    Raises:
        PreferenceError: for a syntax error (with the column), an unknown task or function, or a divisor that can be
            zero.
    """
    tree = _Parser(text, tasks, violation).read()
    _check_divisors(tree, tasks)
    return tree


def evaluate(tree: Tree, costs: Sequence[Any], violations: Sequence[Any]) -> Any:
    """Return the value of an expression, in the arithmetic of its arguments (fractions stay exact)."""
    match tree:
        case Constant(value):
            return value
        case Variable(task, violation):
            return violations[task] if violation else costs[task]
        case Operation(name, operands):
            values = [evaluate(operand, costs, violations) for operand in operands]
            match name:
                case "+":
                    return values[0] + values[1]
                case "-":
                    return values[0] - values[1]
                case "*":
                    return values[0] * values[1]
                case "/":
                    return values[0] / values[1]
                case "abs":
                    return abs(values[0])
            return FUNCTIONS[name](values)
    raise AssertionError(tree)


def variables(tree: Tree) -> frozenset[Variable]:
    """Return the variables of an expression."""
    if isinstance(tree, Variable):
        return frozenset({tree})
    if isinstance(tree, Operation):
        return frozenset().union(*map(variables, tree.operands))
    return frozenset()


def scaled(tree: Tree, cost: Fraction, price: Fraction) -> tuple[Tree, Fraction]:
    """Return an expression over costs as one over their multiples of a unit, and the factor that is left out of it.

    Without a division all its constants are whole, so that it gives whole numbers.

    Args:
        tree: the expression, over costs in the user's units.
        cost: unit of costs.
        price: unit of violation costs.
    """
    match tree:
        case Constant(value):
            return Constant(Fraction(1)), value
        case Variable(_, violation):
            return tree, price if violation else cost
        case Operation(name, operands):
            parts = [scaled(operand, cost, price) for operand in operands]
            if name in ("*", "/"):
                (a, by), (b, factor) = parts
                return Operation(name, (a, b)), by * factor if name == "*" else by / factor
            unit = common_unit([factor for _, factor in parts])
            return Operation(name, tuple(_times_constant(part, factor / unit) for part, factor in parts)), unit
    raise AssertionError(tree)


def _times_constant(tree: Tree, factor: Fraction) -> Tree:
    if isinstance(tree, Constant):
        return Constant(tree.value * factor)
    return tree if factor == 1 else Operation("*", (Constant(factor), tree))


def divides(tree: Tree) -> bool:
    """Return whether an expression has a division."""
    return isinstance(tree, Operation) and (tree.name == "/" or any(map(divides, tree.operands)))


@dataclass(frozen=True)
class Bounds:
    """What is known of an expression for all costs >= 0.

    Attributes:
        low, high: between which its values lie.
        rising: whether it never falls in any variable.
        falling: whether it never rises in any variable.
    """

    low: float
    high: float
    rising: bool
    falling: bool


def shape(tree: Tree) -> Bounds:
    """Return bounds and monotonicity of an expression, by interval arithmetic."""
    match tree:
        case Constant(value):
            return Bounds(float(value), float(value), True, True)
        case Variable():
            return Bounds(0, math.inf, True, False)
        case Operation(name, operands):
            parts = [shape(operand) for operand in operands]
            if name in ("min", "max"):
                pick = FUNCTIONS[name]
                return Bounds(
                    pick(p.low for p in parts),
                    pick(p.high for p in parts),
                    all(p.rising for p in parts),
                    all(p.falling for p in parts),
                )
            if name == "abs":
                return _absolute(parts[0])
            return _binary(name, *parts)
    raise AssertionError(tree)


def _negated(a: Bounds) -> Bounds:
    return Bounds(-a.high, -a.low, a.falling, a.rising)


def _absolute(a: Bounds) -> Bounds:
    if a.low >= 0:
        return a
    if a.high <= 0:
        return _negated(a)
    return Bounds(0, max(-a.low, a.high), False, False)


def _binary(name: str, a: Bounds, b: Bounds) -> Bounds:
    match name:
        case "+":
            return Bounds(a.low + b.low, a.high + b.high, a.rising and b.rising, a.falling and b.falling)
        case "-":
            return _binary("+", a, _negated(b))
        case "/":
            if b.low <= 0:
                b = _negated(b)
                a = _negated(a)
            inverse = Bounds(
                1 / b.high if b.high < math.inf else 0.0, 1 / b.low if b.low else math.inf, b.falling, b.rising
            )
            return _binary("*", a, inverse)
    for one, other in ((a, b), (b, a)):
        if one.high <= 0 and one.low < 0:
            return _negated(_binary("*", _negated(one), other))
    corners = [_times(x, y) for x in (a.low, a.high) for y in (b.low, b.high)]
    if a.low >= 0 and b.low >= 0:
        return Bounds(min(corners), max(corners), a.rising and b.rising, a.falling and b.falling)
    constant, other = (a, b) if a.low == a.high else (b, a)
    if constant.low == constant.high:
        return Bounds(min(corners), max(corners), other.rising, other.falling)
    return Bounds(min(corners), max(corners), False, False)


def _times(x: float, y: float) -> float:
    return 0.0 if x == 0 or y == 0 else x * y


def _check_divisors(tree: Tree, tasks: Sequence[str]) -> None:
    if isinstance(tree, Operation):
        for operand in tree.operands:
            _check_divisors(operand, tasks)
        if tree.name == "/":
            divisor = shape(tree.operands[1])
            if divisor.low <= 0 <= divisor.high:
                raise PreferenceError(f"expression: divides by '{to_text(tree.operands[1], tasks)}', which can be zero")


def to_text(tree: Tree, tasks: Sequence[str]) -> str:
    """Return an expression as text."""
    match tree:
        case Constant(value):
            return str(value.numerator) if value.denominator == 1 else str(float(value))
        case Variable(task):
            return tasks[task]
        case Operation(name, operands):
            parts = [to_text(operand, tasks) for operand in operands]
            if name in FUNCTIONS:
                return f"{name}({', '.join(parts)})"
            return f"({parts[0]} {name} {parts[1]})"
    raise AssertionError(tree)


_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_][A-Za-z0-9_]*)"
    r"|(?P<symbol>[-+*/(),])|(?P<wrong>\S))"
)
_NESTING = 100
_LENGTH = 400
_MAGNITUDE = 30
"""Limits that keep trees shallow enough to walk and numbers small enough to be exact."""


class _Parser:
    """Recursive descent: sums of products of signed atoms."""

    def __init__(self, text: str, tasks: Sequence[str], violation: bool) -> None:
        self.text, self.tasks, self.violation = text, tasks, violation
        self.tokens = [
            (str(match.lastgroup), match[str(match.lastgroup)], match.start(str(match.lastgroup)))
            for match in _TOKEN.finditer(text)
        ]
        self.tokens.append(("end", "", len(text)))
        if len(self.tokens) > _LENGTH:
            raise PreferenceError(f"expression: longer than {_LENGTH} names, numbers and symbols")
        self.position = 0
        self.depth = 0

    def error(self, message: str, column: int) -> PreferenceError:
        return PreferenceError(f"expression: {message}, at column {column + 1}\n    {self.text}\n    {' ' * column}^")

    @property
    def token(self) -> str:
        return self.tokens[self.position][1]

    def read(self) -> Tree:
        tree = self.sum()
        kind, text, column = self.tokens[self.position]
        if kind != "end":
            raise self.error(f"expected an operator, not {text!r}", column)
        return tree

    def sum(self) -> Tree:
        self.depth += 1
        if self.depth > _NESTING:
            raise self.error(f"nested more than {_NESTING} deep", self.tokens[self.position][2])
        tree = self.product()
        while self.token in ("+", "-"):
            self.position += 1
            tree = Operation(self.tokens[self.position - 1][1], (tree, self.product()))
        self.depth -= 1
        return tree

    def product(self) -> Tree:
        tree = self.signed()
        while self.token in ("*", "/"):
            self.position += 1
            tree = Operation(self.tokens[self.position - 1][1], (tree, self.signed()))
        return tree

    def signed(self) -> Tree:
        negative = False
        while self.token in ("+", "-"):
            negative ^= self.token == "-"
            self.position += 1
        tree = self.atom()
        return Operation("-", (Constant(Fraction(0)), tree)) if negative else tree

    def atom(self) -> Tree:
        kind, text, column = self.tokens[self.position]
        self.position += 1
        if kind == "number":
            value = Decimal(text)
            if value and abs(value.adjusted()) > _MAGNITUDE:
                raise self.error(f"a number beyond 1e{_MAGNITUDE} or below 1e-{_MAGNITUDE}", column)
            return Constant(Fraction(value))
        if kind == "name" and self.token == "(":
            return self.call(text, column)
        if kind == "name":
            if text not in self.tasks:
                raise self.error(f"unknown task {text!r} {choices(text, self.tasks)}", column)
            return Variable(self.tasks.index(text), self.violation)
        if text == "(":
            tree = self.sum()
            self.close(column)
            return tree
        if kind == "wrong":
            raise self.error(f"{text!r} is not allowed (only + - * / min max abs, numbers, brackets, tasks)", column)
        raise self.error(
            f"expected a number, a task or a bracket, {f'not {text!r}' if text else 'but it ends'}", column
        )

    def call(self, name: str, column: int) -> Tree:
        if name not in FUNCTIONS:
            raise self.error(f"function {name!r} is not allowed {choices(name, FUNCTIONS)}", column)
        opened = self.tokens[self.position][2]
        self.position += 1
        operands = [self.sum()]
        while self.token == ",":
            self.position += 1
            operands.append(self.sum())
        self.close(opened)
        if name == "abs" and len(operands) != 1:
            raise self.error(f"abs takes one argument, not {len(operands)}", column)
        return Operation(name, tuple(operands))

    def close(self, opened: int) -> None:
        kind, text, column = self.tokens[self.position]
        if text != ")":
            if kind == "end":
                raise self.error("'(' is never closed", opened)
            raise self.error(f"expected an operator or ')', not {text!r}", column)
        self.position += 1
