"""The command line: one program, `prefplan`."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

from rich.console import Console

from experiments import automaton_formats, output, scenarios
from experiments.files import make_folder, write_json
from experiments.progress import Bars
from experiments.start import INTERRUPTED, loading, tell_if_compiling
from prefplan.automaton import automaton as minimal_automaton
from prefplan.errors import PrefplanError
from prefplan.front import Front, NoPlanError, Plan, Reason
from prefplan.planner import Planner

DONE, BAD_INPUT, NO_PLAN, FAILED = 0, 2, 3, 4


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
    tell_if_compiling()
    result = Planner(scenario.problem()).front(
        max_cost=options.max_cost,
        max_seconds=options.max_seconds,
        max_memory=None if options.max_memory is None else float(options.max_memory) * 2**20,
        keep_on_interrupt=True,
    )
    if options.json:
        _print_json(output.front_json(scenario, result))
    elif result:
        output.show_front(Console(soft_wrap=True), scenario, result)
    if result.reason:
        return _no_plan(result.reason)
    if result.ended:
        print(f"prefplan: {output.ended_early(result)}", file=sys.stderr)
    return INTERRUPTED if result.ended == "interrupt" else DONE


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
            _print_json(output.front_json(scenario, Front((), reason=error.reason, stats=planner.stats)))
        return _no_plan(error.reason)
    if options.json:
        _print_json(output.one_plan_json(scenario, chosen, planner.stats))
    else:
        output.show_plan(Console(soft_wrap=True), scenario, chosen)
    return DONE


def run(options: argparse.Namespace) -> int:
    """Carry out `prefplan run`."""
    # MuJoCo takes a second to load, which the other commands are spared.
    with loading():
        from experiments.carry_out import carry_out, scene_of
        from experiments.outcome import no_outcome_json, outcome_json, show_outcome

    scenario = scenarios.find(options.scenario)
    folder = options.out or Path("out", scenario.name)
    name = options.plan if isinstance(options.plan, str) else f"plan_{options.plan}"
    tell_if_compiling()
    try:
        with Bars() as bars:
            scene = scene_of(scenario)
            make_folder(folder)
            bars("planning", 0, 0, "")
            planner = Planner(scenario.problem())
            chosen = _choose(planner, options.plan)
            bars("planning", 1, 1, "")
            film = None if options.no_video else folder / f"{name}.mp4"
            outcome = carry_out(scenario, scene, chosen, seed=options.seed, film=film, tell=bars)
    except NoPlanError as error:
        if options.json:
            _print_json(output.front_json(scenario, Front((), reason=error.reason, stats=planner.stats)))
        return _no_plan(error.reason)
    except KeyboardInterrupt:
        if options.json:
            _print_json(no_outcome_json())
        raise
    write_json(folder / f"{name}.json", outcome_json(outcome))
    if options.json:
        _print_json(outcome_json(outcome))
    else:
        show_outcome(Console(soft_wrap=True, highlight=False), scenario, outcome)
    if outcome.no_video:
        print(f"prefplan: no video: {outcome.no_video}", file=sys.stderr)
    if outcome.interrupted:
        print("prefplan: interrupted", file=sys.stderr)
        return INTERRUPTED
    if not outcome.rollout.completed:
        if options.json:
            print(f"prefplan: execution failed {outcome.rollout.reason}", file=sys.stderr)
        return FAILED
    return DONE


def automaton(options: argparse.Namespace) -> int:
    """Carry out `prefplan automaton`."""
    found = minimal_automaton(options.formula)
    if options.format == "table":
        automaton_formats.show_table(Console(soft_wrap=True), found)
    else:
        print(automaton_formats.WRITERS[options.format](found), end="")
    return DONE


def _choose(planner: Planner, wanted: str | int) -> Plan:
    """Return the plan that `--plan` names."""
    if wanted == "cost":
        return planner.cheapest()
    if wanted == "preference":
        return planner.preferred()
    found = planner.front()
    if found.reason:
        raise NoPlanError(found.reason)
    if int(wanted) >= len(found):
        there = "one plan, 0" if len(found) == 1 else f"plans 0 to {len(found) - 1}"
        raise PrefplanError(f"--plan {wanted}: the front has {there}")
    return found[int(wanted)]


def _no_plan(reason: Reason) -> int:
    print(f"prefplan: {reason}", file=sys.stderr)
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


def _which_plan(text: str) -> str | int:
    if text in ("cost", "preference"):
        return text
    if text.isascii() and text.isdigit():
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is neither cost nor preference nor a plan's number, counted from 0")


def _seed(text: str) -> int:
    if text.isascii() and text.isdigit():
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is not a whole number >= 0")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="prefplan",
        description="Plan temporal tasks at the best trade-offs of cost and preference, and carry the plans out.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add_bare(function: Callable[[argparse.Namespace], int], summary: str, example: str) -> argparse.ArgumentParser:
        sub = commands.add_parser(
            function.__name__,
            help=summary,
            description=summary,
            epilog=f"example: {example}",
        )
        sub.set_defaults(command=function)
        return sub

    def add(function: Callable[[argparse.Namespace], int], summary: str, example: str) -> argparse.ArgumentParser:
        sub = add_bare(function, summary, example)
        sub.add_argument("scenario", metavar="SCENARIO", help="name of a scenario that ships, or path of a TOML file")
        sub.add_argument("--json", action="store_true", help="print one JSON object and nothing else")
        return sub

    sub = add(front, "Print the Pareto front of total cost and preference.", "prefplan front case_study_1")
    sub.add_argument("--max-cost", type=_number, metavar="C", help="only plans of at most this total cost")
    sub.add_argument("--max-seconds", type=float, metavar="S", help="stop after this time with what was found")
    sub.add_argument("--max-memory", type=_number, metavar="MB", help="stop before the search takes more memory")
    sub = add(plan, "Print one plan.", "prefplan plan case_study_1 --max-preference 24")
    sub.add_argument(
        "--objective",
        choices=["cost", "preference"],
        default="cost",
        help="what the plan should be best at (default: cost)",
    )
    sub.add_argument("--max-preference", type=_number, metavar="M", help="bound on the plan's preference value")
    sub.add_argument("--max-cost", type=_number, metavar="C", help="only plans of at most this total cost")
    sub = add(run, "Carry a plan out in simulation and film it.", "prefplan run case_study_3 --plan preference")
    sub.add_argument(
        "--plan",
        type=_which_plan,
        default="cost",
        metavar="cost|preference|INDEX",
        help="which plan of the front: the cheapest, the preferred, or by its number from 0 (default: cost)",
    )
    sub.add_argument("--out", type=Path, metavar="DIR", help="folder for the results (default: out/SCENARIO)")
    sub.add_argument(
        "--seed", type=_seed, metavar="N", help="move each object by up to 5 mm and 5 degrees at the start"
    )
    sub.add_argument("--no-video", action="store_true", help="render nothing")
    sub = add_bare(automaton, "Print a task's automaton.", "prefplan automaton '!pizza U cheese' --format dot")
    sub.add_argument("formula", metavar="FORMULA", help="a co-safe formula of ! & | -> X F U, names, true, false")
    sub.add_argument(
        "--format",
        choices=["table", *automaton_formats.WRITERS],
        default="table",
        help="for people, for other tools, or for Graphviz (default: table)",
    )
    return parser
