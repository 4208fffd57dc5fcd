"""Preference functions mu over the tasks' costs (Definition 5); lower is better.

A preference is written in terms of task names and the user's units. `bind` ties it to a problem: a `Measure` takes the
costs as integers in the problem's quanta, in the order of the tasks, and returns an exact integer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from prefplan.errors import PreferenceError, choices
from prefplan.quanta import Number, decimals_of, exact, to_quanta


@dataclass(frozen=True)
class Measure:
    """A preference bound to a problem's tasks.

    Attributes:
        function: costs (c_1, ..., c_N) in quanta of 10**-(the problem's decimals) -> mu in quanta of 10**-decimals.
        decimals: exponent of mu's quantum.
    """

    function: Callable[[Sequence[int]], int]
    decimals: int

    def __call__(self, costs: Sequence[int]) -> int:
        """Return mu of a preference cost set."""
        return self.function(costs)


class Preference(Protocol):
    """What the search needs to know of a preference."""

    @property
    def contract(self) -> str:
        """What may be assumed of mu, and so how labels may be pruned: `additive` or `convex`."""

    @property
    def cost_decimals(self) -> int:
        """Decimal places that costs need so that mu's own constants (deadlines) are exact."""

    def check(self, tasks: Sequence[str]) -> None:
        """Raise PreferenceError, with the key in front, if the preference does not fit these tasks."""

    def bind(self, tasks: Sequence[str], decimals: int) -> Measure:
        """Return mu over the costs of these tasks, in quanta of 10**-decimals."""


@dataclass(frozen=True)
class Order:
    """Delay against a desired order of satisfaction (the paper's Example 3).

    mu = sum_k max(0, c_{o_k} - c*_k), with o the desired order and c* the sorted costs; members of a group are
    interchangeable, i.e. mu is the smallest over all orders of a group's members. As max(0, c - c*) is a convex
    function of a difference, sorting each group's members by cost attains it.

    Attributes:
        order: names of all tasks, each once, or groups of names; None for the tasks' own order.
    """

    order: tuple[str | tuple[str, ...], ...] | None = None
    contract: str = field(default="additive", init=False)
    cost_decimals: int = field(default=0, init=False)

    def _groups(self, tasks: Sequence[str]) -> Iterator[tuple[str, ...]]:
        for entry in tasks if self.order is None else self.order:
            yield (entry,) if isinstance(entry, str) else tuple(entry)

    def check(self, tasks: Sequence[str]) -> None:
        """Raise PreferenceError unless every task is named exactly once."""
        named: list[str] = []
        for group in self._groups(tasks):
            for name in group:
                _check_task("order", name, tasks)
                if name in named:
                    raise PreferenceError(f"order: {name!r} is named twice")
                named.append(name)
        if missing := [task for task in tasks if task not in named]:
            raise PreferenceError(f"order: every task needs a place; missing {', '.join(missing)}")

    def bind(self, tasks: Sequence[str], decimals: int) -> Measure:
        """Return mu over the costs of these tasks."""
        groups = [[tasks.index(name) for name in group] for group in self._groups(tasks)]

        def delay(costs: Sequence[int]) -> int:
            desired = (c for group in groups for c in sorted(costs[i] for i in group))
            return sum(max(0, c - ideal) for c, ideal in zip(desired, sorted(costs), strict=True))

        return Measure(delay, decimals)


@dataclass(frozen=True)
class WeightedSum:
    """mu = sum_i w_i c_i.

    Attributes:
        weights: a weight >= 0 for every task.
    """

    weights: Mapping[str, Number]
    contract: str = field(default="additive", init=False)
    cost_decimals: int = field(default=0, init=False)

    def check(self, tasks: Sequence[str]) -> None:
        """Raise PreferenceError unless every task has a weight that is not negative."""
        for name, weight in self.weights.items():
            _check_task("weights", name, tasks)
            _check_weight(f"weights.{name}", weight)
        if missing := [task for task in tasks if task not in self.weights]:
            raise PreferenceError(f"weights: every task needs one; missing {', '.join(missing)}")

    def bind(self, tasks: Sequence[str], decimals: int) -> Measure:
        """Return mu over the costs of these tasks."""
        weights, places = to_quanta([self.weights[task] for task in tasks])
        return Measure(lambda costs: sum(w * c for w, c in zip(weights, costs, strict=True)), decimals + places)


@dataclass(frozen=True)
class Due:
    """A deadline: cost `by` which a task should be satisfied, and the weight of each unit of tardiness."""

    by: Number
    weight: Number = 1


@dataclass(frozen=True)
class Deadline:
    """Weighted tardiness: mu = sum_i weight_i max(0, c_i - by_i).

    Attributes:
        deadlines: by task; tasks not named have none.
    """

    deadlines: Mapping[str, Due]
    contract: str = field(default="convex", init=False)

    @property
    def cost_decimals(self) -> int:
        """Decimal places of the deadlines."""
        return decimals_of(due.by for due in self.deadlines.values())

    def check(self, tasks: Sequence[str]) -> None:
        """Raise PreferenceError for an unknown task, or a negative deadline or weight."""
        for name, due in self.deadlines.items():
            _check_task("deadlines", name, tasks)
            _check_weight(f"deadlines.{name}.weight", due.weight)
            _check_weight(f"deadlines.{name}.by", due.by)

    def bind(self, tasks: Sequence[str], decimals: int) -> Measure:
        """Return mu over the costs of these tasks."""
        due = list(self.deadlines.items())
        weights, places = to_quanta([d.weight for _, d in due])
        limits, _ = to_quanta([d.by for _, d in due], decimals)
        terms = [(tasks.index(name), limit, w) for (name, _), limit, w in zip(due, limits, weights, strict=True)]
        return Measure(lambda costs: sum(w * max(0, costs[i] - limit) for i, limit, w in terms), decimals + places)


def _check_task(where: str, name: str, tasks: Sequence[str]) -> None:
    if name not in tasks:
        raise PreferenceError(f"{where}: unknown task {name!r} {choices(name, tasks)}")


def _check_weight(where: str, weight: Number) -> None:
    if exact(weight) < 0:
        raise PreferenceError(f"{where}: must not be negative, but is {weight}")
