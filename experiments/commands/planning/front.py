"""`prefplan front`: the Pareto front of a scenario."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import asdict
from decimal import Decimal
from typing import TYPE_CHECKING

import click

import prefplan as pp
from experiments.checks.no_plan import no_plan
from experiments.cli import options, output
from experiments.cli.choice import bounds_of, objective_name
from experiments.cli.command import command
from experiments.cli.console import Console
from experiments.cli.start import load_planner
from experiments.cli.status import DONE, INTERRUPTED, say, tell
from experiments.runs.geometry import asking

if TYPE_CHECKING:
    from prefplan.limits import Limits


@command
@options.scenario
@options.as_json
@options.plot
@options.max_cost
@options.max_preference
@options.at_most
@click.option(
    "--objective",
    "objectives",
    multiple=True,
    metavar="NAME",
    shell_complete=options.objective_names,
    help="A cost or a preference by its name; given once or more, the front is that of these alone (default: all).",
)
@options.abstract
@options.limits("the front so far")
def front(
    scenario: str,
    as_json: bool,
    plot: str | None,
    max_cost: Decimal | None,
    max_preference: Decimal | None,
    at_most: dict[str, Decimal],
    objectives: Sequence[str],
    abstract: bool,
    limits: Limits,
) -> int:
    """Print the Pareto front of total cost and penalty, or of several costs and preferences.

    Examples:
      prefplan front example
      prefplan front example --max-cost 8 --json
      prefplan front case_study_1 --max-seconds 10
      prefplan front case_study_1 --plot front.pdf
      prefplan front rover --objective time --objective energy
    """
    picture = None
    if plot is not None:
        from experiments.figures.figures import picture_file
        from experiments.figures.front import draw

        picture = picture_file(plot)
    load_planner()
    with limits:
        found = asking(pp.load(scenario), abstract=abstract)
        problem = found.problem()
        _ = problem.system.small  # a limit that is reached before a search begins is an error
        bounds = bounds_of(problem, at_most, max_preference)
        wanted = [objective_name(problem, name, "--objective") for name in objectives]
        planner = pp.Planner(problem)
        result = planner.front(over=wanted, max_cost=max_cost, at_most=bounds, keep_on_interrupt=True)

    def whole(index: int) -> str:
        # With bounds and objectives, plans have other numbers than on the whole front.
        if objectives or bounds:
            return "with --json, all are printed"
        return f"`prefplan plan {shlex.quote(scenario)} --plan {index}` prints all"

    if as_json:
        entries = {"complete": result.complete, "front": [output.plan_json(plan) for plan in result]}
        why = {"reason": asdict(result.reason)} if result.reason else {}
        until = {"ended": result.ended, "complete_below": result.complete_below} if result.ended else {}
        output.print_json(output.result_json(found, planner, **entries, **why, **until))
    elif result:
        output.show_front(Console(), found, result, whole)
    if picture and result:
        draw(found, result, picture)
        if not as_json:
            say(f"\nPicture: {picture}")
    if result.reason:
        return no_plan(result.reason, planner)
    if result.ended:
        tell(result.ending)
    return INTERRUPTED if result.ended == "interrupt" else DONE
