"""The terms whose sum is a preference function; `prefplan.preferences.objective` makes label keys of them.

There are N tasks; S is the satisfied set, and g the cost so far, which is the cost of every task not in S. While S
stays the same, an additive term over cost grows at a fixed rate: its value where every task not in S costs one unit
and every task in S costs nothing.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, reduce
from itertools import chain
from numbers import Rational
from typing import Any, TypeVar

import numpy as np

from prefplan.errors import PreferenceError, describe
from prefplan.preferences.expression import Tree, evaluate, variables

Costs = Any
"""(P,) fractions; or (P, K) int8, for which terms over cost return K values."""


@dataclass(frozen=True)
class OrderRate:
    """Additive: the order preference, weighted.

    While S is satisfied, mu grows per unit of cost by the sum over groups G of max(0, #{places of G <= |S|} - |S & G|).
    With groups of one task this is Example 3: the costs of satisfied tasks fill the first |S| places of c*, so each
    unit spent delays an unsatisfied task whose place is among these; all other differences stay at most 0.

    Attributes:
        groups: the tasks in the desired order; a group's members are interchangeable. Tasks in no group do not count.
        weight: factor.
    """

    groups: tuple[tuple[int, ...], ...]
    weight: Fraction = Fraction(1)

    def value(self, costs: Costs, violations: Costs) -> Any:
        """Return sum_k max(0, c_{o_k} - c*_k) with each group sorted by cost.

        Sorting attains the smallest sum over a group's orders, as max(0, c - c*) is convex in the difference.
        """
        costs = np.asarray(costs)
        desired = np.concatenate([np.sort(costs[list(group)], axis=0) for group in self.groups])
        return self.weight * np.maximum(0, desired - np.sort(desired, axis=0)).sum(axis=0)


@dataclass(frozen=True)
class WeightedRate:
    """Additive: sum_i w_i c_i; it grows by the weights of the unsatisfied tasks."""

    weights: tuple[Fraction, ...]

    def value(self, costs: Costs, violations: Costs) -> Any:
        """Return the weighted sum."""
        return sum(w * c for w, c in zip(self.weights, costs, strict=True))


@dataclass(frozen=True)
class SpreadRate:
    """Additive: weight * (max - min) of some tasks' costs; it grows while some, but not all, are satisfied."""

    weight: Fraction
    members: frozenset[int]

    def value(self, costs: Costs, violations: Costs) -> Any:
        """Return the weighted spread."""
        spread = np.asarray(costs)[list(self.members)]
        return self.weight * (spread.max(axis=0) - spread.min(axis=0))


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

    def value(self, costs: Costs, violations: Costs) -> Any:
        """Return the weighted maximum."""
        return reduce(np.maximum, (w * c for w, c in zip(self.weights, costs, strict=True)))


@dataclass(frozen=True)
class OpaqueTerm:
    """An expression that is none of the above.

    Attributes:
        tree: the expression.
        contract: `additive`, `convex`, `componentwise` or `general`; see `prefplan.preferences.contracts`.
        weight: factor.
        claimed: whether the contract was declared by the user: tested, not proven.
    """

    tree: Tree
    contract: str
    weight: Fraction = Fraction(1)
    claimed: bool = False

    @cached_property
    def costs(self) -> tuple[int, ...]:
        """The tasks whose cost matters."""
        return tuple(sorted(v.task for v in variables(self.tree) if not v.violation))

    @cached_property
    def violations(self) -> tuple[int, ...]:
        """The tasks and rules whose violation cost matters."""
        return tuple(sorted(v.task for v in variables(self.tree) if v.violation))

    def value(self, costs: Costs, violations: Costs) -> Any:
        """Return the value: a fraction, or a float where a Python function is called."""
        return self.weight * evaluate(self.tree, costs, violations)


Term = OrderRate | WeightedRate | SpreadRate | Violation | Tardiness | Maximum | OpaqueTerm

T = TypeVar("T", bound=Term)


def weights_of(term: Term) -> tuple[Fraction, ...]:
    """Return the weights of a term."""
    return term.weights if isinstance(term, WeightedRate | Violation | Maximum) else (term.weight,)


def with_weights(term: T, change: Callable[[Fraction], Any]) -> T:
    """Return a term with other weights."""
    if isinstance(term, WeightedRate | Violation | Maximum):
        return replace(term, weights=tuple(map(change, term.weights)))
    return replace(term, weight=change(term.weight))


def checked_terms(given: Any, amounts: int) -> tuple[Term | Fraction, ...]:
    """Return what a preference's method `terms` gave for so many tasks and rules, which may be one of a user's own.

    Raises:
        PreferenceError: it is not a list of fractions and terms that fit these.
    """
    if not isinstance(given, Iterable):
        raise PreferenceError(f"terms: must be a list of terms and Fractions, not {describe(given)}")
    terms = tuple(given)
    for k, term in enumerate(terms):
        if isinstance(term, Fraction):
            continue
        if not isinstance(term, Term):
            known = "a Fraction or a term of prefplan.preferences.terms, such as WeightedRate((1, 2))"
            raise PreferenceError(f"terms[{k}]: must be {known}, not {describe(term)}")
        weights, tasks = weights_of(term), _tasks_of(term)
        if isinstance(term, WeightedRate | Violation | Maximum) and len(weights) != amounts:
            raise PreferenceError(
                f"terms[{k}].weights: must be {amounts}, one for each task and rule, not {len(weights)}"
            )
        if not all(isinstance(weight, Rational) and weight >= 0 for weight in weights):
            raise PreferenceError(f"terms[{k}]: weights must be whole numbers or Fractions, at least 0, not {weights}")
        if len({*tasks} & {*range(amounts)}) < len(tasks):
            raise PreferenceError(f"terms[{k}]: tasks must be numbers below {amounts}, each once, not {tasks}")
    return terms


def _tasks_of(term: Term) -> tuple[int, ...]:
    """Return the tasks that a term names by their numbers."""
    if isinstance(term, OrderRate):
        return tuple(chain(*term.groups))
    if isinstance(term, SpreadRate):
        return tuple(term.members)
    return (term.task,) if isinstance(term, Tardiness) else ()
