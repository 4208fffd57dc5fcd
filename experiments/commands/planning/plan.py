"""`prefplan plan`: one plan of a scenario."""

from __future__ import annotations

from decimal import Decimal
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

import prefplan as pp
from experiments.checks.no_plan import chosen_plan
from experiments.cli import options, output
from experiments.cli.choice import Wanted
from experiments.cli.command import command
from experiments.cli.console import Console
from experiments.cli.start import load_planner
from experiments.cli.status import DONE, FAILED, INTERRUPTED, tell
from experiments.runs.geometry import asking

if TYPE_CHECKING:
    from prefplan.limits import Limits


@command
@options.scenario
@options.as_json
@options.which
@click.option(
    "--objective",
    metavar="NAME",
    shell_complete=options.objective_names,
    help="The plan with the least value of this cost or preference, by its name, instead of --plan; cost and "
    "preference are the first of each.",
)
@options.at_most
@options.abstract
@options.limits("the best plan so far")
def plan(
    scenario: str,
    as_json: bool,
    wanted: Wanted,
    objective: str | None,
    at_most: dict[str, Decimal],
    abstract: bool,
    limits: Limits,
) -> int:
    """Print one plan: the cheapest, the preferred, or the cheapest within a bound on the penalty.

    Examples:
      prefplan plan example --plan preference
      prefplan plan case_study_1 --max-preference 24
      prefplan plan case_study_1 --max-seconds 10 --json
      prefplan plan rover --objective energy --at-most time=80

    A limit, or Ctrl-C, may end the search before its plan is found. Then the best plan so far is printed and, for the
    cheapest plan of nine or more tasks, by how much it may be dearer. If no plan is known, the exit status is 4,
    although a plan may exist (if none does, it is 3). With --json, "complete" is false in both cases.
    """
    load_planner()
    if objective is not None:
        if click.get_current_context().get_parameter_source("plan") is not ParameterSource.DEFAULT:
            raise pp.PrefplanError("--objective: chooses the plan instead of --plan; give one of them")
        wanted = wanted._replace(plan=objective)
    with limits:
        found = asking(pp.load(scenario), abstract=abstract)
        planner = pp.Planner(found.problem())
        try:
            chosen = chosen_plan(found, planner, wanted, as_json=as_json, at_most=at_most, keep_on_interrupt=True)
        except pp.UnfinishedError as error:
            return _unfinished(found, planner, error, as_json=as_json)
    if as_json:
        output.print_json(output.result_json(found, planner, complete=True, plan=output.plan_json(chosen)))
    else:
        output.show_plan(Console(), found, chosen, planner.geometry)
    return DONE


def _unfinished(scenario: pp.Scenario, planner: pp.Planner, error: pp.UnfinishedError, *, as_json: bool) -> int:
    """Print the result of a search that a limit or Ctrl-C ended, and return the exit status."""
    if as_json:
        found = {
            "complete": False,
            "plan": error.best and output.plan_json(error.best),
            "ended": error.ended,
            "complete_below": error.complete_below,
            "within": error.within,
        }
        output.print_json(output.result_json(scenario, planner, **found))
    elif error.best:
        output.show_plan(Console(), scenario, error.best, planner.geometry)
    tell(error)
    if error.ended == "interrupt":
        return INTERRUPTED
    return DONE if error.best else FAILED
