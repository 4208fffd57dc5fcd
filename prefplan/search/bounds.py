"""Limits of a search, and bounds of what plans are worth, as a user gives them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypedDict, Unpack

from prefplan.errors import PreferenceError, PrefplanError, check_known, choices
from prefplan.exact_costs import Number, inclusive
from prefplan.problem import Problem


class FrontLimits(TypedDict, total=False):
    """Where the search for a front ends; None or nothing for no bound.

    Attributes:
        max_cost: inclusive bound of the first total cost; needed for a preference whose contract is `general`.
        at_most: inclusive bounds of costs and preferences, by name.
        max_seconds: time.
        max_memory: bytes of memory; None for most of what is free.
    """

    max_cost: Number | None
    at_most: Mapping[str, Number] | None
    max_seconds: float | None
    max_memory: float | None


class PlanLimits(FrontLimits, total=False):
    """Where the search for one plan ends.

    Attributes:
        max_preference: inclusive bound of mu, of the first preference.
    """

    max_preference: Number | None


def bounded(
    problem: Problem,
    *,
    max_cost: Number | None = None,
    max_preference: Number | None = None,
    at_most: Mapping[str, Number] | None = None,
    max_seconds: float | None = None,
    max_memory: float | None = None,
) -> PlanLimits:
    """Return limits with every bound by name, or where there is one cost and one preference with none by name.

    Raises:
        PrefplanError: a bound is of no objective.
    """
    names = problem.objective_names
    bounds: dict[str, Number] = {}
    preference = next(iter(problem.preferences), None)
    given = [(names[0], max_cost), *(at_most or {}).items()]
    if max_preference is not None:
        if preference is None:
            raise PrefplanError(f"max_preference: there is no preference {choices('', names)}")
        given.append((preference.name, max_preference))
    for name, bound in given:
        check_known("at_most", "objective", name, names, PrefplanError)
        if bound is not None and (name not in bounds or inclusive(bound, name) < inclusive(bounds[name])):
            bounds[name] = bound
    limits: PlanLimits = {"max_seconds": max_seconds, "max_memory": max_memory}
    if not problem.is_bi_objective:
        return {**limits, "at_most": bounds}
    return {**limits, "max_cost": bounds.get(names[0]), "max_preference": bounds.get(names[1])}


def require_bounds(problem: Problem, **wanted: Unpack[PlanLimits]) -> None:
    """Raise PreferenceError where a preference's contract is general and the cost that it counts in has no bound."""
    if not problem.is_bi_objective:
        for o in problem.objectives:
            of = problem.cost_names[o.cost]
            if o.measure.contract == "general" and of not in (wanted.get("at_most") or {}):
                raise PreferenceError(
                    f"{o.name}: its contract is 'general', so that the front may be infinite; "
                    f"a bound on the cost that it counts in is needed (--at-most {of}=VALUE)"
                )
        return
    if problem.measure.contract == "general" and wanted.get("max_cost") is None:
        raise PreferenceError(
            "preference: its contract is 'general', so that its front may be infinite; "
            "a bound on the total cost is needed (--max-cost)"
        )
