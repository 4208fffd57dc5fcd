"""`prefplan front`: the Pareto front of a scenario."""

from __future__ import annotations

import argparse
import sys

from experiments import scenarios
from experiments.cli import output
from experiments.cli.arguments import (
    Commands,
    add_command,
    add_json,
    add_limits,
    add_max_cost,
    add_plot,
    add_scenario,
)
from experiments.cli.console import Console
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import DONE, INTERRUPTED, no_plan
from prefplan.planner import Planner


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "Print the Pareto front of total cost and preference penalty."
    examples = (
        "prefplan front example",
        "prefplan front example --max-cost 8 --json",
        "prefplan front case_study_1 --max-seconds 10",
        "prefplan front case_study_1 --plot front.pdf",
    )
    parser = add_command(commands, front, summary, *examples)
    add_scenario(parser)
    add_json(parser)
    add_plot(parser)
    add_max_cost(parser)
    add_limits(parser, "the front so far")


def front(options: argparse.Namespace) -> int:
    """Carry out `prefplan front`."""
    scenario = scenarios.find(options.scenario)
    plot = None
    if options.plot is not None:
        with loading():
            from experiments.figures import front as picture
            from experiments.figures.figures import picture_file
        plot = picture_file(options.plot)
    tell_if_compiling(quiet=options.quiet)
    result = Planner(scenario.problem()).front(
        max_cost=options.max_cost,
        max_seconds=options.max_seconds,
        max_memory=options.max_memory,
        keep_on_interrupt=True,
    )
    if options.json:
        output.print_json(output.front_json(scenario, result))
    elif result:
        output.show_front(Console(), scenario, result)
    if plot and result:
        picture.draw(scenario, result, plot)
        if not options.json:
            print(f"\nPicture: {plot}")
    if result.reason:
        return no_plan(result.reason)
    if result.ended:
        print(f"prefplan: {result.ending}", file=sys.stderr)
    return INTERRUPTED if result.ended == "interrupt" else DONE
