"""Expressions over task costs: `+ - * /`, `min max abs`, numbers, brackets, task names, and nothing else."""

from __future__ import annotations

import ast
import math
import operator
import re
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any

from prefplan.errors import PreferenceError, choices
from prefplan.exact_costs import common_unit

FUNCTIONS = ("min", "max", "abs")

_ARITHMETIC: dict[str, Callable[..., Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "abs": abs,
}


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
    tree = _Reader(text, tasks, violation).read()
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
            return max(values) if name == "max" else min(values) if name == "min" else _ARITHMETIC[name](*values)
    raise AssertionError(tree)


def variables(tree: Tree) -> frozenset[Variable]:
    """Return the variables of an expression."""
    if isinstance(tree, Variable):
        return frozenset({tree})
    if isinstance(tree, Operation):
        return frozenset().union(*map(variables, tree.operands))
    return frozenset()


def scaled(tree: Tree, cost: Fraction, price: Fraction) -> tuple[Tree, Fraction]:
    """Return an expression over costs as one over multiples of units, and the factor to multiply its value by.

    Without a division all its constants are whole, so that its values are, too. `cost` and `price` are the units of
    costs and of violation costs.
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
class Shape:
    """Properties of an expression for all costs >= 0.

    Attributes:
        low, high: bounds of its values, exact or infinite.
        rising: whether it never falls in any variable.
        falling: whether it never rises in any variable.
    """

    low: Fraction | float
    high: Fraction | float
    rising: bool
    falling: bool


def shape(tree: Tree) -> Shape:
    """Return bounds and monotonicity of an expression, by interval arithmetic."""
    match tree:
        case Constant(value):
            return Shape(value, value, True, True)
        case Variable():
            return Shape(Fraction(0), math.inf, True, False)
        case Operation(name, operands):
            parts = [shape(operand) for operand in operands]
            if name in ("min", "max"):
                pick = min if name == "min" else max
                return Shape(
                    pick(p.low for p in parts),
                    pick(p.high for p in parts),
                    all(p.rising for p in parts),
                    all(p.falling for p in parts),
                )
            if name == "abs":
                return _absolute(parts[0])
            return _binary(name, *parts)
    raise AssertionError(tree)


def _negated(a: Shape) -> Shape:
    return Shape(-a.high, -a.low, a.falling, a.rising)


def _absolute(a: Shape) -> Shape:
    if a.low >= 0:
        return a
    if a.high <= 0:
        return _negated(a)
    return Shape(Fraction(0), max(-a.low, a.high), False, False)


def _binary(name: str, a: Shape, b: Shape) -> Shape:
    match name:
        case "+":
            return Shape(_sum(a.low, b.low), _sum(a.high, b.high), a.rising and b.rising, a.falling and b.falling)
        case "-":
            return _binary("+", a, _negated(b))
        case "/":
            if b.low <= 0:
                b = _negated(b)
                a = _negated(a)
            inverse = Shape(
                1 / b.high if b.high < math.inf else Fraction(0), 1 / b.low if b.low else math.inf, b.falling, b.rising
            )
            return _binary("*", a, inverse)
    for one, other in ((a, b), (b, a)):
        if one.high <= 0 and one.low < 0:
            return _negated(_binary("*", _negated(one), other))
    corners = [_times(x, y) for x in (a.low, a.high) for y in (b.low, b.high)]
    if a.low >= 0 and b.low >= 0:
        return Shape(min(corners), max(corners), a.rising and b.rising, a.falling and b.falling)
    constant, other = (a, b) if a.low == a.high else (b, a)
    if constant.low == constant.high:
        return Shape(min(corners), max(corners), other.rising, other.falling)
    return Shape(min(corners), max(corners), False, False)


def _sum(x: Fraction | float, y: Fraction | float) -> Fraction | float:
    # A fraction is converted to a float to be added to infinity, for which it may be too large.
    return x if abs(x) == math.inf else y if abs(y) == math.inf else x + y


def _times(x: Fraction | float, y: Fraction | float) -> Fraction | float:
    if x == 0 or y == 0:
        return Fraction(0)
    if math.inf in (abs(x), abs(y)):
        return math.inf if (x > 0) == (y > 0) else -math.inf
    return x * y


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


_TOKEN = re.compile(r"\w+|\S")
_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*", re.ASCII)
_NUMBER = re.compile(r"(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_FOREIGN = re.compile(r"[^\w\s.+\-*/(),]", re.ASCII)
_SYMBOLS: dict[type[ast.operator], str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
_LENGTH = 400
_MAGNITUDE = 30
"""Limits that keep trees shallow enough for recursion and exact numbers small."""


class _Reader:
    """Parses an expression as Python, and converts the syntax tree if it is arithmetic."""

    def __init__(self, text: str, tasks: Sequence[str], violation: bool) -> None:
        self.text, self.tasks, self.violation = re.sub(r"\s", " ", text).strip(), tasks, violation

    def error(self, message: str, column: int) -> PreferenceError:
        return PreferenceError(f"expression: {message}, at column {column + 1}\n    {self.text}\n    {' ' * column}^")

    def foreign(self, part: str, column: int) -> PreferenceError:
        return self.error(f"{part!r} is not allowed (only + - * / min max abs, numbers, brackets, tasks)", column)

    def read(self) -> Tree:
        if len(_TOKEN.findall(self.text)) > _LENGTH:
            raise PreferenceError(f"expression: longer than {_LENGTH} names, numbers and symbols")
        if found := _FOREIGN.search(self.text):
            raise self.foreign(found[0], found.start())
        # The name of a task may be a keyword of Python, such as `pass`.
        masked = _NAME.sub(lambda name: "_" * len(name[0]), self.text)
        try:
            with warnings.catch_warnings(action="ignore"):
                parsed = ast.parse(masked, mode="eval")
            return self.convert(parsed.body)
        except SyntaxError as error:
            raise self.error(error.msg.partition(".")[0], (error.offset or len(masked) + 1) - 1) from None

    def convert(self, node: ast.expr) -> Tree:
        part = self.text[node.col_offset : node.end_col_offset]
        match node:
            case ast.Constant() if _NUMBER.fullmatch(part):
                value = Decimal(part)
                if value and abs(value.adjusted()) > _MAGNITUDE:
                    raise self.error(f"a number beyond 1e{_MAGNITUDE} or below 1e-{_MAGNITUDE}", node.col_offset)
                return Constant(Fraction(value))
            case ast.Name():
                if part not in self.tasks:
                    raise self.error(f"unknown task {part!r} {choices(part, self.tasks)}", node.col_offset)
                return Variable(self.tasks.index(part), self.violation)
            case ast.UnaryOp(ast.UAdd(), operand) | ast.UnaryOp(ast.USub(), ast.UnaryOp(ast.USub(), operand)):
                return self.convert(operand)
            case ast.UnaryOp(ast.USub(), operand):
                return Operation("-", (Constant(Fraction(0)), self.convert(operand)))
            case ast.BinOp(left, symbol, right) if type(symbol) in _SYMBOLS:
                return Operation(_SYMBOLS[type(symbol)], (self.convert(left), self.convert(right)))
            case ast.Call(ast.Name() as called, operands, []):
                name = self.text[called.col_offset : called.end_col_offset]
                if name not in FUNCTIONS:
                    raise self.error(f"function {name!r} is not allowed {choices(name, FUNCTIONS)}", node.col_offset)
                if not operands or (name == "abs" and len(operands) > 1):
                    wanted = "one argument" if name == "abs" else "at least one argument"
                    raise self.error(f"{name} takes {wanted}, not {len(operands)}", node.col_offset)
                return Operation(name, tuple(map(self.convert, operands)))
        raise self.foreign(part, node.col_offset)
