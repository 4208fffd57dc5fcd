"""`prefplan front`: the Pareto front of a scenario."""

from __future__ import annotations

import argparse
import sys

from rich.console import Console

from experiments import output, scenarios
from experiments.arguments import Commands, add_command, add_json, add_scenario, number
from experiments.start import tell_if_compiling
from experiments.status import DONE, INTERRUPTED, no_plan
from prefplan.planner import Planner


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "Print the Pareto front of total cost and preference."
    parser = add_command(commands, front, summary, "prefplan front case_study_1")
    add_scenario(parser)
    add_json(parser)
    parser.add_argument("--max-cost", type=number, metavar="C", help="only plans of at most this total cost")
    parser.add_argument("--max-seconds", type=float, metavar="S", help="stop after this time with what was found")
    parser.add_argument("--max-memory", type=number, metavar="MB", help="stop before the search takes more memory")


def front(options: argparse.Namespace) -> int:
    """Carry out `prefplan front`."""
    scenario = scenarios.find(options.scenario)
    tell_if_compiling()
    result = Planner(scenario.problem()).front(
        max_cost=options.max_cost,
        max_seconds=options.max_seconds,
        max_memory=None if options.max_memory is None else float(options.max_memory) * 2**20,
        keep_on_interrupt=True,
    )
    if options.json:
        output.print_json(output.front_json(scenario, result))
    elif result:
        output.show_front(Console(soft_wrap=True), scenario, result)
    if result.reason:
        return no_plan(result.reason)
    if result.ended:
        print(f"prefplan: {output.ended_early(result)}", file=sys.stderr)
    return INTERRUPTED if result.ended == "interrupt" else DONE
