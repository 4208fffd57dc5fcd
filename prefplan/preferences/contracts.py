"""Contracts: properties of a preference function that the search relies on, weakest last.

- `additive`: along a plan, mu grows at a rate that depends only on which tasks are satisfied
- `convex`: the same plus convex non-decreasing functions of one task's cost each, or one weighted maximum alone
- `componentwise`: mu does not decrease if the cost of a task grows
- `general`: mu does not decrease along a plan; the search needs a bound of the total cost

A contract that the user declares is tested on random costs, which can refute it but not prove it; contracts that the
planner derives hold by construction.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

from prefplan.errors import PreferenceError
from prefplan.limits import check_limits
from prefplan.preferences.terms import OpaqueTerm

CONTRACTS = ("additive", "convex", "componentwise", "general")

TRIALS = 2000
"""Number of pairs of random costs on which a contract is tested; trajectories are a quarter as many."""

SEED = 2023
"""Fixed, so that the same preference is always accepted or always refused."""

TOLERANCE = 1e-9
"""Relative tolerance for Python functions, which compute in floating point; expressions are exact."""

LARGEST = 1e200
"""Greatest valid value of mu: sums of greater ones might overflow."""

Span = tuple[Fraction, Fraction]
"""The smallest and the largest of the random costs, which are whole multiples of the smallest."""

SPAN = (Fraction(1), Fraction(2000))

CostLists = tuple[list[Fraction], list[Fraction]]
"""Costs and violation costs."""


def check_never_falls(formula: OpaqueTerm, tasks: Sequence[str], where: str, span: Span = SPAN) -> None:
    """Raise PreferenceError if mu falls along some trajectory, or is negative or not a number (Definition 5)."""
    trials = _Trials(formula, tasks, where, span)
    for _ in range(TRIALS // 4):
        check_limits()
        for before, after in pairwise(trials.trajectory()):
            if after < before:
                raise PreferenceError(f"{where}: falls along a trajectory, from {before} to {after}")


def check_contract(formula: OpaqueTerm, tasks: Sequence[str], where: str, span: Span = SPAN) -> None:
    """Raise PreferenceError if random cost vectors refute a formula's contract; `general` is not tested."""
    if formula.contract == "general":
        return
    trials = _Trials(formula, tasks, where, span)
    refutation = trials.fall_at_larger_costs if formula.contract == "componentwise" else trials.unequal_growth
    for _ in range(TRIALS):
        check_limits()
        if (words := refutation()) is not None:
            raise PreferenceError(f"{where}: not {formula.contract}: {words}")


@dataclass(frozen=True)
class _Point:
    """mu at some costs and violation costs."""

    value: Any
    vector: CostLists
    tasks: Sequence[str]

    def __lt__(self, other: _Point) -> bool:
        """Return whether mu is less than at another point, for floats by more than the tolerance."""
        if isinstance(self.value, Fraction):
            return bool(self.value < other.value)
        return bool(self.value < other.value - TOLERANCE * max(abs(self.value), abs(other.value)))

    def __str__(self) -> str:
        """Return the value and the costs in words."""
        return f"{float(self.value):g} at {text_of_costs(self.vector, self.tasks)}"


class _Trials:
    """Random costs of N tasks and rules, as multiples of the smallest, at which a formula is evaluated."""

    def __init__(self, formula: OpaqueTerm, tasks: Sequence[str], where: str, span: Span) -> None:
        self._formula, self._tasks, self._where, (self._unit, largest) = formula, tasks, where, span
        self._rng, self._size, self._most = random.Random(SEED), len(tasks), max(1, int(largest / self._unit))

    def draw(self) -> int:
        """Return a random cost of any order of magnitude, sometimes zero and often small."""
        kind = self._rng.random()
        if kind < 0.15:
            return 0
        if kind < 0.5:
            return self._rng.randint(1, min(20, self._most))
        return self._rng.randint(1, 2 ** self._rng.randint(0, self._most.bit_length()))

    def below(self, most: int) -> int:
        return self.draw() % (most + 1)

    def chance(self, probability: float) -> bool:
        return self._rng.random() < probability

    def at(self, costs: Sequence[int], violations: Sequence[int]) -> _Point:
        vector = [self._unit * c for c in costs], [self._unit * v for v in violations]
        return _Point(value_at(vector, self._formula, self._tasks, self._where), vector, self._tasks)

    def trajectory(self) -> Iterator[_Point]:
        """Yield mu along a random trajectory: at its start, after each step, and after each payment for relaxations."""
        costs, violations, unsatisfied = [0] * self._size, [0] * self._size, set(range(self._size))
        yield self.at(costs, violations)
        for _ in range(self._rng.randint(1, 2 * self._size + 2)):
            step = self.draw()
            for i in unsatisfied:
                costs[i] += step
            yield self.at(costs, violations)
            if self._formula.violations:
                for i in unsatisfied:
                    violations[i] += self.draw() * self.chance(0.3)
                yield self.at(costs, violations)
            unsatisfied -= {i for i in unsatisfied if self.chance(0.3)}

    def fall_at_larger_costs(self) -> str | None:
        """Draw two cost vectors, one of them larger; return in words that mu is less there, or None if it is not."""
        low = [[self.draw() for _ in range(self._size)] for _ in range(2)]
        high = [[x + self.draw() * self.chance(0.5) for x in values] for values in low]
        cheap, dear = self.at(*low), self.at(*high)
        return f"{cheap} but only {dear}" if dear < cheap else None

    def unequal_growth(self) -> str | None:
        """Return in words how the growth of mu at two random labels breaks the contract; None if it does not.

        The labels have the same satisfied set and are continued by the same actions. An additive mu must grow equally;
        else, a label that is cheaper and has no greater mu must keep a mu that is no greater.
        """
        tasks, total = range(self._size), self.draw()
        satisfied = {i for i in tasks if self.chance(0.5)}
        growth = [self.below(total) if self.chance(0.5) else total for _ in tasks]
        points = []
        for spent in sorted((self.draw(), self.draw())):
            costs = [self.below(spent) if i in satisfied else spent for i in tasks]
            later = [c if i in satisfied else c + more for i, (c, more) in enumerate(zip(costs, growth, strict=True))]
            violations = [self.draw() if self._formula.violations else 0 for _ in tasks]
            points += [self.at(costs, violations), self.at(later, violations)]
        cheap, cheap_end, dear, dear_end = points
        error = TOLERANCE * max(1, abs(cheap_end.value), abs(dear_end.value))
        unequal = abs((cheap_end.value - cheap.value) - (dear_end.value - dear.value)) > error
        fails = unequal if self._formula.contract == "additive" else not dear < cheap and dear_end < cheap_end
        return f"mu grows from {cheap} to {cheap_end}, but from {dear} to {dear_end}" if fails else None


def value_at(vector: CostLists, formula: OpaqueTerm, tasks: Sequence[str], where: str) -> Any:
    """Return mu of a cost vector: a fraction for an expression, a float for a function.

    Raises:
        PreferenceError: if it cannot be computed, is NaN, negative or too large.
    """
    try:
        value = formula.value(*vector)
        number = float(value)
    except OverflowError:
        number = math.inf
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
