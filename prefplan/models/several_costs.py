"""Costs of an action: a number, or a table of named costs, with the same names for all actions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from prefplan.errors import ModelError
from prefplan.exact_costs import Number, exact
from prefplan.models.transition_system import DEFAULT_COST, EdgeCosts, TransitionSystem
from prefplan.text.names import check_names

Cost = Number | Mapping[str, Number]
"""The cost of an action: a number, whose name is then `cost`, or several costs by name."""


def amount(cost: Cost, name: str) -> Number:
    """Return one of the costs of an action."""
    return cost[name] if isinstance(cost, Mapping) else cost


def names_of(cost: Cost) -> tuple[str, ...]:
    """Return the names of an action's costs, which are those of every action."""
    return tuple(cost) if isinstance(cost, Mapping) else (DEFAULT_COST,)


def check_costs_agree(costs: Iterable[tuple[str, Cost]]) -> None:
    """Check all costs of a model, each given with its key.

    Raises:
        ModelError: a cost is negative, has no names, or other names than the first; the message begins with the key.
    """
    names: tuple[str, ...] | None = None
    first = first_told = ""
    for where, cost in costs:
        here = names_of(cost)
        if names is None:
            if not here:
                raise ModelError(f"{where}: names no cost")
            check_names(here, where=where)
            names, first, first_told = here, where, _told(cost)
        if set(here) != set(names):
            raise ModelError(
                f"{where}: gives {_told(cost)}, but {first} gives {first_told}; every cost has the same names"
            )
        for name in here:
            at = f"{where}.{name}" if isinstance(cost, Mapping) else where
            if exact(amount(cost, name), at) < 0:
                raise ModelError(f"{at}: negative cost {amount(cost, name)}")


def _told(cost: Cost) -> str:
    if isinstance(cost, Mapping):
        return f"the costs {', '.join(cost)}" if cost else "no cost"
    return "a number (the cost 'cost')"


def with_costs(names: tuple[str, ...], build: Callable[[str], TransitionSystem]) -> TransitionSystem:
    """Return a transition system with several costs.

    `build` returns the system with one of them, given by name; states and actions must not depend on the cost.
    """
    systems = [build(name) for name in names]
    more = tuple(EdgeCosts(name, one.costs, one.unit) for name, one in zip(names[1:], systems[1:], strict=True))
    return replace(systems[0], cost_name=names[0], more_costs=more) if names != (DEFAULT_COST,) else systems[0]
