"""The command line: one program, `prefplan`."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from decimal import Decimal, InvalidOperation
from typing import Any

from rich.console import Console

from experiments import output, scenarios
from prefplan.errors import PrefplanError
from prefplan.front import Front, NoPlanError, Reason
from prefplan.planner import Planner, pareto_front

DONE, BAD_INPUT, NO_PLAN, FAILED, INTERRUPTED = 0, 2, 3, 4, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program and return its exit status."""
    options = _parser().parse_args(arguments)
    command: Callable[[argparse.Namespace], int] = options.command
    try:
        return command(options)
    except PrefplanError as error:
        print(f"prefplan: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("prefplan: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        sys.stderr.close()
        return DONE


def front(options: argparse.Namespace) -> int:
    """Carry out `prefplan front`."""
    scenario = scenarios.find(options.scenario)
    result = pareto_front(scenario.problem(), max_cost=options.max_cost)
    if options.json:
        _print_json(output.front_json(scenario, result))
    elif result:
        output.show_front(Console(soft_wrap=True), scenario, result)
    return _no_plan(result.reason) if result.reason else DONE


def plan(options: argparse.Namespace) -> int:
    """Carry out `prefplan plan`."""
    scenario = scenarios.find(options.scenario)
    planner = Planner(scenario.problem())
    choose = planner.cheapest if options.objective == "cost" else planner.preferred
    try:
        chosen = choose(max_preference=options.max_preference)
    except NoPlanError as error:
        if options.json:
            _print_json(output.front_json(scenario, Front((), reason=error.reason, stats=planner.stats)))
        return _no_plan(error.reason)
    if options.json:
        _print_json(output.one_plan_json(scenario, chosen, planner.stats))
    else:
        output.show_plan(Console(soft_wrap=True), scenario, chosen)
    return DONE


def _no_plan(reason: Reason) -> int:
    print(f"prefplan: no plan: {reason}", file=sys.stderr)
    return NO_PLAN


def _print_json(value: dict[str, Any]) -> None:
    print(json.dumps(value, indent=1))


def _number(text: str) -> Decimal:
    try:
        value = Decimal(text)
    except InvalidOperation:
        value = Decimal("nan")
    if not value.is_finite() or value < 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number >= 0")
    return value


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="prefplan",
        description="Plan temporal tasks at the best trade-offs of cost and preference, and carry the plans out.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add(function: Callable[[argparse.Namespace], int], summary: str, example: str) -> argparse.ArgumentParser:
        sub = commands.add_parser(
            function.__name__,
            help=summary,
            description=summary,
            epilog=f"example: {example}",
        )
        sub.add_argument("scenario", metavar="SCENARIO", help="name of a scenario that ships, or path of a TOML file")
        sub.add_argument("--json", action="store_true", help="print one JSON object and nothing else")
        sub.set_defaults(command=function)
        return sub

    sub = add(front, "Print the Pareto front of total cost and preference.", "prefplan front case_study_1")
    sub.add_argument("--max-cost", type=_number, metavar="C", help="only plans of at most this total cost")
    sub = add(plan, "Print one plan.", "prefplan plan case_study_1 --max-preference 24")
    sub.add_argument(
        "--objective",
        choices=["cost", "preference"],
        default="cost",
        help="what the plan should be best at (default: cost)",
    )
    sub.add_argument("--max-preference", type=_number, metavar="M", help="bound on the plan's preference value")
    return parser
