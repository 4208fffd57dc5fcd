"""Limits of a search, and bounds of objectives, as a user gives them."""

from collections.abc import Collection, Mapping
from decimal import Decimal
from fractions import Fraction
from numbers import Real
from typing import Any, TypedDict, Unpack

from prefplan.errors import PreferenceError, PrefplanError, check_known, choices, describe
from prefplan.exact_costs import Number, inclusive
from prefplan.limits import Limits
from prefplan.problem import Problem


class FrontLimits(TypedDict, total=False):
    """Limits of the search for a front; each may be left out or None.

    Attributes:
        max_cost: inclusive bound of the first total cost; needed for a preference whose contract is `general`.
        at_most: inclusive bounds of costs and preferences, by name.
        max_seconds: limit of the time, s.
        max_memory: limit of the memory, bytes; None for 80 % of what is free.
    """

    max_cost: Number | None
    at_most: Mapping[str, Number] | None
    max_seconds: float | None
    max_memory: float | None


class PlanLimits(FrontLimits, total=False):
    """Limits of the search for one plan.

    Attributes:
        max_preference: inclusive bound of the first preference.
    """

    max_preference: Number | None


def limits_of(problem: Problem, **wanted: Unpack[PlanLimits]) -> tuple[Limits, dict[str, Fraction]]:
    """Return the limits of time and memory, and the largest values that are within the bounds, by objective.

    Raises:
        PrefplanError: a limit is unknown or not a number, or the name of a bound is not that of an objective.
    """
    for key in wanted:
        if key not in PlanLimits.__annotations__:
            raise PrefplanError(f"{key}: no limit of a search {choices(key, PlanLimits.__annotations__)}")
    max_preference, at_most = wanted.get("max_preference"), wanted.get("at_most") or {}
    if not isinstance(at_most, Mapping):
        raise PrefplanError(f"at_most: must be bounds by name, such as {{'cost': 40}}, not {describe(at_most)}")
    names = problem.objective_names
    keys = dict(zip(names, ("max_cost", "max_preference"), strict=True)) if problem.is_bi_objective else {}
    given = [(names[0], wanted.get("max_cost")), *at_most.items()]
    if max_preference is not None:
        if not problem.preferences:
            raise PrefplanError(f"max_preference: there is no preference {choices('', names)}")
        given.append((problem.preferences[0].name, max_preference))
    bounds: dict[str, Fraction] = {}
    for name, bound in given:
        check_known("at_most", "objective", name, names, PrefplanError)
        if bound is not None:
            largest = inclusive(bound, keys.get(name, name))
            bounds[name] = min(largest, bounds.get(name, largest))
    return Limits.of(_limit(wanted, "max_seconds"), _limit(wanted, "max_memory")), bounds


def _limit(wanted: Mapping[str, Any], key: str) -> float | None:
    """Return a limit of time or memory."""
    value = wanted.get(key)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, (Real, Decimal)) or not float(value) >= 0:
        raise PrefplanError(f"{key}: must be a number >= 0, not {describe(value)}")
    return float(value)


def require_bounds(problem: Problem, bounds: Collection[str]) -> None:
    """Raise PreferenceError if a preference's contract is `general` and the cost that it depends on has no bound."""
    for o in problem.objectives:
        of = problem.cost_names[o.cost]
        if o.contract != "general" or of in bounds:
            continue
        if problem.is_bi_objective:
            raise PreferenceError(
                "preference: its contract is 'general', so that its front may be infinite; "
                "a bound on the total cost is needed (--max-cost C, in Python max_cost=C)"
            )
        raise PreferenceError(
            f"{o.name}: its contract is 'general', so that the front may be infinite; "
            f"a bound on the cost that it counts in is needed (--at-most {of}=VALUE, in Python at_most)"
        )
