"""The plan that options choose: `--plan cost|preference|INDEX` within `--max-preference` and `--max-cost`."""

from __future__ import annotations

import argparse
import sys
from typing import Unpack, cast

from experiments.cli import output
from experiments.cli.status import no_plan
from prefplan.errors import PrefplanError, check_known, choices
from prefplan.exact_costs import Number, admits
from prefplan.front import Front, NoPlanError, UnfinishedError
from prefplan.models.costs import DEFAULT_COST
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.plan import Plan
from prefplan.planner import Planner
from prefplan.preferences.objective import DEFAULT_PREFERENCE
from prefplan.problem import Problem
from prefplan.scenario.decode import Scenario
from prefplan.scenario.files import FOLDER
from prefplan.search.bounds import FrontLimits, PlanLimits
from prefplan.text.layout import number


def chosen_plan(planner: Planner, options: argparse.Namespace, *, keep_on_interrupt: bool = False) -> Plan:
    """Return the plan that the options `PLAN` name, and `LIMITS` if there are any; see `choose`."""
    check_bounds(planner.problem, options)
    limits = {name: getattr(options, name, None) for name in PlanLimits.__annotations__}
    return choose(planner, options.plan, keep_on_interrupt=keep_on_interrupt, **cast(PlanLimits, limits))


def continuation(wanted: str | int, max_preference: Number | None) -> str | int:
    """Return which plan a run follows after a mismatch, see `experiments.runs.carry_out.Conditions.choice`."""
    return "bounded" if wanted == "cost" and max_preference is not None else wanted


def plan_name(wanted: str | int) -> str:
    """Return the name of a run's files for a value of `--plan`."""
    return wanted if isinstance(wanted, str) else f"plan_{wanted}"


def choose(
    planner: Planner, wanted: str | int, *, keep_on_interrupt: bool = False, **limits: Unpack[PlanLimits]
) -> Plan:
    """Return the plan that `--plan` names, within limits.

    Args:
        planner: of the problem.
        wanted: `cost`, `preference`, the name of a cost or a preference, or an index of the front.
        keep_on_interrupt: whether Ctrl-C counts as a limit.
        **limits: those of `cheapest_plan`.

    Raises:
        NoPlanError: there is none at all.
        UnfinishedError: a limit ended the search first; its `best` is the best plan known by then, or for an index the
            known plan that is nearest to it.
        PreferenceError: a bound on the cost is needed.
        PrefplanError: the front has no plan of that index, or its penalty exceeds `max_preference`.
    """
    if isinstance(wanted, str):
        name = objective_name(planner.problem, wanted)
        return planner.best(name, keep_on_interrupt=keep_on_interrupt, **limits)
    bound = limits.get("max_preference")
    others = {name: limits.get(name) for name in FrontLimits.__annotations__}
    front = planner.front(keep_on_interrupt=keep_on_interrupt, **cast(FrontLimits, others))
    if front.reason:
        raise NoPlanError(front.reason)
    if front.ended and not _is_settled(front, int(wanted)):
        nearest = front[min(int(wanted), len(front) - 1)] if front else None
        raise UnfinishedError(front.ended, complete_below=front.complete_below, best=nearest)
    plan = plan_at(front, int(wanted), "--plan")
    if bound is not None and not admits(bound, plan.preference):
        found = f"its penalty is {number(plan.preference)}"
        raise PrefplanError(f"--plan {wanted}: {found}, more than --max-preference {bound}")
    return plan


def _is_settled(front: Front, index: int) -> bool:
    """Return whether a front whose search was stopped has all plans up to an index."""
    below = front.complete_below
    return below is not None and index < len(front) and front[index].cost < below


def objective_name(problem: Problem, name: str) -> str:
    """Return the name of an objective; `cost` and `preference` are the first of each.

    Raises:
        PrefplanError: there is no such objective.
    """
    names = problem.objective_names
    if name in names:
        return name
    if name == DEFAULT_COST:
        return names[0]
    if name == DEFAULT_PREFERENCE and problem.preferences:
        return problem.preferences[0].name
    raise PrefplanError(f"--objective: unknown objective {name!r} {choices(name, names)}")


def check_bounds(problem: Problem, options: argparse.Namespace) -> None:
    """Raise PrefplanError if `--at-most` or `--max-preference` bounds an objective that a problem does not have."""
    for name in getattr(options, "at_most", None) or ():
        check_known("--at-most", "objective", name, problem.objective_names, PrefplanError)
    if options.max_preference is not None and not problem.preferences:
        raise PrefplanError(f"--max-preference: there is no preference {choices('', problem.objective_names)}")


def plan_at(front: Front, index: int, option: str) -> Plan:
    """Return a plan of a front.

    Raises:
        PrefplanError: the front has no plan of that index; the message names the option.
    """
    if index >= len(front):
        valid = "one plan, 0" if len(front) == 1 else f"plans 0 to {len(front) - 1}" if front else "no plans"
        raise PrefplanError(f"{option} {index}: the front has {valid}")
    return front[index]


def show_no_plan(options: argparse.Namespace, scenario: Scenario, planner: Planner, error: NoPlanError) -> int:
    """Print why there is no plan on stderr, with --json also as an object on stdout; return the exit status."""
    if options.json:
        output.print_json(output.no_plan_json(scenario, error.reason, planner.stats))
    return no_plan(error.reason, planner.problem)


def tell_if_unchecked(scenario: Scenario, *, quiet: bool = False) -> None:
    """Print on stderr that the arm was not asked whether it can do what is planned, unless `quiet`.

    Not for the scenarios that ship, which tests carry out.
    """
    own = isinstance(scenario.model, ManipulationModel) and scenario.path.resolve().parent != FOLDER.resolve()
    if own and not quiet:
        print(f"prefplan: not checked against the arm: `prefplan check {scenario.path}`", file=sys.stderr)
