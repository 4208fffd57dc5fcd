"""`prefplan check`: validates and summarizes a scenario without planning."""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from rich.markup import escape
from rich.table import Table
from rich.text import Text

from experiments.cli import output
from experiments.cli.arguments import Commands, add_command
from experiments.cli.console import Console
from experiments.cli.options import LIMITS, add_options, limits_of
from experiments.cli.progress import Bars
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import BAD_INPUT, DONE, INTERRUPTED, no_plan
from experiments.commands.planning import checkup
from prefplan.front import Reason
from prefplan.scenario.decode import Scenario, load
from prefplan.text.layout import number
from prefplan.text.names import DisplayNames

if TYPE_CHECKING:
    from sim.execution.feasibility import PlaceCheck


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    more = (
        "Likely mistakes are warnings on stderr. The exit status is 2 if the arm cannot work in the scene (all faults "
        "are listed) or a task needs what the arm cannot do, and 3 if a task cannot be satisfied even alone."
    )
    parser = add_command(
        commands,
        check,
        "prefplan check example",
        "prefplan check case_study_3 --robot fetch --quick",
        more=more,
    )
    add_options(parser, "scenario")
    parser.add_argument(
        "--quick", action="store_true", help="do not try out what the arm can do with each object at each location"
    )
    add_options(parser, "--robot", "--json", *LIMITS, found="what is known by then")


def check(options: argparse.Namespace) -> int:
    """Check a scenario without planning: its size, each task alone, and what the arm can do in its scene."""
    tell_if_compiling(quiet=options.quiet)
    with limits_of(options) as limits:
        scenario = load(options.scenario)
    left = {"max_seconds": limits.seconds_left, "max_memory": limits.bytes - limits.bytes_taken}
    with Bars(quiet=options.quiet) as bars:
        found = checkup.check(scenario, robot=_robot(options.robot), quick=options.quick, tell=bars, **left)
    if options.json:
        output.print_json(_json(scenario, found))
    else:
        _show(Console(highlight=False), scenario, found)
    for warning in found.warnings:
        print(f"prefplan: warning: {warning}", file=sys.stderr)
    for fault in found.faults:
        print(f"prefplan: {scenario.path}: {fault}", file=sys.stderr)
    if found.interrupted:
        print("prefplan: interrupted", file=sys.stderr)
        return INTERRUPTED
    if found.faults:
        return BAD_INPUT
    return no_plan(Reason("task", found.impossible)) if found.impossible else DONE


def _robot(name: str | None) -> str | None:
    """Return the value of `--robot`; the libraries that check it take a second to load."""
    if name is None:
        return None
    with loading():
        from experiments.cli.simulation_options import robot_of
    return robot_of(name)


def _json(scenario: Scenario, found: checkup.Checkup) -> dict[str, Any]:
    places = found.places and [
        {"object": one.obj, "location": one.location, "take": one.take, "put": one.put, "reason": one.reason}
        for one in found.places
    ]
    heading = {"scenario": scenario.name, "path": str(scenario.path)}
    return heading | asdict(found) | {"places": places, "meaning": checkup.SEARCHES[found.contract]}


def _show(console: Console, scenario: Scenario, found: checkup.Checkup) -> None:
    display = scenario.problem().display
    console.print(f"{scenario.name}: a {found.kind} model", style="bold", markup=False)
    if found.states is None or found.reachable is None:
        size = "states not counted" if found.interrupted else "more states than could be listed"
    else:
        unreachable = found.states - found.reachable
        beyond = f" ({unreachable} cannot be reached)" if unreachable else ""
        size = f"{found.states} states{beyond}, {found.edges} actions in them"
    console.print(f"  {size}, {len(found.propositions)} propositions")
    if found.dropped:
        edges = "1 edge" if found.dropped == 1 else f"{found.dropped} edges"
        console.print(f"  {edges} of the file left out: dominated by another edge between the same states")
    if len(found.costs) == len(found.preferences) == 1:
        if found.contract not in checkup.USUAL:
            console.print(f"  preference: {found.contract} contract; {checkup.SEARCHES[found.contract]}")
    else:
        _show_objectives(console, found)
    if found.scene is not None:
        console.print(f"  the arm {'can' if found.scene else 'cannot'} work in its scene")
    if found.places:
        _show_places(console, found.places, display, complete=found.complete)
    table = Table(title="Each task alone", title_justify="left")
    table.add_column("task", style="bold")
    for name in found.costs:
        table.add_column(f"least {name}", justify="right")
    table.add_column("automaton", justify="right")
    optional = any(task.relaxations or task.skip is not None for task in found.tasks)
    if optional:
        table.add_column("may be")
    table.add_column("formula")
    for task in found.tasks:
        unknown = "impossible" if task.achievable is not None else "unknown"
        costs = [unknown if task.costs is None else number(task.costs[name]) for name in found.costs]
        options = []
        if task.relaxations:
            options.append("relaxed" if task.relaxations == 1 else f"relaxed ({task.relaxations} entries)")
        if task.skip is not None:
            options.append(f"skipped for {number(task.skip)}")
        cells = [
            escape(display.task(task.name)),
            *costs,
            f"{task.automaton_states} states",
            *[" or ".join(options)] * optional,
        ]
        table.add_row(*cells, Text(task.formula))
    console.print(table)


def _show_objectives(console: Console, found: checkup.Checkup) -> None:
    """Print the costs and the preferences of a scenario that does not have one of each."""
    console.print(f"  costs: {', '.join(found.costs)}", markup=False)
    for one in found.preferences:
        needs = f"; a front needs --at-most {one.of}=VALUE" if one.contract == "general" else ""
        console.print(f"  preference {one.name}, of {one.of}: {one.contract} contract{needs}", markup=False)


def _show_places(console: Console, places: Sequence[PlaceCheck], display: DisplayNames, *, complete: bool) -> None:
    """Print what the arm cannot do with each object at each location; one line if it can do everything."""
    reasons = defaultdict[tuple[str, str], list[str]](list)
    for one in places:
        if one.reason is not None:
            reasons[one.obj, one.reason].append(one.location)
    if not reasons:
        count = f"{len(places)} pairs tried"
        what = f"every object at every place ({count})" if complete else f"the object of each of the {count}"
        console.print(f"  it can grasp and put down {what}")
        return
    impossible = sum(one.reason is not None for one in places)
    table = Table(title=f"What the arm cannot do: {impossible} of {len(places)} pairs", title_justify="left")
    table.add_column("object", style="bold")
    table.add_column("at")
    table.add_column("why not")
    for (obj, reason), locations in reasons.items():
        table.add_row(Text(display.obj(obj)), Text(", ".join(map(display.location, locations))), Text(reason))
    console.print(table)
