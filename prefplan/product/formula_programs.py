"""Formulas as compiled kernels evaluate them: stack programs, and a Python function behind a C pointer."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import types

from prefplan.exact_costs import Units
from prefplan.preferences.expression import Constant, Tree, Variable, scaled
from prefplan.preferences.terms import OpaqueTerm
from prefplan.product.kernels import bare_kernel

CONSTANT, COST, VIOLATION, ADD, SUBTRACT, MULTIPLY, DIVIDE, MINIMUM, MAXIMUM, ABSOLUTE, CALL = range(11)
_BINARY = {"+": ADD, "-": SUBTRACT, "*": MULTIPLY, "/": DIVIDE, "min": MINIMUM, "max": MAXIMUM}

ROUNDING, FUNCTION_ROUNDING = 2.0**-52, 2.0**-48
"""Relative error bounds: of one operation, twice its largest error, and of a Python function, whose arguments are
rounded."""

LARGEST_WHOLE = 2.0**53
"""Larger whole numbers are not exact in floating point."""

SIGNATURE = types.float64(types.CPointer(types.float64), types.CPointer(types.float64), types.intp)
"""(costs, violations, N) -> value."""


class Programs(NamedTuple):
    """F stack programs, one after the other.

    Attributes:
        first: (F + 1,) int64, where each begins.
        operation: (P,) int8 and argument: (P,) float64 of each instruction. error: (P,) float64, rounding error of the
            argument.
        units: (2,) float64, the units of costs and of violation costs, in the user's units.
        stack: (depth, 2) float64 values and error bounds, scratch.
        user: (2, N) float64, arguments of a function, scratch.
        callback: the function that is called, if any is.
    """

    first: np.ndarray
    operation: np.ndarray
    argument: np.ndarray
    error: np.ndarray
    units: np.ndarray
    stack: np.ndarray
    user: np.ndarray
    callback: Any


def compile_programs(formulas: list[OpaqueTerm], units: Units, tasks: int) -> Programs:
    """Return formulas as stack programs whose values are in units of mu; functions become calls."""
    code: list[tuple[int, Fraction]] = []
    first = [0]
    for formula in formulas:
        factor = formula.weight / units.mu
        if formula.tree is None:
            code.append((CALL, Fraction(0)))
        else:
            tree, rest = scaled(formula.tree, units.cost, units.price)
            code += _instructions(tree)
            factor *= rest
        code += [(CONSTANT, factor), (MULTIPLY, Fraction(0))]
        first.append(len(code))
    arguments = [float(argument) for _, argument in code]
    functions = [formula.function for formula in formulas if formula.function is not None]
    return Programs(
        np.array(first, dtype=np.int64),
        np.array([operation for operation, _ in code], dtype=np.int8),
        np.array(arguments, dtype=np.float64),
        np.array([float(abs(Fraction(x) - y)) for x, (_, y) in zip(arguments, code, strict=True)], dtype=np.float64),
        np.array([float(units.cost), float(units.price)]),
        np.zeros((len(code) + 1, 2)),
        np.zeros((2, tasks)),
        Callback(functions[0] if functions else lambda costs, violations: 0.0),
    )


def _instructions(tree: Tree) -> list[tuple[int, Fraction]]:
    nothing = Fraction(0)
    if isinstance(tree, Constant):
        return [(CONSTANT, tree.value)]
    if isinstance(tree, Variable):
        return [(VIOLATION if tree.violation else COST, Fraction(tree.task))]
    code = _instructions(tree.operands[0])
    for operand in tree.operands[1:]:
        code += [*_instructions(operand), (_BINARY[tree.name], nothing)]
    return [*code, (ABSOLUTE, nothing)] if tree.name == "abs" else code


@bare_kernel
def evaluate(programs: Programs, formula: int, costs: np.ndarray, violations: np.ndarray) -> tuple[float, float]:
    """Return the weighted value of a formula in units of mu, and a bound of its error (running error analysis).

    Whole numbers up to 2^53 are added, subtracted and multiplied without error.

    Args:
        programs: formulas.
        formula: number of the formula.
        costs: (N,) task costs in units, whole.
        violations: (N,) violation costs in units, whole.
    """
    stack = programs.stack
    top = -1
    for at in range(programs.first[formula], programs.first[formula + 1]):
        operation, argument = programs.operation[at], programs.argument[at]
        if operation == CONSTANT or operation == COST or operation == VIOLATION:
            top += 1
            stack[top, 0], stack[top, 1] = argument, programs.error[at]
            if operation == COST:
                stack[top, 0] = costs[int(argument)]
            elif operation == VIOLATION:
                stack[top, 0] = violations[int(argument)]
        elif operation == ABSOLUTE:
            stack[top, 0] = abs(stack[top, 0])
        elif operation == CALL:
            top += 1
            for i in range(costs.shape[0]):
                programs.user[0, i] = costs[i] * programs.units[0]
                programs.user[1, i] = violations[i] * programs.units[1]
            value = programs.callback(programs.user[0].ctypes, programs.user[1].ctypes, costs.shape[0])
            stack[top, 0], stack[top, 1] = value, abs(value) * FUNCTION_ROUNDING
        else:
            top -= 1
            a, b = stack[top, 0], stack[top + 1, 0]
            a_error, b_error = stack[top, 1], stack[top + 1, 1]
            value, error = a, a_error + b_error
            if operation == ADD:
                value = a + b
            elif operation == SUBTRACT:
                value = a - b
            elif operation == MULTIPLY:
                value = a * b
                error = abs(a) * b_error + abs(b) * a_error + a_error * b_error
            elif operation == DIVIDE:
                value = a / b if abs(b) > b_error else np.nan
                error = (a_error + abs(value) * b_error) / (abs(b) - b_error)
            else:
                value = min(a, b) if operation == MINIMUM else max(a, b)
                error = max(a_error, b_error)
            picked = operation == MINIMUM or operation == MAXIMUM
            whole = operation != DIVIDE and error == 0 and a == np.floor(a) and b == np.floor(b)
            if not picked and not (whole and abs(value) <= LARGEST_WHOLE):
                error = error * (1 + ROUNDING) + abs(value) * ROUNDING
            stack[top, 0], stack[top, 1] = value, error
    return stack[0, 0], stack[0, 1]


class Callback(types.WrapperAddressProtocol):
    """A Python function behind a C pointer. Its exceptions are kept, as they cannot pass through compiled code."""

    def __init__(self, function: Callable[[Any, Any], float]) -> None:
        """Take a function of two float64 arrays of shape (N,)."""
        self.error: BaseException | None = None

        @cache
        def array(address: int, count: int) -> np.ndarray:
            # The search passes the same addresses at every call.
            return np.ctypeslib.as_array((ctypes.c_double * count).from_address(address))

        def call(costs: int, violations: int, count: int) -> float:
            try:
                return float(function(array(costs, count), array(violations, count)))
            except BaseException as error:
                self.error = error
                return float("nan")

        self._call = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_ssize_t)(call)

    def __wrapper_address__(self) -> int:
        """Return the address of the C function."""
        return ctypes.cast(self._call, ctypes.c_void_p).value or 0

    def signature(self) -> Any:
        """Return the type of the C function."""
        return SIGNATURE
