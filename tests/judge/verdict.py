"""The planner's answers to one problem compared with the judges': fronts, bounds, and every plan replayed."""

from __future__ import annotations

import json
import random
from collections.abc import Sequence
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from itertools import combinations
from typing import Any

from judge.enumerate import cheapest_cost, exact_front
from judge.numbers import to_resolution
from judge.planners import PLANNERS, PlannerOf
from judge.preferences import Number, exact
from judge.problems import GraphProblem
from judge.replay import replay
from prefplan import Front, NoPlanError, Plan, Planner
from prefplan.scenario.decode import from_dict

MAX_LABELS = 100_000
"""Most labels of a problem that the judge makes."""


def verdict(problem: GraphProblem, planners: Sequence[PlannerOf] = PLANNERS) -> str | None:
    """Return what is wrong with the planner's answers, or None.

    Raises:
        TooManyError: the problem is too large for the judge.
    """
    planned = from_dict(problem.scenario(), name="problem").problem()
    if planned.resolution is not None:
        problem = to_resolution(problem, float(planned.resolution))
    least = cheapest_cost(problem)
    if least is None:
        return misblamed(problem, Planner(planned).front(max_cost=100))
    limit = exact_limit(problem)
    assert limit is not None
    expected = exact_front(problem, max_cost=limit, max_labels=MAX_LABELS)
    for chosen in planners:
        planner = chosen(planned)
        front = planner.front(max_cost=limit)
        points = [(plan.cost, plan.preference) for plan in front]
        if points != [(printed(cost), printed(mu)) for cost, mu in expected]:
            return f"{chosen}: front {points}, expected {expected}"
        if not front.complete:
            return f"{chosen}: the front is not complete"
        for plan in front:
            if wrong := misjudged(problem, plan):
                return f"{chosen}: {wrong}"
        if wrong := _misbounded(planner, expected, limit) or _unbound(planner, list(front), limit):
            return f"{chosen}: {wrong}"
    return None


def exact_limit(problem: GraphProblem) -> Number | None:
    """Return the cost up to which a problem is judged; None if there is no plan."""
    least = cheapest_cost(problem)
    smallest = min((edge.cost for edge in problem.edges if edge.cost), default=0)
    return None if least is None else least + max(least * Fraction(1, 2), 12 * smallest)


def misblamed(problem: GraphProblem, front: Front) -> str | None:
    """Return what is wrong with the reason of an empty front, or None; no plan satisfies all tasks together."""
    if front or front.reason is None:
        return f"found {list(front)} where no plan exists"
    kind, blamed = front.reason.kind, front.reason.tasks
    fewer = [names for size in range(1, len(blamed)) for names in combinations(problem.names, size)]
    smallest = not feasible(problem, blamed) and all(feasible(problem, names) for names in fewer)
    right = smallest and kind == ("task" if len(blamed) == 1 else "conflict")
    return None if right else f"{kind} {blamed} is blamed"


def feasible(problem: GraphProblem, names: Sequence[str]) -> bool:
    """Say whether a plan satisfies these tasks together."""
    tasks = tuple(task for task in problem.tasks if task.name in names)
    return cheapest_cost(replace(problem, tasks=tasks)) is not None


def relaxations(plan: Plan) -> list[dict[str, Any]]:
    """Return what a plan relaxes and skips as `replay` takes it."""
    return [
        {"task": bought.task, "step": bought.step, "cost": bought.cost}
        | ({"skip": True} if bought.assume is None else {"assume": bought.assume})
        for bought in plan.relaxations
    ]


def misjudged(problem: GraphProblem, plan: Plan) -> str | None:
    """Return how a plan differs from what replaying it gives, or None."""
    prices = {printed(entry.cost): entry.cost for task in problem.tasks for entry in task.relax}
    prices |= {printed(task.skip): task.skip for task in problem.tasks if task.skip is not None}
    exactly = [entry | {"cost": prices[entry["cost"]]} for entry in relaxations(plan)]
    told = replay(problem, plan.actions, exactly)
    same = printed(told.cost) == plan.cost and printed(told.mu) == plan.preference and told.ends
    same &= told.states == tuple(plan.states)
    names = problem.names
    same &= all(printed(told.task_costs[k]) == plan.task_costs[name] for k, name in enumerate(names))
    same &= all(printed(told.violations[k]) == plan.violation_costs[name] for k, name in enumerate(names))
    return None if same else f"{plan} is judged {told}"


READ_BACK = (lambda number: number, lambda number: Decimal(str(number)), lambda number: json.loads(json.dumps(number)))
"""How a printed value is given as a bound: from Python, from the command line, and from JSON."""


def _unbound(planner: Planner, plans: Sequence[Plan], limit: Number) -> str | None:
    """Return how a bound equal to a printed value of a plan fails to admit that plan, or None; one plan is tried."""
    if not plans:
        return None
    rng = random.Random(str(plans))
    plan, read = rng.choice(plans), rng.choice(READ_BACK)
    cost, mu = read(plan.cost), read(plan.preference)
    last = planner.preferred(max_cost=cost)
    if (last.cost, last.preference) != (plan.cost, plan.preference):
        return f"cost bounded by {cost!r}: preferred {(last.cost, last.preference)}, expected {plan}"
    found = planner.cheapest(max_preference=mu, max_cost=limit)
    if (found.cost, found.preference) != (plan.cost, plan.preference):
        return f"mu bounded by {mu!r}: {(found.cost, found.preference)}, expected {plan}"
    return None


def _misbounded(planner: Planner, expected: list[tuple[Number, Number]], limit: Number) -> str | None:
    """Return a bound on mu under which the planner's cheapest plan is not the expected one, or None."""
    rng = random.Random(str(expected))
    for bound in sorted({mu + rng.choice((-1, 1)) for _, mu in expected}):
        if bound < 0:
            continue
        wanted = next(((printed(cost), printed(mu)) for cost, mu in expected if mu <= bound), None)
        try:
            plan = planner.cheapest(max_preference=bound, max_cost=limit)
            found = (plan.cost, plan.preference)
        except NoPlanError as error:
            found = None
            smallest = error.reason.smallest
            if error.reason.kind == "bound" and printed(expected[-1][1]) != smallest:
                return f"smallest mu {smallest}, expected {expected[-1][1]}"
        if found != wanted:
            return f"cheapest with mu <= {bound}: {found}, expected {wanted}"
    return None


def printed(value: Number) -> int | float:
    """Return a number as the planner gives it: an integer where it is whole, else the nearest float."""
    number = exact(value)
    return number if isinstance(number, int) else float(number)
