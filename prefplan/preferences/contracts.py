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
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from prefplan.errors import PreferenceError
from prefplan.limits import check_limits
from prefplan.preferences.terms import OpaqueTerm

CONTRACTS = ("additive", "convex", "componentwise", "general")

TRIALS = 2000
"""Number of pairs of costs on which a contract is tested; of trajectories there are a quarter of these."""

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


def check_size(formula: OpaqueTerm, tasks: Sequence[str], where: str) -> None:
    """Raise PreferenceError if mu, which is proven never to fall or be negative, is too large at large costs."""
    large = [Span().largest] * len(tasks)
    value_at((large, large), formula, tasks, where)


def check_never_falls(formula: OpaqueTerm, tasks: Sequence[str], where: str, span: Span = Span()) -> None:
    """Raise PreferenceError if mu falls along some trajectory, or is negative or not a number (Definition 5)."""
    trials = _Trials(formula, tasks, where, span)
    for _ in range(TRIALS // 4):
        check_limits()
        trajectory = trials.trajectory()
        before = next(trajectory)
        for after in trajectory:
            if after < before:
                raise PreferenceError(f"{where}: falls along a trajectory, from {before} to {after}")
            before = after
        for i in formula.violations:
            dearer = trials.at(before.costs, [v + trials.draw() * (k == i) for k, v in enumerate(before.violations)])
            if dearer < before:
                raise PreferenceError(f"{where}: falls as a violation cost rises, from {before} to {dearer}")


def check_contract(formula: OpaqueTerm, tasks: Sequence[str], where: str, span: Span = Span()) -> None:
    """Raise PreferenceError if a pair of random cost vectors refutes a formula's contract, if it is not `general`."""
    if formula.contract == "general":
        return
    trials = _Trials(formula, tasks, where, span)
    for _ in range(TRIALS):
        check_limits()
        if formula.contract == "componentwise":
            trials.compare_costs()
        else:
            trials.compare_labels()


@dataclass(frozen=True)
class _Point:
    """mu at some costs and violation costs."""

    value: Any
    costs: list[Fraction]
    violations: list[Fraction]
    tasks: Sequence[str]

    def __lt__(self, other: _Point) -> bool:
        """Return whether mu is less than at another point, by more than a function may be wrong."""
        if isinstance(self.value, Fraction):
            return bool(self.value < other.value)
        return bool(self.value < other.value - TOLERANCE * max(abs(self.value), abs(other.value)))

    def __str__(self) -> str:
        """Return the value and the costs in words."""
        return f"{float(self.value):g} at {text_of_costs((self.costs, self.violations), self.tasks)}"


class _Trials:
    """Random costs of N tasks and rules, at which a formula is evaluated."""

    def __init__(self, formula: OpaqueTerm, tasks: Sequence[str], where: str, span: Span) -> None:
        self._formula, self._tasks, self._where, self._span = formula, tasks, where, span
        self._rng, self._size = random.Random(SEED), len(tasks)

    def draw(self) -> Fraction:
        return self._span.draw(self._rng)

    def at(self, costs: list[Fraction], violations: list[Fraction]) -> _Point:
        value = value_at((costs, violations), self._formula, self._tasks, self._where)
        return _Point(value, costs, violations, self._tasks)

    def trajectory(self) -> Iterator[_Point]:
        """Yield mu along a trajectory, from its start on."""
        costs, violations, unsatisfied = [Fraction(0)] * self._size, [Fraction(0)] * self._size, set(range(self._size))
        yield self.at([*costs], [*violations])
        for _ in range(self._rng.randint(1, 2 * self._size + 2)):
            step = self.draw()
            for i in unsatisfied:
                costs[i] += step
                if self._rng.random() < 0.3:
                    violations[i] += self.draw()
            unsatisfied -= {i for i in unsatisfied if self._rng.random() < 0.3}
            yield self.at([*costs], [*violations])

    def compare_costs(self) -> None:
        """Raise PreferenceError if mu is less at larger costs."""
        low = [[self.draw() for _ in range(self._size)] for _ in range(2)]
        high = [[x + (self.draw() if self._rng.random() < 0.5 else 0) for x in values] for values in low]
        cheap, dear = self.at(*low), self.at(*high)
        if dear < cheap:
            raise PreferenceError(f"{self._where}: not componentwise: {cheap} but only {dear}")

    def compare_labels(self) -> None:
        """Raise PreferenceError if, of two labels with one satisfied set, the better by (cost, mu) falls behind."""
        tasks, rng, contract = range(self._size), self._rng, self._formula.contract
        satisfied = {i for i in tasks if rng.random() < 0.5}
        spent = sorted(self.draw() for _ in range(2))
        if contract == "additive" and rng.random() < 0.5:
            spent[1] = spent[0]
        frozen = [[self.draw() % (g + self._span.smallest) for _ in tasks] for g in spent]
        violations = [[self.draw() if self._formula.violations else Fraction(0) for _ in tasks] for _ in spent]

        def after(k: int, steps: Sequence[Fraction]) -> _Point:
            costs = [frozen[k][i] if i in satisfied else spent[k] + steps[i] for i in tasks]
            return self.at(costs, violations[k])

        better, worse = 0, 1
        starts = [after(k, [Fraction(0)] * self._size) for k in (better, worse)]
        if starts[worse] < starts[better]:
            if spent[0] < spent[1]:
                return
            better, worse = worse, better
        total = self.draw()
        steps = [self.draw() % (total + self._span.smallest) if rng.random() < 0.5 else total for _ in tasks]
        ends = [after(k, steps) for k in (0, 1)]
        first, second = (ends[k].value - starts[k].value for k in (better, worse))
        error = TOLERANCE * max(1, *(abs(end.value) for end in ends))
        if ends[worse] < ends[better] or (contract == "additive" and abs(first - second) > error):
            grows = [f"from {starts[k]} to {ends[k]}" for k in (better, worse)]
            raise PreferenceError(f"{self._where}: not {contract}: mu grows {grows[0]}, but {grows[1]}")


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


def text_of_costs(vector: CostLists, tasks: Sequence[str]) -> str:
    """Return a cost vector in words."""
    costs = ", ".join(f"{name}={float(c):g}" for name, c in zip(tasks, vector[0], strict=True))
    if any(vector[1]):
        costs += "; violation " + ", ".join(f"{t}={float(v):g}" for t, v in zip(tasks, vector[1], strict=True))
    return f"({costs})"
