"""What can be shown of an expression over task costs: bounds, monotonicity, and terms of which it is the sum."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from prefplan.errors import PreferenceError
from prefplan.preferences.expression import ARITHMETIC, Constant, Operation, Tree, Variable, to_text
from prefplan.preferences.terms import Maximum, SpreadRate, Tardiness, Term, Violation, WeightedRate

LARGEST_COST = Fraction(10) ** 500
"""More than any cost of a plan: no number given is beyond 1e400 (`exact_costs.exact`)."""

_ONE = Constant(Fraction(1))


@dataclass(frozen=True)
class Shape:
    """Properties of an expression for all costs from 0 to `LARGEST_COST`.

    Attributes:
        low: exact lower bound of its values.
        high: exact upper bound of its values.
        rising: whether it never falls in any variable.
        falling: whether it never rises in any variable.
    """

    low: Fraction
    high: Fraction
    rising: bool
    falling: bool

    def __neg__(self) -> Shape:
        """Return the shape of the negative."""
        return Shape(-self.high, -self.low, self.falling, self.rising)


def shape(tree: Tree, tasks: Sequence[str]) -> Shape:
    """Return bounds and monotonicity of an expression, by interval arithmetic.

    Raises:
        PreferenceError: it divides by what can be zero.
    """
    match tree:
        case Constant(value):
            return Shape(value, value, True, True)
        case Variable():
            return Shape(Fraction(0), LARGEST_COST, True, False)
    parts = [shape(operand, tasks) for operand in tree.operands]
    if tree.name == "/" and parts[1].low <= 0 <= parts[1].high:
        raise PreferenceError(f"expression: divides by '{to_text(tree.operands[1], tasks)}', which can be zero")
    return _combined(tree.name, *parts)


def _combined(name: Any, *parts: Shape) -> Shape:
    """Return the shape of an operation on operands of some shapes; no divisor is 0."""
    one, other, zero = parts[0], parts[-1], Fraction(0)
    rising, falling = all(part.rising for part in parts), all(part.falling for part in parts)
    match name:
        case "min" | "max":
            low, high = (ARITHMETIC[name](*ends) for ends in zip(*((p.low, p.high) for p in parts), strict=True))
            return Shape(low, high, rising, falling)
        case "+":
            return Shape(one.low + other.low, one.high + other.high, rising, falling)
        case "-":
            return _combined("+", one, -other)
        case "abs" if one.low < 0:
            return -one if one.high <= 0 else Shape(zero, max(-one.low, one.high), False, False)
        case "abs":
            return one
        case "/":
            return _combined("*", one, Shape(1 / other.high, 1 / other.low, other.falling, other.rising))
    corners = [x * y for x in (one.low, one.high) for y in (other.low, other.high)]
    rising = _never_falls(one, other) and _never_falls(other, one)
    falling = _never_falls(-one, other) and _never_falls(-other, one)
    return Shape(min(corners), max(corners), rising, falling)


def _never_falls(factor: Shape, part: Shape) -> bool:
    """Return whether `factor` times `part` never falls because `part` changes as variables grow."""
    return part.low == part.high or (part.rising and factor.low >= 0) or (part.falling and factor.high <= 0)


def decompose(tree: Tree, tasks: int) -> list[Term | Fraction] | None:
    """Return an expression as a constant plus additive and convex terms, or None if it has another form.

    Recognised are sums, with factors >= 0, of costs, violation costs, |c_i - c_j|, max - min of the same costs,
    max(0, c_i - d) and weighted maxima of costs.
    """
    summands = _summands(tree)
    terms: list[Term | Fraction] = [summands.pop(_ONE, Fraction(0))]
    for part in list(summands):
        if isinstance(part, Operation) and part.name == "max" and summands[part] > 0:
            least, spread = Operation("min", part.operands), _spread(part, summands[part])
            if spread and summands.get(least) == -summands[part]:
                terms.append(spread)
                del summands[part], summands[least]
    linear, violation = dict[int, Fraction](), dict[int, Fraction]()
    for part, factor in summands.items():
        if isinstance(part, Variable) and factor >= 0:
            (violation if part.violation else linear)[part.task] = factor
        elif factor != 0:
            term = _convex(part, factor, tasks)
            if term is None:
                return None
            terms.append(term)
    # A violation cost of weight 0 is kept: the preference mentions it.
    for kind, weights in ((WeightedRate, linear), (Violation, violation)):
        if weights:
            terms.append(kind(tuple(weights.get(task, Fraction(0)) for task in range(tasks))))
    return terms


def _summands(tree: Tree) -> dict[Tree, Fraction]:
    """Return a sum as {summand: factor}; constants have the summand 1."""
    result: dict[Tree, Fraction] = {}

    def add(node: Tree, by: Fraction) -> None:
        match node:
            case Operation("+" | "-" as name, (a, b)):
                add(a, by)
                add(b, by if name == "+" else -by)
            case Operation("*", (Constant(value), other)) | Operation("*", (other, Constant(value))):
                add(other, by * value)
            case Operation("/", (a, Constant(value))):
                add(a, by / value)
            case Constant(value):
                result[_ONE] = result.get(_ONE, Fraction(0)) + by * value
            case _:
                result[node] = result.get(node, Fraction(0)) + by

    add(tree, Fraction(1))
    return result


def _lines(operands: Iterable[Tree]) -> list[tuple[dict[int, Fraction], Fraction]] | None:
    """Return operands as ({task: slope}, constant) each, or None if one is not linear in the costs."""
    lines = []
    for operand in operands:
        summands = _summands(operand)
        constant, slopes = summands.pop(_ONE, Fraction(0)), {}
        for part, slope in summands.items():
            if not isinstance(part, Variable) or part.violation:
                return None
            if slope:
                slopes[part.task] = slope
        lines.append((slopes, constant))
    return lines


def _spread(tree: Operation, factor: Fraction) -> Term | None:
    """Return factor * (max - min) of a maximum's operands if they are w c_i with one common w > 0, else None."""
    lines = _lines(tree.operands) or [({}, Fraction(0))]
    slopes = {slope for line, _ in lines for slope in line.values()}
    if any(constant != 0 or len(line) != 1 for line, constant in lines) or len(slopes) != 1 or min(slopes) <= 0:
        return None
    return SpreadRate(factor * slopes.pop(), frozenset(task for line, _ in lines for task in line))


