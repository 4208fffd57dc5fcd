"""The terms whose sum is a preference function; `prefplan.preferences.objective` makes label keys of them.

There are N tasks; S is the satisfied set as bits, and g the cost so far, which is the cost of every task not in S.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from prefplan.preferences.expression import Tree, evaluate, variables

Costs = Sequence[Fraction]


@dataclass(frozen=True)
class OrderRate:
    """Additive: the order preference, weighted.

    While S is satisfied, mu grows per unit of cost by the sum over groups G of max(0, #{places of G <= |S|} - |S & G|).
    For groups of one that is Example 3's definition: the costs of satisfied tasks fill the first |S| places of c*, so
    an unsatisfied task at such a place is delayed by every unit spent, and all other differences stay at most 0.

    Attributes:
        groups: the tasks in the desired order; a group's members are interchangeable. Tasks in no group do not count.
        weight: factor.
    """

    groups: tuple[tuple[int, ...], ...]
    weight: Fraction = Fraction(1)

    @property
    def steps(self) -> tuple[Fraction, ...]:
        """Numbers, each >= 0, of some of which every rate is the sum."""
        return (self.weight,) * sum(map(len, self.groups))

    def rates(self, sets: np.ndarray, members: frozenset[int], factor: Fraction) -> np.ndarray:
        """Return the (K,) int64 part of the rate that is due to groups of some tasks alone, times a factor.

        The (K,) int64 sets are satisfied; the factor, which makes rates whole, is a unit of cost in units of mu.
        """
        named = sum(1 << i for group in self.groups for i in group)
        count, place = np.bitwise_count(sets & named).astype(np.int64), 0
        total = np.zeros(len(sets), dtype=np.int64)
        for group in self.groups:
            if members.issuperset(group):
                due = np.clip(count - place, 0, len(group))
                total += np.maximum(0, due - sum(sets >> i & 1 for i in group))
            place += len(group)
        return total * int(self.weight * factor)

    def value(self, costs: Costs, violations: Costs) -> Fraction:
        """Return sum_k max(0, c_{o_k} - c*_k) with each group sorted by cost.

        Sorting attains the smallest sum over a group's orders, as max(0, c - c*) is convex in the difference.
        """
        desired = [c for group in self.groups for c in sorted(costs[i] for i in group)]
        return self.weight * sum(max(Fraction(0), c - ideal) for c, ideal in zip(desired, sorted(desired), strict=True))


@dataclass(frozen=True)
class WeightedRate:
    """Additive: sum_i w_i c_i; it grows by the weights of the unsatisfied tasks."""

    weights: tuple[Fraction, ...]

    @property
    def steps(self) -> tuple[Fraction, ...]:
        """Numbers, each >= 0, of some of which every rate is the sum."""
        return self.weights

    def rates(self, sets: np.ndarray, members: frozenset[int], factor: Fraction) -> np.ndarray:
        """Return the part of the rate that is due to some tasks; see `OrderRate.rates`."""
        return sum(((1 - (sets >> i & 1)) * int(self.weights[i] * factor) for i in members), start=0 * sets)

    def value(self, costs: Costs, violations: Costs) -> Fraction:
        """Return the weighted sum."""
        return sum((w * c for w, c in zip(self.weights, costs, strict=True)), Fraction(0))


@dataclass(frozen=True)
class SpreadRate:
    """Additive: weight * (max - min) of some tasks' costs; it grows while some, but not all, are satisfied."""

    weight: Fraction
    members: frozenset[int]

    @property
    def steps(self) -> tuple[Fraction, ...]:
        """Numbers, each >= 0, of some of which every rate is the sum."""
        return (self.weight,)

    def rates(self, sets: np.ndarray, members: frozenset[int], factor: Fraction) -> np.ndarray:
        """Return the whole rate if `members` has all its tasks, else 0; see `OrderRate.rates`."""
        done = np.bitwise_count(sets & sum(1 << i for i in self.members))
        grows = (done > 0) & (done < len(self.members)) & (self.members <= members)
        return np.where(grows, int(self.weight * factor), 0)

    def value(self, costs: Costs, violations: Costs) -> Fraction:
        """Return the weighted spread."""
        spread = [costs[i] for i in self.members]
        return self.weight * (max(spread) - min(spread))


Rate = OrderRate | WeightedRate | SpreadRate


@dataclass(frozen=True)
class Violation:
    """Additive: a weighted sum of violation costs."""

    weights: tuple[Fraction, ...]

    def value(self, costs: Costs, violations: Costs) -> Fraction:
        """Return the weighted sum."""
        return sum((w * v for w, v in zip(self.weights, violations, strict=True)), Fraction(0))


@dataclass(frozen=True)
class Tardiness:
    """Convex, of a single task's cost: weight * max(0, c - by)."""

    task: int
    by: Fraction
    weight: Fraction

    def value(self, costs: Costs, violations: Costs) -> Fraction:
        """Return the weighted tardiness."""
        return self.weight * max(Fraction(0), costs[self.task] - self.by)


@dataclass(frozen=True)
class Maximum:
    """Convex: max_i weights_i c_i."""

    weights: tuple[Fraction, ...]

    def value(self, costs: Costs, violations: Costs) -> Fraction:
        """Return the weighted maximum."""
        return max(w * c for w, c in zip(self.weights, costs, strict=True))


@dataclass(frozen=True)
class OpaqueTerm:
    """An expression that is none of the above, or a Python function.

    Attributes:
        tree: the expression; None for a function.
        function: (costs, violations) -> value; None for an expression.
        contract: `additive`, `convex`, `componentwise` or `general`; see `prefplan.preferences.contracts`.
        weight: factor.
        claimed: whether the contract was declared by the user: tested, not proven.
        tasks: number of tasks whose costs a function is given.
        rules: number of rules that may be broken, whose violation costs it is given, too.
    """

    tree: Tree | None
    function: Callable[[Any, Any], float] | None
    contract: str
    weight: Fraction = Fraction(1)
    claimed: bool = False
    tasks: int = 0
    rules: int = 0

    @cached_property
    def costs(self) -> tuple[int, ...]:
        """The tasks whose cost matters."""
        if self.tree is None:
            return tuple(range(self.tasks))
        return tuple(sorted(v.task for v in variables(self.tree) if not v.violation))

    @cached_property
    def violations(self) -> tuple[int, ...]:
        """The tasks and rules whose violation cost matters."""
        if self.tree is None:
            return tuple(range(self.tasks + self.rules))
        return tuple(sorted(v.task for v in variables(self.tree) if v.violation))

    def value(self, costs: Costs, violations: Costs) -> Any:
        """Return the value: a fraction for an expression, a float for a function."""
        if self.tree is not None:
            return self.weight * evaluate(self.tree, costs, violations)
        assert self.function is not None
        arguments = (np.array([float(c) for c in costs]), np.array([float(v) for v in violations]))
        return float(self.weight) * float(self.function(*arguments))


Term = OrderRate | WeightedRate | SpreadRate | Violation | Tardiness | Maximum | OpaqueTerm
