"""`prefplan front`: the Pareto front of a scenario."""

from __future__ import annotations

import argparse
import shlex
import sys
from functools import partial

from experiments.cli import output
from experiments.cli.arguments import Commands, add_command
from experiments.cli.choice import check_bounds, objective_name, tell_if_unchecked
from experiments.cli.completion import OBJECTIVES
from experiments.cli.console import Console
from experiments.cli.options import LIMITS, add_options, limits_of
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import DONE, INTERRUPTED, no_plan
from prefplan.planner import Planner
from prefplan.scenario.decode import load


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    examples = (
        "prefplan front example",
        "prefplan front example --max-cost 8 --json",
        "prefplan front case_study_1 --max-seconds 10",
        "prefplan front case_study_1 --plot front.pdf",
        "prefplan front rover --objective time --objective energy",
    )
    parser = add_command(commands, front, *examples)
    add_options(parser, "scenario", "--json", "--plot", "--max-cost", "--max-preference", "--at-most")
    parser.add_argument(
        "--objective",
        action="append",
        choices=OBJECTIVES,
        metavar="NAME",
        help="a cost or a preference by its name; given once or more, the front is that of these alone (default: all)",
    )
    add_options(parser, *LIMITS, found="the front so far")


def front(options: argparse.Namespace) -> int:
    """Print the Pareto front of total cost and penalty, or of several costs and preferences."""
    plot = None
    if options.plot is not None:
        with loading():
            from experiments.figures import front as picture
            from experiments.figures.figures import picture_file
        plot = picture_file(options.plot)
    tell_if_compiling(quiet=options.quiet)
    with limits_of(options):
        scenario = load(options.scenario)
        problem = scenario.problem()
        check_bounds(problem, options)
        wanted = [objective_name(problem, name) for name in options.objective or ()]
        bounds = dict(options.at_most or {})
        if options.max_preference is not None:
            name = problem.preferences[0].name
            bounds[name] = min(options.max_preference, bounds.get(name, options.max_preference))
        result = Planner(problem).front(over=wanted, max_cost=options.max_cost, at_most=bounds, keep_on_interrupt=True)
    if options.json:
        output.print_json(output.front_json(scenario, result))
    elif result:
        output.show_front(Console(), scenario, result, partial(_whole, options))
    if plot and result:
        picture.draw(scenario, result, plot)
        if not options.json:
            print(f"\nPicture: {plot}")
    if result:
        tell_if_unchecked(scenario, quiet=options.quiet)
    if result.reason:
        return no_plan(result.reason, problem)
    if result.ended:
        print(f"prefplan: {result.ending}", file=sys.stderr)
    return INTERRUPTED if result.ended == "interrupt" else DONE


def _whole(options: argparse.Namespace, index: int) -> str:
    """Return how to see all actions of the plan with an index.

    With some options, the plans have other numbers than on the whole front, which `prefplan plan` counts.
    """
    if options.objective or options.max_preference is not None or options.at_most:
        return "with --json, all are printed"
    return f"`prefplan plan {shlex.quote(options.scenario)} --plan {index}` prints all"
