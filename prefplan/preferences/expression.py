"""Expressions over task costs: `+ - * /`, `min max abs`, numbers, brackets, task names, and nothing else."""

from __future__ import annotations

import ast
import operator
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeVar

from prefplan.errors import PreferenceError, choices
from prefplan.exact_costs import common_unit, to_number

T = TypeVar("T")

FUNCTIONS = ("min", "max", "abs")

ARITHMETIC: dict[str, Callable[..., Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "abs": abs,
    "min": lambda *values: min(values),
    "max": lambda *values: max(values),
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
    """`+ - * /` of two operands, `min max abs` of some, or a Python function of floats."""

    name: str | Callable[..., float]
    operands: tuple[Tree, ...]


Tree = Constant | Variable | Operation


def parse(text: str, amounts: Mapping[str, Variable]) -> Tree:
    """Read an expression over the costs (or violation costs) of tasks, given by name.

    Raises:
        PreferenceError: for a syntax error (with the column), or an unknown task or function.
    """
    return _Reader(text, amounts).read()


def fold(
    tree: Tree, constant: Callable[[Fraction], T], variable: Callable[[Variable], T], operation: Callable[..., T]
) -> T:
    """Evaluate an expression from its leaves up; `operation` gets an operator's name and its operands' results."""
    if isinstance(tree, Constant):
        return constant(tree.value)
    if isinstance(tree, Variable):
        return variable(tree)
    return operation(tree.name, *[fold(operand, constant, variable, operation) for operand in tree.operands])


def evaluate(tree: Tree, costs: Sequence[Any], violations: Sequence[Any]) -> Any:
    """Return the value of an expression, in the arithmetic of its arguments (fractions stay exact)."""
    return fold(
        tree,
        lambda value: value,
        lambda variable: (violations if variable.violation else costs)[variable.task],
        lambda name, *values: ARITHMETIC.get(name, name)(*values),
    )


def variables(tree: Tree) -> frozenset[Variable]:
    """Return the variables of an expression."""
    none = frozenset[Variable]()
    return fold(tree, lambda _: none, lambda variable: frozenset({variable}), lambda _, *sets: none.union(*sets))


def is_rounded(tree: Tree) -> bool:
    """Return whether an expression has a division or a Python function."""
    return fold(
        tree, lambda _: False, lambda _: False, lambda name, *parts: name == "/" or callable(name) or any(parts)
    )


def scaled(tree: Tree, cost: Fraction, price: Fraction) -> tuple[Tree, Fraction]:
    """Return an expression rewritten for costs in multiples of units, and the factor by which to multiply its value.

    If all divisors are numbers, the constants are whole, and so are all values. `cost` and `price` are the units of
    costs and of violation costs.
    """
    if isinstance(tree, Constant):
        return Constant(Fraction(1)), tree.value
    if isinstance(tree, Variable):
        return tree, price if tree.violation else cost
    parts, factors = zip(*[scaled(operand, cost, price) for operand in tree.operands], strict=True)
    if tree.name in ("*", "/"):
        by_number = parts[1] == Constant(Fraction(1))
        return parts[0] if by_number else Operation(tree.name, parts), ARITHMETIC[tree.name](*factors)
    unit = Fraction(1) if callable(tree.name) else common_unit(factors)
    return Operation(tree.name, tuple(map(_times_constant, parts, (factor / unit for factor in factors)))), unit


def _times_constant(tree: Tree, factor: Fraction) -> Tree:
    if isinstance(tree, Constant):
        return Constant(tree.value * factor)
    for name, by in (("*", factor.numerator), ("/", factor.denominator)):
        tree = tree if by == 1 else Operation(name, (tree, Constant(Fraction(by))))
    return tree


def to_text(tree: Tree, tasks: Sequence[str]) -> str:
    """Return an expression as text."""

    def combine(name: str, *parts: str) -> str:
        return f"{name}({', '.join(parts)})" if name in FUNCTIONS else f"({parts[0]} {name} {parts[1]})"

    return fold(tree, lambda value: str(to_number(value)), lambda variable: tasks[variable.task], combine)


_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*", re.ASCII)
_NUMBER = re.compile(r"(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_FOREIGN = re.compile(r"[^\w\s.+\-*/(),]", re.ASCII)
_SYMBOLS: dict[type[ast.operator], str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
_LENGTH = 400
"""Most names, numbers and symbols of an expression: its tree stays shallow enough for recursion."""

_LETTERS = 4000
"""Most letters of an expression: messages stay short."""

_MAGNITUDE = 30
"""Greatest absolute exponent of ten of a number: exact numbers stay small."""


class _Reader:
    """Parses an expression as Python, and converts the syntax tree if it is arithmetic."""

    def __init__(self, text: str, amounts: Mapping[str, Variable]) -> None:
        self.text, self.amounts = re.sub(r"\s", " ", text).strip(), amounts

    def error(self, message: str, column: int) -> PreferenceError:
        return PreferenceError(f"expression: {message}, at column {column + 1}\n    {self.text}\n    {' ' * column}^")

    def foreign(self, part: str, column: int) -> PreferenceError:
        return self.error(f"{part!r} is not allowed (only + - * / min max abs, numbers, brackets, tasks)", column)

    def read(self) -> Tree:
        if len(self.text) > _LETTERS or len(re.findall(r"\w+|\S", self.text)) > _LENGTH:
            most = f"{_LENGTH} names, numbers and symbols, or {_LETTERS} letters"
            raise PreferenceError(f"expression: longer than {most}")
        if foreign := _FOREIGN.search(self.text):
            raise self.foreign(foreign[0], foreign.start())
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
                if part not in self.amounts:
                    raise self.error(f"unknown task {part!r} {choices(part, self.amounts)}", node.col_offset)
                return self.amounts[part]
            case ast.UnaryOp(ast.UAdd(), operand) | ast.UnaryOp(ast.USub(), ast.UnaryOp(ast.USub(), operand)):
                return self.convert(operand)
            case ast.UnaryOp(ast.USub(), operand):
                return Operation("-", (Constant(Fraction(0)), self.convert(operand)))
            case ast.BinOp(left, symbol, right) if type(symbol) in _SYMBOLS:
                return Operation(_SYMBOLS[type(symbol)], (self.convert(left), self.convert(right)))
            case ast.Call(ast.Name() as called, arguments, []):
                name = self.text[called.col_offset : called.end_col_offset]
                if name not in FUNCTIONS:
                    raise self.error(f"function {name!r} is not allowed {choices(name, FUNCTIONS)}", node.col_offset)
                if not arguments or (name == "abs" and len(arguments) > 1):
                    wanted = "one argument" if name == "abs" else "at least one argument"
                    raise self.error(f"{name} takes {wanted}, not {len(arguments)}", node.col_offset)
                return Operation(name, tuple(map(self.convert, arguments)))
        raise self.foreign(part, node.col_offset)
