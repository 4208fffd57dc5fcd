"""Contracts: properties of a preference function that the search relies on, weakest last.

- `additive`: along a plan, mu grows at a rate that depends only on which tasks are satisfied
- `convex`: the same plus convex non-decreasing functions of one task's cost each, or one weighted maximum alone
- `componentwise`: mu does not decrease if the cost of a task grows
- `general`: mu does not decrease along a plan; the search needs a bound of the total cost

A contract that the user declares is tested on random costs, which can refute it but not prove it; contracts that the
planner derives hold by construction.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from prefplan.errors import PreferenceError
from prefplan.limits import check_limits
from prefplan.preferences.terms import OpaqueTerm

CONTRACTS = ("additive", "convex", "componentwise", "general")

TRIALS = 2000
SEED = 2023
"""Fixed, so that the same preference is always accepted or always refused."""

TOLERANCE = 1e-9
"""Relative tolerance for Python functions, which compute in floating point; expressions are exact."""

LARGEST = 1e200
"""Sums of values beyond this might overflow."""

CostLists = tuple[list[Fraction], list[Fraction]]


@dataclass(frozen=True)
class Span:
    """Range of the random costs: whole multiples of the smallest, of every order of magnitude up to the largest."""

    smallest: Fraction = Fraction(1)
    largest: Fraction = Fraction(2000)

    def draw(self, rng: random.Random) -> Fraction:
        """Return a random cost: sometimes zero, often small."""
        kind = rng.random()
        if kind < 0.15:
            return Fraction(0)
        most = max(1, int(self.largest / self.smallest))
        if kind < 0.5:
            return self.smallest * rng.randint(1, min(20, most))
        return self.smallest * rng.randint(1, 2 ** rng.randint(0, most.bit_length()))


def check_claim(formula: OpaqueTerm, tasks: Sequence[str], where: str, span: Span) -> None:
    """Test a contract that the user declared on costs of a problem's size; errors as in the other checks."""
    check_never_falls(formula, tasks, where, span)
    check_contract(formula, tasks, where, span)


def check_size(formula: OpaqueTerm, tasks: Sequence[str], where: str) -> None:
    """Raise PreferenceError if mu, which is known never to fall or be negative, is too large at large costs."""
    large = [Span().largest] * len(tasks)
    value_at((large, large), formula, tasks, where)


