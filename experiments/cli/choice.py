"""Plans of a front as options name them: `cost`, `preference` or an index."""

from __future__ import annotations

import argparse

from experiments.cli import output
from experiments.cli.status import no_plan
from prefplan.errors import PrefplanError
from prefplan.exact_costs import Number
from prefplan.front import Front, NoPlanError, Plan
from prefplan.planner import Planner
from prefplan.scenario.decode import Scenario


def choose(planner: Planner, wanted: str | int, *, max_cost: Number | None = None) -> Plan:
    """Return the plan that `--plan` names, among those of at most this cost.

    Raises:
        NoPlanError: there is none at all.
        PreferenceError: a bound on the cost is needed.
        PrefplanError: the front has no plan of that index.
    """
    if wanted == "cost":
        return planner.cheapest(max_cost=max_cost)
    if wanted == "preference":
        return planner.preferred(max_cost=max_cost)
    front = planner.front(max_cost=max_cost)
    if front.reason:
        raise NoPlanError(front.reason)
    return plan_at(front, int(wanted), "--plan")


def plan_at(front: Front, index: int, option: str) -> Plan:
    """Return a plan of a front.

    Raises:
        PrefplanError: it has no plan of that index; the message names the option.
    """
    if index >= len(front):
        valid = "one plan, 0" if len(front) == 1 else f"plans 0 to {len(front) - 1}" if front else "no plans"
        raise PrefplanError(f"{option} {index}: the front has {valid}")
    return front[index]


def show_no_plan(options: argparse.Namespace, scenario: Scenario, planner: Planner, error: NoPlanError) -> int:
    """Say why there is no plan, with --json as an object too, and return the exit status."""
    if options.json:
        output.print_json(output.front_json(scenario, Front((), reason=error.reason, stats=planner.stats)))
    return no_plan(error.reason)
