"""Formulas in a form that compiled kernels can evaluate: stack programs, and Python functions behind a C pointer."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numba
import numpy as np
from numba import types

from prefplan.expression import Constant, Expression, Variable
from prefplan.kernels import bare_kernel
from prefplan.terms import Formula

CONSTANT, COST, VIOLATION, ADD, SUBTRACT, MULTIPLY, DIVIDE, MINIMUM, MAXIMUM, ABSOLUTE, CALL = range(11)
_BINARY = {"+": ADD, "-": SUBTRACT, "*": MULTIPLY, "/": DIVIDE, "min": MINIMUM, "max": MAXIMUM}

SIGNATURE = types.float64(types.CPointer(types.float64), types.CPointer(types.float64), types.intp)
"""(costs, violations, N) -> value."""


class Programs(NamedTuple):
    """F stack programs, one after the other.

    Attributes:
        first: (F + 1,) int64, where each begins.
        operation: (P,) int8 and argument: (P,) float64 of each instruction.
        stack: (depth,) float64, scratch.
    """

    first: np.ndarray
    operation: np.ndarray
    argument: np.ndarray
    stack: np.ndarray


def compile_programs(formulas: list[Formula]) -> Programs:
    """Return formulas as stack programs, their weights included; functions become calls."""
    code: list[tuple[int, float]] = []
    first = [0]
    for formula in formulas:
        code += [(CALL, 0.0)] if formula.tree is None else _instructions(formula.tree)
        code += [(CONSTANT, float(formula.weight)), (MULTIPLY, 0.0)]
        first.append(len(code))
    return Programs(
        np.array(first, dtype=np.int64),
        np.array([operation for operation, _ in code], dtype=np.int8),
        np.array([argument for _, argument in code], dtype=np.float64),
        np.zeros(len(code) + 1, dtype=np.float64),
    )


def _instructions(tree: Expression) -> list[tuple[int, float]]:
    if isinstance(tree, Constant):
        return [(CONSTANT, float(tree.value))]
    if isinstance(tree, Variable):
        return [(VIOLATION if tree.violation else COST, float(tree.task))]
    code = _instructions(tree.operands[0])
    for operand in tree.operands[1:]:
        code += [*_instructions(operand), (_BINARY[tree.name], 0.0)]
    return [*code, (ABSOLUTE, 0.0)] if tree.name == "abs" else code


@bare_kernel
def evaluate(programs: Programs, formula: int, costs: np.ndarray, violations: np.ndarray, callback: Any) -> float:
    """Return the weighted value of a formula, for costs and violation costs in the user's units."""
    stack = programs.stack
    top = -1
    for at in range(programs.first[formula], programs.first[formula + 1]):
        operation, argument = programs.operation[at], programs.argument[at]
        if operation == CONSTANT:
            top += 1
            stack[top] = argument
        elif operation == COST:
            top += 1
            stack[top] = costs[int(argument)]
        elif operation == VIOLATION:
            top += 1
            stack[top] = violations[int(argument)]
        elif operation == ABSOLUTE:
            stack[top] = abs(stack[top])
        elif operation == CALL:
            top += 1
            stack[top] = callback(costs.ctypes, violations.ctypes, costs.shape[0])
        else:
            top -= 1
            if operation == ADD:
                stack[top] += stack[top + 1]
            elif operation == SUBTRACT:
                stack[top] -= stack[top + 1]
            elif operation == MULTIPLY:
                stack[top] *= stack[top + 1]
            elif operation == DIVIDE:
                stack[top] /= stack[top + 1]
            elif operation == MINIMUM:
                stack[top] = min(stack[top], stack[top + 1])
            else:
                stack[top] = max(stack[top], stack[top + 1])
    return stack[0]


@cache
def no_callback() -> Any:
    """Return what stands for the function where there is none."""

    @numba.cfunc(SIGNATURE)
    def nothing(costs: Any, violations: Any, count: Any) -> float:
        return 0.0

    return nothing


def callback(function: Callable[[Any, Any], float], tasks: int) -> Any:
    """Return a Python function of two arrays behind a C pointer: compiled by numba where that gives the same values."""
    try:
        compiled = function if isinstance(function, numba.core.dispatcher.Dispatcher) else numba.njit(function)

        @numba.njit
        def guarded(costs: Any, violations: Any) -> float:
            try:
                return compiled(costs, violations)
            except Exception:
                return np.nan

        @numba.cfunc(SIGNATURE)
        def bridge(costs: Any, violations: Any, count: Any) -> float:
            return guarded(numba.carray(costs, (count,)), numba.carray(violations, (count,)))

        return bridge if _agree(function, guarded, tasks) else _Interpreted(function)
    except Exception:
        # What cannot be compiled raises more than numba's own errors; Python can still run it.
        return _Interpreted(function)


def _agree(function: Callable[[Any, Any], float], compiled: Callable[[Any, Any], float], tasks: int) -> bool:
    """Return whether a compiled function gives Python's values on some costs."""
    rng = np.random.default_rng(0)
    for scale in (0, 1, 7.25, 100, 1e4):
        arguments = rng.integers(0, 9, (2, tasks)) * float(scale)
        try:
            if not np.isclose(float(function(*arguments)), compiled(*arguments), rtol=1e-12, equal_nan=True):
                return False
        except Exception:
            return False
    return True


class _Interpreted(types.WrapperAddressProtocol):
    """A function that stays in Python. What it raises is kept, as it cannot pass through compiled code."""

    def __init__(self, function: Callable[[Any, Any], float]) -> None:
        self.error: BaseException | None = None
        pointer = ctypes.POINTER(ctypes.c_double)

        def call(costs: Any, violations: Any, count: int) -> float:
            try:
                shape = (count,)
                return float(function(np.ctypeslib.as_array(costs, shape), np.ctypeslib.as_array(violations, shape)))
            except BaseException as error:
                self.error = error
                return float("nan")

        self._call = ctypes.CFUNCTYPE(ctypes.c_double, pointer, pointer, ctypes.c_ssize_t)(call)

    def __wrapper_address__(self) -> int:
        return ctypes.cast(self._call, ctypes.c_void_p).value or 0

    def signature(self) -> Any:
        return SIGNATURE