def check_never_falls(formula: OpaqueTerm, tasks: Sequence[str], where: str, span: Span = Span()) -> None:
    """Raise PreferenceError if mu falls along some trajectory, or is negative or not a number (Definition 5)."""
    rng = random.Random(SEED)
    for _ in range(TRIALS // 4):
        check_limits()
        before, *others = _trajectory(rng, len(tasks), span)
        before_value = value_at(before, formula, tasks, where)
        for after in others:
            value = value_at(after, formula, tasks, where)
            if _less(value, before_value):
                raise PreferenceError(
                    f"{where}: falls along a trajectory, from {float(before_value):g} "
                    f"at {text_of_costs(before, tasks)} "
                    f"to {float(value):g} at {text_of_costs(after, tasks)}"
                )
            before, before_value = after, value
        for i in formula.violations:
            dearer = before[0], [v + span.draw(rng) * (k == i) for k, v in enumerate(before[1])]
            if _less(value := value_at(dearer, formula, tasks, where), before_value):
                raise PreferenceError(
                    f"{where}: falls as a violation cost rises, from {float(before_value):g} at "
                    f"{text_of_costs(before, tasks)} to {float(value):g} at {text_of_costs(dearer, tasks)}"
                )


def check_contract(formula: OpaqueTerm, tasks: Sequence[str], where: str, span: Span = Span()) -> None:
    """Raise PreferenceError if a pair of random cost vectors refutes a formula's contract."""
    rng = random.Random(SEED)
    for _ in range(TRIALS):
        check_limits()
        match formula.contract:
            case "componentwise":
                low, high = _ordered_pair(rng, len(tasks), span)
                a, b = (value_at(vector, formula, tasks, where) for vector in (low, high))
                if _less(b, a):
                    raise PreferenceError(
                        f"{where}: not componentwise: {float(a):g} at {text_of_costs(low, tasks)} "
                        f"but only {float(b):g} at {text_of_costs(high, tasks)}"
                    )
            case "additive" | "convex":
                _check_key(rng, formula, tasks, where, span)


def _check_key(rng: random.Random, formula: OpaqueTerm, tasks: Sequence[str], where: str, span: Span) -> None:
    """Raise PreferenceError if, of two random labels with one satisfied set, the better by (cost, mu) falls behind."""
    n = len(tasks)
    satisfied = {i for i in range(n) if rng.random() < 0.5}
    spent = sorted(span.draw(rng) for _ in range(2))
    frozen = [[span.draw(rng) % (g + span.smallest) for _ in range(n)] for g in spent]
    paid = [[span.draw(rng) if formula.violations else Fraction(0) for _ in range(n)] for _ in spent]
    if formula.contract == "additive" and rng.random() < 0.5:
        spent[1] = spent[0]
        frozen[1] = [min(c, spent[0]) for c in frozen[1]]

    def vector(k: int, more: dict[int, Fraction], total: Fraction) -> CostLists:
        costs = [frozen[k][i] if i in satisfied else spent[k] + more.get(i, total) for i in range(n)]
        return costs, paid[k]

    start = [vector(k, {}, Fraction(0)) for k in (0, 1)]
    values = [value_at(v, formula, tasks, where) for v in start]
    if _less(values[1], values[0]):
        if spent[0] < spent[1]:
            return
        values, start, frozen, paid = values[::-1], start[::-1], frozen[::-1], paid[::-1]
    total = span.draw(rng)
    more = {i: span.draw(rng) % (total + span.smallest) for i in range(n) if i not in satisfied and rng.random() < 0.5}
    ends = [vector(k, more, total) for k in (0, 1)]
    after = [value_at(v, formula, tasks, where) for v in ends]
    grew = [y - x for x, y in zip(values, after, strict=True)]
    same = formula.contract == "convex" or abs(grew[0] - grew[1]) <= TOLERANCE * max(1, *map(abs, after))
    if _less(after[1], after[0]) or not same:
        first, second = (
            f"from {float(values[k]):g} at {text_of_costs(start[k], tasks)} "
            f"to {float(after[k]):g} at {text_of_costs(ends[k], tasks)}"
            for k in (0, 1)
        )
        raise PreferenceError(f"{where}: not {formula.contract}: mu grows {first}, but {second}")


def _trajectory(rng: random.Random, n: int, span: Span) -> list[CostLists]:
    costs, paid, open_ = [Fraction(0)] * n, [Fraction(0)] * n, set(range(n))
    result = [(list(costs), list(paid))]
    for _ in range(rng.randint(1, 2 * n + 2)):
        step = span.draw(rng)
        for i in open_:
            costs[i] += step
            if rng.random() < 0.3:
                paid[i] += span.draw(rng)
        open_ -= {i for i in open_ if rng.random() < 0.3}
        result.append((list(costs), list(paid)))
    return result


def _ordered_pair(rng: random.Random, n: int, span: Span) -> tuple[CostLists, CostLists]:
    low = [[span.draw(rng) for _ in range(n)] for _ in range(2)]
    high = [[x + (span.draw(rng) if rng.random() < 0.5 else 0) for x in values] for values in low]
    return (low[0], low[1]), (high[0], high[1])


def value_at(vector: CostLists, formula: OpaqueTerm, tasks: Sequence[str], where: str) -> Any:
    """Return mu of a cost vector: a fraction for an expression, a float for a function.

    Raises:
        PreferenceError: if it cannot be computed, is NaN, negative or too large.
    """
    try:
        value = formula.value(*vector)
        number = float(value)
    except Exception as error:
        raise PreferenceError(
            f"{where}: fails at {text_of_costs(vector, tasks)}: {error} (it gets two arrays, costs and violations, "
            "in the order of the tasks, and returns a number)"
        ) from None
    if number != number or abs(number) > LARGEST:
        raise PreferenceError(f"{where}: is {number:g} at {text_of_costs(vector, tasks)}")
    if number < 0:
        raise PreferenceError(
            f"{where}: must not be negative, but is {number:g} at {text_of_costs(vector, tasks)}; write max(0, ...)"
        )
    return value


def _less(a: Any, b: Any) -> bool:
    return a < b if isinstance(a, Fraction) else a < b - TOLERANCE * max(abs(a), abs(b))


def text_of_costs(vector: CostLists, tasks: Sequence[str]) -> str:
    """Return a cost vector in words."""
    costs = ", ".join(f"{name}={float(c):g}" for name, c in zip(tasks, vector[0], strict=True))
    if any(vector[1]):
        costs += "; violation " + ", ".join(f"{t}={float(v):g}" for t, v in zip(tasks, vector[1], strict=True))
    return f"({costs})"
