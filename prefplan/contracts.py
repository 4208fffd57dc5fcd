"""Contracts: what may be assumed of a preference function, tried on random costs before it is relied on.

A contract can be refuted by example, never proven; the ones that the planner derives itself are shown by construction.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction

from prefplan.errors import PreferenceError
from prefplan.terms import Formula

CONTRACTS = ("additive", "convex", "componentwise", "general")

TRIALS = 2000
SEED = 2023
"""Fixed, so that the same preference is always accepted or always refused."""

TOLERANCE = 1e-9
"""Relative; functions and divisions are computed in floating point."""

LARGEST = 1e200
"""Values beyond this would overflow when they are added up."""

Vector = tuple[list[Fraction], list[Fraction]]


def check_never_falls(formula: Formula, tasks: Sequence[str], where: str) -> None:
    """Raise PreferenceError if mu falls along some trajectory, or is negative or not a number (Definition 5)."""
    rng = random.Random(SEED)
    for _ in range(TRIALS // 4):
        before, before_value = None, 0.0
        for after in _trajectory(rng, len(tasks)):
            value = value_at(after, formula, tasks, where)
            if before is not None and _less(value, before_value):
                raise PreferenceError(
                    f"{where}: falls along a trajectory, from {before_value:g} at {_text(before, tasks)} "
                    f"to {value:g} at {_text(after, tasks)}"
                )
            before, before_value = after, value


def check_contract(formula: Formula, tasks: Sequence[str], where: str) -> None:
    """Raise PreferenceError with a pair of cost vectors that refutes a formula's contract, if one is found."""
    rng = random.Random(SEED)
    for _ in range(TRIALS):
        match formula.contract:
            case "componentwise":
                low, high = _ordered_pair(rng, len(tasks))
                a, b = (value_at(vector, formula, tasks, where) for vector in (low, high))
                if _less(b, a):
                    raise PreferenceError(
                        f"{where}: not componentwise: {a:g} at {_text(low, tasks)} "
                        f"but only {b:g} at {_text(high, tasks)}"
                    )
            case "additive" | "convex":
                _check_key(rng, formula, tasks, where)


def _check_key(rng: random.Random, formula: Formula, tasks: Sequence[str], where: str) -> None:
    """Refute that the better of two labels with the same satisfied set, by (cost, mu), stays the better one."""
    n = len(tasks)
    satisfied = {i for i in range(n) if rng.random() < 0.5}
    spent = sorted(_number(rng) for _ in range(2))
    frozen = [[_number(rng) % (g + 1) for _ in range(n)] for g in spent]
    paid = [[_number(rng) if formula.violations else Fraction(0) for _ in range(n)] for _ in spent]
    if formula.contract == "additive" and rng.random() < 0.5:
        spent[1] = spent[0]
        frozen[1] = [min(c, spent[0]) for c in frozen[1]]

    def vector(k: int, more: dict[int, Fraction], total: Fraction) -> Vector:
        costs = [frozen[k][i] if i in satisfied else spent[k] + more.get(i, total) for i in range(n)]
        return costs, paid[k]

    start = [vector(k, {}, Fraction(0)) for k in (0, 1)]
    values = [value_at(v, formula, tasks, where) for v in start]
    if _less(values[1], values[0]):
        if spent[0] < spent[1]:
            return
        values, start, frozen, paid = values[::-1], start[::-1], frozen[::-1], paid[::-1]
    total = _number(rng)
    more = {i: _number(rng) % (total + 1) for i in range(n) if i not in satisfied and rng.random() < 0.5}
    ends = [vector(k, more, total) for k in (0, 1)]
    after = [value_at(v, formula, tasks, where) for v in ends]
    grew = [y - x for x, y in zip(values, after, strict=True)]
    same = formula.contract == "convex" or abs(grew[0] - grew[1]) <= TOLERANCE * max(1, *map(abs, after))
    if _less(after[1], after[0]) or not same:
        raise PreferenceError(
            f"{where}: not {formula.contract}: mu grows from {values[0]:g} at {_text(start[0], tasks)} to {after[0]:g} "
            f"at {_text(ends[0], tasks)}, but from {values[1]:g} at {_text(start[1], tasks)} to {after[1]:g} "
            f"at {_text(ends[1], tasks)}"
        )


def _trajectory(rng: random.Random, n: int) -> list[Vector]:
    costs, paid, open_ = [Fraction(0)] * n, [Fraction(0)] * n, set(range(n))
    result = [(list(costs), list(paid))]
    for _ in range(rng.randint(1, 2 * n + 2)):
        step = _number(rng)
        for i in open_:
            costs[i] += step
            if rng.random() < 0.3:
                paid[i] += _number(rng)
        open_ -= {i for i in open_ if rng.random() < 0.3}
        result.append((list(costs), list(paid)))
    return result


def _ordered_pair(rng: random.Random, n: int) -> tuple[Vector, Vector]:
    low = [[_number(rng) for _ in range(n)] for _ in range(2)]
    high = [[x + (_number(rng) if rng.random() < 0.5 else 0) for x in some] for some in low]
    return (low[0], low[1]), (high[0], high[1])


def _number(rng: random.Random) -> Fraction:
    """Return zero now and then, small numbers mostly, and large ones sometimes."""
    kind = rng.random()
    return Fraction(0 if kind < 0.15 else rng.randint(1, 20) if kind < 0.7 else rng.randint(1, 2000))


def value_at(vector: Vector, formula: Formula, tasks: Sequence[str], where: str) -> float:
    """Return mu of a cost vector.

    Raises:
        PreferenceError: if it cannot be worked out, is not a number, negative or too large.
    """
    try:
        number = float(formula.value(*vector))
    except Exception as error:
        raise PreferenceError(f"{where}: fails at {_text(vector, tasks)}: {error}") from None
    if number != number or abs(number) > LARGEST:
        raise PreferenceError(f"{where}: is {number:g} at {_text(vector, tasks)}")
    if number < 0:
        raise PreferenceError(f"{where}: must not be negative, but is {number:g} at {_text(vector, tasks)}")
    return number


def _less(a: float, b: float) -> bool:
    return a < b - TOLERANCE * max(1.0, abs(a), abs(b))


def _text(vector: Vector, tasks: Sequence[str]) -> str:
    costs = ", ".join(f"{name}={float(c):g}" for name, c in zip(tasks, vector[0], strict=True))
    if any(vector[1]):
        costs += "; violation " + ", ".join(f"{t}={float(v):g}" for t, v in zip(tasks, vector[1], strict=True))
    return f"({costs})"
