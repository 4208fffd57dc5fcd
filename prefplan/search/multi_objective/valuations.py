"""Values of expressions and Python functions, for entries that are computed from others (`entry_map`).

Expressions become short programs of two operands each, in floating point. Where all values are whole, they are exact up
to 2^53, beyond which the search is left to `reference`. Values with divisions, and those of Python functions, are
rounded; their entries are integers in the same order (`ordered_number`).
"""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable
from fractions import Fraction
from functools import reduce
from typing import Any

import numpy as np
from numba import types

from prefplan.errors import PreferenceError
from prefplan.preferences.contracts import TOLERANCE, text_of_costs, value_at
from prefplan.preferences.expression import Constant, Operation, Tree, Variable, scaled
from prefplan.preferences.objective import PreferenceObjective
from prefplan.preferences.terms import OpaqueTerm
from prefplan.search.multi_objective.entries import OPERATIONS, Program
from prefplan.search.multi_objective.entry_map import EntryMap

FALL = 2**19
"""How far an `ordered_number` may fall by rounding: 1e-9 relative."""


def ordered_number(value: float) -> int:
    """Return an integer below INFINITE that is ordered as floats >= 0 are, but for their last three bits."""
    return int(struct.unpack("<q", struct.pack("<d", value))[0]) >> 3


class Functions(types.WrapperAddressProtocol):
    """Python functions behind a C pointer. Exceptions are kept, as they cannot pass through compiled code.

    Attributes:
        error: the exception that a call ended with, if any did.
    """

    def __init__(self) -> None:
        """Begin without any."""
        self.error: BaseException | None = None
        self.functions: list[Callable[[], float]] = []
        self._pointer = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_int64)(self.__call__)

    def __call__(self, number: int) -> float:
        """Return the value of a function for the label in the registers, NaN if there is none."""
        try:
            return self.functions[number]()
        except BaseException as error:
            self.error = error
            return float("nan")

    def __wrapper_address__(self) -> int:
        """Return the address of the C function."""
        return ctypes.cast(self._pointer, ctypes.c_void_p).value or 0

    def signature(self) -> Any:
        """Return the type of the C function."""
        return types.float64(types.int64)


