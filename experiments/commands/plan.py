"""`prefplan plan`: one plan of a scenario."""

from __future__ import annotations

import argparse

from rich.console import Console

from experiments import output, scenarios
from experiments.arguments import Commands, add_command, add_json, add_scenario, number
from experiments.start import tell_if_compiling
from experiments.status import DONE, no_plan
from prefplan.front import Front, NoPlanError
from prefplan.planner import Planner


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    parser = add_command(commands, plan, "Print one plan.", "prefplan plan case_study_1 --max-preference 24")
    add_scenario(parser)
    add_json(parser)
    parser.add_argument(
        "--objective",
        choices=["cost", "preference"],
        default="cost",
        help="what the plan should be best at (default: cost)",
    )
    parser.add_argument("--max-preference", type=number, metavar="M", help="bound on the plan's preference value")
    parser.add_argument("--max-cost", type=number, metavar="C", help="only plans of at most this total cost")


def plan(options: argparse.Namespace) -> int:
    """Carry out `prefplan plan`."""
    scenario = scenarios.find(options.scenario)
    planner = Planner(scenario.problem())
    choose = planner.cheapest if options.objective == "cost" else planner.preferred
    tell_if_compiling()
    try:
        chosen = choose(max_preference=options.max_preference, max_cost=options.max_cost)
    except NoPlanError as error:
        if options.json:
            output.print_json(output.front_json(scenario, Front((), reason=error.reason, stats=planner.stats)))
        return no_plan(error.reason)
    if options.json:
        output.print_json(output.one_plan_json(scenario, chosen, planner.stats))
    else:
        output.show_plan(Console(soft_wrap=True), scenario, chosen)
    return DONE
