"""`prefplan plan`: one plan of a scenario."""

from __future__ import annotations

import argparse
import sys

from experiments.cli import output
from experiments.cli.arguments import Commands, add_command
from experiments.cli.choice import chosen_plan, show_no_plan, tell_if_unchecked
from experiments.cli.completion import OBJECTIVES
from experiments.cli.console import Console
from experiments.cli.options import LIMITS, PLAN, add_options, limits_of
from experiments.cli.start import tell_if_compiling
from experiments.cli.status import DONE, FAILED, INTERRUPTED
from prefplan.front import NoPlanError, UnfinishedError
from prefplan.planner import Planner
from prefplan.scenario.decode import Scenario, load

MORE = """\
A limit, or Ctrl-C, may end the search before its plan is found. Then the best plan so far is printed and, for the
cheapest plan of nine or more tasks, by how much it may be dearer. If no plan is known, the exit status is 4, although a
plan may exist (if none does, it is 3). With --json, "complete" is false in both cases."""


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    examples = (
        "prefplan plan example --plan preference",
        "prefplan plan case_study_1 --max-preference 24",
        "prefplan plan case_study_1 --max-seconds 10 --json",
        "prefplan plan rover --objective energy --at-most time=80",
    )
    parser = add_command(commands, plan, *examples, more=MORE)
    add_options(parser, "scenario", "--json", *PLAN)
    parser.add_argument(
        "--objective",
        dest="plan",
        choices=OBJECTIVES,
        metavar="NAME",
        help="the plan with the least value of this cost or preference, by its name; cost and preference are the "
        "first of each",
    )
    add_options(parser, "--at-most", *LIMITS, found="the best plan so far")


def plan(options: argparse.Namespace) -> int:
    """Print one plan: the cheapest, the preferred, or the cheapest within a bound on the penalty."""
    tell_if_compiling(quiet=options.quiet)
    with limits_of(options):
        scenario = load(options.scenario)
        planner = Planner(scenario.problem())
        try:
            chosen = chosen_plan(planner, options, keep_on_interrupt=True)
        except UnfinishedError as error:
            return _unfinished(options, scenario, planner, error)
        except NoPlanError as error:
            return show_no_plan(options, scenario, planner, error)
    if options.json:
        output.print_json(output.one_plan_json(scenario, chosen, planner.stats))
    else:
        output.show_plan(Console(), scenario, chosen)
    tell_if_unchecked(scenario, quiet=options.quiet)
    return DONE


def _unfinished(options: argparse.Namespace, scenario: Scenario, planner: Planner, error: UnfinishedError) -> int:
    """Print the result of a search that a limit or Ctrl-C ended, and return the exit status."""
    if options.json:
        output.print_json(output.unfinished_json(scenario, error, planner.stats))
    elif error.best:
        output.show_plan(Console(), scenario, error.best)
    if error.best:
        tell_if_unchecked(scenario, quiet=options.quiet)
    print(f"prefplan: {error}", file=sys.stderr)
    if error.ended == "interrupt":
        return INTERRUPTED
    return DONE if error.best else FAILED
