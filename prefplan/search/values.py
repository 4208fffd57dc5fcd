"""Values of expressions and Python functions in label keys: the kernel calls `Values` once for each label.

Expressions are turned into Python functions of a label's key, and computed exactly. If their values are not whole,
entries are integers in the order of the nearest floats (`ordered_number`). Rounding comes last: differences of rounded
terms would be noise where they should be zero. Python functions compute in floats.
"""

import ctypes
import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numba.experimental.function_type  # so that the first kernel called can be given a C function  # noqa: F401
import numpy as np
from numba import types

from prefplan.errors import PreferenceError
from prefplan.models.kernels import INFINITE
from prefplan.preferences.contracts import LARGEST, text_of_costs, value_at
from prefplan.preferences.expression import FUNCTIONS, Operation, Variable, fold, scaled
from prefplan.preferences.objective import Measure
from prefplan.preferences.terms import OpaqueTerm
from prefplan.search.keys import FALL, KeyEntry, KeyMap, ordered_number
from prefplan.search.labels import END, TASK, VALUE, VIOLATION

ValueOf = Callable[[Sequence[int]], Any]
"""Returns a value, given a key with the first cost in units."""


class Values(types.WrapperAddressProtocol):
    """The values in label keys, behind a C pointer.

    Attributes:
        error: the exception that ended a call, if one did: exceptions cannot pass through compiled code.
    """

    def __init__(self, layout: KeyMap, key_of: Callable[[int], np.ndarray]) -> None:
        """Take the layout, and a function that returns the key of a label."""
        self._layout, self._key_of = layout, key_of
        self.error: BaseException | None = None
        self._each = [
            (e, entry.objective, self._value(entry, entry.objective))
            for e, entry in enumerate(layout.entries)
            if entry.how == VALUE and entry.objective is not None
        ]
        self._pointer = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64)(self.__call__)

    def __wrapper_address__(self) -> int:
        """Return the address of the C function."""
        return ctypes.cast(self._pointer, ctypes.c_void_p).value or 0

    def signature(self) -> Any:
        """Return the type of the C function."""
        return types.int64(types.int64)

    def __call__(self, label: int) -> int:
        """Enter the values into the key of a label; return ENTERED, or TOO_LARGE if there is an `error`.

        The key has the values of the parent before; a value that falls by rounding only is left as it was.
        """
        try:
            self._enter(self._key_of(label))
            return int(END.ENTERED)
        except BaseException as error:
            self.error = error
            return int(END.TOO_LARGE)

    def _enter(self, key: np.ndarray) -> None:
        """Enter the values into a key.

        Raises:
            PreferenceError: a formula has no value or a negative one, or a preference is less than before.
            OverflowError: a value is too large.
        """
        exact = key.tolist()
        exact[0] >>= self._layout.shift
        for e, o, value_of in self._each:
            try:
                value = value_of(exact) if o.is_whole else float(value_of(exact))
            except Exception:  # `value_at` says why
                value = math.nan
            if not 0 <= value <= (INFINITE if o.is_whole else LARGEST):
                for formula in self._layout.entries[e].formulas:
                    value_at(self._layout.amounts(o, exact), formula, self._layout.problem.priced, self._name(o))
                raise OverflowError
            entry, slack = (value, 0) if o.is_whole else (ordered_number(value), FALL)
            if entry + slack < exact[e]:
                if e >= len(self._layout.problem.objective_names):
                    raise OverflowError
                at = text_of_costs(self._layout.amounts(o, exact), self._layout.problem.priced)
                raise PreferenceError(f"{self._name(o)}: mu falls along a trajectory, on the last action to {at}")
            if entry > exact[e]:
                key[e] = exact[e] = entry

    def _value(self, entry: KeyEntry, o: Measure) -> ValueOf:
        """Return a function that computes an entry, in units of mu, or in the user's units if values are not whole."""
        unit, names = Fraction(1) if o.is_whole else o.unit, dict[str, Any]({"Fraction": Fraction})
        terms = [f"k[{part}] * {_text_of(unit)}" for part in entry.parts]
        terms += [self._text(o, formula, names) for formula in entry.formulas]
        value: ValueOf = eval(f"lambda k: {' + '.join(terms)}", names)
        return value

    def _text(self, o: Measure, formula: OpaqueTerm, names: dict[str, Any]) -> str:
        """Return an expression as Python over a key, and add the functions that it calls to the `names`."""
        tree, rest = scaled(formula.tree, o.cost_unit, o.price_unit)
        ratio = "({} / {})" if isinstance(tree, Operation) and callable(tree.name) else "Fraction({}, {})"

        def variable(one: Variable) -> str:
            how, cost = (VIOLATION, 0) if one.violation else (TASK, o.cost)
            place = self._layout.place(how, cost, one.task)
            return "0" if place is None else f"k[{place}]"

        def operation(name: str | Callable[..., float], *parts: str) -> str:
            if callable(name):
                names[called := f"f{len(names)}"] = name
                return f"{called}({', '.join(parts)})"
            if name in FUNCTIONS:
                return f"{name}({', '.join(parts)})" if len(parts) > 1 or name == "abs" else parts[0]
            return ratio.format(*parts) if name == "/" else f"({parts[0]} {name} {parts[1]})"

        factor = Fraction(formula.weight * rest / (o.unit if o.is_whole else 1))
        return f"{fold(tree, _text_of, variable, operation)} * {_text_of(factor)}"

    def _name(self, o: Measure) -> str:
        return next(named.key for named in self._layout.problem.preferences if named.name == o.name)


def _text_of(value: Fraction) -> str:
    return str(value.numerator) if value.denominator == 1 else repr(value)