def _convex(tree: Tree, factor: Fraction, tasks: int) -> Term | None:
    """Return factor * tree as |c_i - c_j|, tardiness or a weighted maximum, or None."""
    if not isinstance(tree, Operation) or tree.name not in ("abs", "max") or factor < 0:
        return None
    lines = _lines(tree.operands)
    if lines is None:
        return None
    if tree.name == "abs":
        ((slopes, constant),) = lines
        if len(slopes) == 2 and constant == 0 and sum(slopes.values()) == 0:
            return SpreadRate(factor * max(slopes.values()), frozenset(slopes))
        return None
    if any(len(slopes) > 1 or min(slopes.values(), default=0) < 0 for slopes, _ in lines):
        return None
    lines.sort(key=lambda line: len(line[0]))
    if len(lines) == 2 and lines[0] == ({}, 0) and lines[1][0] and lines[1][1] <= 0:
        ((task, slope),) = lines[1][0].items()
        return Tardiness(task, -lines[1][1] / slope, factor * slope)
    weights = [Fraction(0)] * tasks
    for slopes, constant in lines:
        if not slopes and constant <= 0:
            continue  # costs are never negative
        if constant != 0 or not slopes:
            return None
        ((task, slope),) = slopes.items()
        weights[task] = max(weights[task], factor * slope)
    return Maximum(tuple(weights))