class Valuations:
    """Programs for the computed entries of a label.

    Attributes:
        program: these as arrays for the kernel.
    """

    def __init__(self, layout: EntryMap) -> None:
        """Translate the formulas of a layout."""
        self._layout, self._functions = layout, Functions()
        self._code: list[tuple[int, int, int, int]] = []
        self._registers = [0.0] * layout.size
        computed = []
        for value in layout.values:
            o, whole = value.objective, value.objective.measure.is_whole
            parts = [self._whole_part(o, part) for part in value.parts]
            terms = [*parts, *(self._formula(o, formula) for formula in value.formulas)]
            reduce(lambda a, b: self._emit("+", a, b), terms)
            computed.append((value.entry, len(self._code), 0 if whole else FALL))
        registers = np.array(self._registers)
        self.program = Program(
            np.array(computed, np.int64).reshape(-1, 3),
            np.array(self._code, np.int64).reshape(-1, 4),
            registers,
            registers.view(np.int64),
            self._functions,
        )

    def _emit(self, name: str, a: int, b: int) -> int:
        """Add an instruction and return the register of its result."""
        self._registers.append(0.0)
        self._code.append((OPERATIONS.index(name), a, b, len(self._registers) - 1))
        return len(self._registers) - 1

    def _constant(self, value: Fraction) -> int:
        self._registers.append(float(value))
        return len(self._registers) - 1

    def _whole_part(self, objective: PreferenceObjective, part: int) -> int:
        """Return the register of an entry in units of mu; in the user's units if values are rounded."""
        return part if objective.measure.is_whole else self._emit("*", part, self._constant(objective.units.mu))

    def _formula(self, objective: PreferenceObjective, formula: OpaqueTerm) -> int:
        if formula.tree is None:
            return self._function(objective, formula)
        tree, rest = scaled(formula.tree, objective.units.cost, objective.units.price)
        factor = formula.weight * rest / (objective.units.mu if objective.measure.is_whole else 1)
        return self._tree(Operation("*", (tree, Constant(Fraction(factor)))), objective.cost)

    def _register(self, task: int, cost: int, *, violation: bool = False) -> int:
        """Return the register of a task's cost, or of its violation cost, which is 0 if none are paid."""
        if violation:
            paid = self._layout.paid
            return self._layout.first_paid + paid.index(task) if paid else self._constant(Fraction(0))
        return self._layout.first_frozen + self._layout.frozen.index((cost, task))

    def _tree(self, tree: Tree, cost: int) -> int:
        match tree:
            case Constant(value):
                return self._constant(value)
            case Variable(task, violation):
                return self._register(task, cost, violation=violation)
            case Operation(name, operands):
                parts = [self._tree(operand, cost) for operand in operands]
                if name == "abs":
                    name, parts = "max", [*parts, self._emit("-", self._constant(Fraction(0)), *parts)]
                return reduce(lambda a, b: self._emit(name, a, b), parts)
        raise AssertionError(tree)

    def _function(self, objective: PreferenceObjective, formula: OpaqueTerm) -> int:
        """Return the register of a Python function's value; its arguments are the floats nearest to the exact costs."""
        layout, function, weight = self._layout, formula.function, float(formula.weight)
        assert function is not None
        tasks, everyone = len(layout.problem.tasks), range(len(layout.problem.priced))
        counts = [self._register(i, objective.cost) if i < tasks else self._constant(Fraction(0)) for i in everyone]
        costs = self._in_units(counts, objective.units.cost)
        prices = [self._register(i, objective.cost, violation=True) for i in everyone]
        violations = self._in_units(prices, objective.units.price)

        def evaluate() -> float:
            registers = self.program.registers
            try:
                value = weight * float(function(registers[costs], registers[violations]))
            except Exception:
                value = -1
            return value if value >= 0 else float(self._checked(objective, formula))

        self._functions.functions.append(evaluate)
        return self._emit("call", len(self._functions.functions) - 1, 0)

    def _in_units(self, counts: list[int], unit: Fraction) -> slice:
        """Return registers, one after the other, for whole numbers of a unit in the user's units."""
        by, per = self._constant(Fraction(unit.numerator)), self._constant(Fraction(unit.denominator))
        products = [self._emit("*", count, by) for count in counts]
        quotients = [self._emit("/", product, per) for product in products]
        return slice(quotients[0], quotients[-1] + 1)

    def _checked(self, objective: PreferenceObjective, formula: OpaqueTerm) -> Any:
        """Return the exact value of a formula for the label in the registers.

        Raises:
            PreferenceError: it has none, or a negative one.
        """
        names = self._layout.problem.priced
        return value_at(self._layout.amounts(objective, self._entries), formula, names, self._key(objective))

    @property
    def _entries(self) -> list[int]:
        """The entries of the label in the registers, as `EntryMap.amounts` takes them."""
        return list(map(int, self.program.registers[: self._layout.size].tolist()))

    def _key(self, objective: PreferenceObjective) -> str:
        return next(named.key for named in self._layout.problem.preferences if named.name == objective.name)

    def require_values(self) -> None:
        """Raise the exception of a function, or PreferenceError if some formula has no value for the latest label."""
        if self._functions.error is not None:
            raise self._functions.error
        for value in self._layout.values:
            for formula in value.formulas:
                self._checked(value.objective, formula)

    def require_rise(self, before: tuple[Any, ...]) -> None:
        """Raise PreferenceError if some preference is less for the latest label than it was before its last action.

        Args:
            before: the objectives.
        """
        after = self._layout.objectives(self._entries)
        for place, o in enumerate(self._layout.problem.objectives, self._layout.costs):
            if after[place] < before[place] * (1 if o.measure.is_whole else 1 - TOLERANCE):
                at = text_of_costs(self._layout.amounts(o, self._entries), self._layout.problem.priced)
                raise PreferenceError(f"{self._key(o)}: mu falls along a trajectory, on the last action to {at}")
