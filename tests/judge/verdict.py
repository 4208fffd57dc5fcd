"""The planner's answers to one problem held against the judges': fronts, bounds, and every plan replayed."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Any

from judge.enumerate import cheapest_cost, exact_front
from judge.preferences import Number, exact
from judge.problems import GraphProblem
from judge.replay import replay
from prefplan import NoPlanError, Options, Plan, Planner
from prefplan.scenario import from_dict

#: Every way to search that a front must not depend on.
WAYS = (
    Options(),
    Options(heuristic=0, preference_bound=False, contraction=False),
    Options(heuristic=1, contraction=False),
    Options(heuristic=2, preference_bound=False),
    Options(heuristic=3, contraction=False),
)


def verdict(problem: GraphProblem, ways: Sequence[Options] = WAYS) -> str | None:
    """Return what is wrong with the planner's answers, or None."""
    planned = from_dict(problem.scenario(), name="problem").problem()
    least = cheapest_cost(problem)
    if least is None:
        front = Planner(planned).front(max_cost=100)
        return None if not front and front.reason else f"found {list(front)} where no plan exists"
    limit = 2 * least + 12
    expected = exact_front(problem, max_cost=limit)
    for options in ways:
        planner = Planner(planned, options=options)
        front = planner.front(max_cost=_number(limit))
        points = [(plan.cost, plan.preference) for plan in front]
        if not _same(points, expected):
            return f"{options}: front {points}, expected {expected}"
        for plan in front:
            if wrong := misjudged(problem, plan):
                return f"{options}: {wrong}"
        if wrong := _misbounded(planner, expected, limit):
            return f"{options}: {wrong}"
    return None


def misjudged(problem: GraphProblem, plan: Plan) -> str | None:
    """Return how a plan differs from what replaying it gives, or None."""
    relaxations = [
        {"task": bought.task, "step": bought.step, "cost": bought.cost}
        | ({"skip": True} if bought.assume is None else {"assume": bought.assume})
        for bought in plan.relaxations
    ]
    told = replay(problem, plan.actions, relaxations)
    same = _close(told.cost, plan.cost) and _close(told.mu, plan.preference) and told.ends
    names = problem.names
    same &= all(_close(told.task_costs[k], plan.task_costs[name]) for k, name in enumerate(names))
    same &= all(_close(told.violations[k], plan.violation_costs[name]) for k, name in enumerate(names))
    return None if same else f"{plan} is judged {told}"


def _misbounded(planner: Planner, expected: list[tuple[Number, Number]], limit: Number) -> str | None:
    """Return a bound on mu under which the planner's cheapest plan is not the expected one, or None."""
    rng = random.Random(str(expected))
    bounds = {mu for _, mu in expected} | {mu + rng.choice((-1, 1)) for _, mu in expected}
    for bound in sorted(bounds):
        if bound < 0:
            continue
        wanted = next(((cost, mu) for cost, mu in expected if mu <= bound), None)
        try:
            plan = planner.cheapest(max_preference=_number(bound), max_cost=_number(limit))
            found = (plan.cost, plan.preference)
        except NoPlanError as error:
            found = None
            smallest = error.reason.smallest
            if error.reason.kind == "bound" and not _close(expected[-1][1], smallest):
                return f"smallest mu {smallest}, expected {expected[-1][1]}"
        if (found is None) != (wanted is None) or (found and wanted and not _same([found], [wanted])):
            return f"cheapest with mu <= {bound}: {found}, expected {wanted}"
    return None


def _number(value: Number) -> Any:
    return value if isinstance(value, int) else float(value)


def _same(points: Sequence[tuple[Any, Any]], expected: Sequence[tuple[Number, Number]]) -> bool:
    return len(points) == len(expected) and all(
        _close(a, c) and _close(b, d) for (a, b), (c, d) in zip(points, expected, strict=True)
    )


def _close(a: Any, b: Any) -> bool:
    if isinstance(a, float) or isinstance(b, float):
        return math.isclose(float(a), float(b), rel_tol=1e-9, abs_tol=1e-9)
    return exact(a) == exact(b)
