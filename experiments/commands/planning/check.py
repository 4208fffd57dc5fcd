"""`prefplan check`: validates and summarizes a scenario without planning."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

import prefplan as pp
from experiments.checks.no_plan import no_plan
from experiments.cli import options, output
from experiments.cli.choice import check_arm_options
from experiments.cli.command import command
from experiments.cli.console import Console, table
from experiments.cli.progress import Bars
from experiments.cli.start import load_planner
from experiments.cli.status import BAD_INPUT, DONE, INTERRUPTED, tell
from prefplan.text.layout import number

if TYPE_CHECKING:
    from prefplan.limits import Limits
    from prefplan.text.names import DisplayNames


@command
@options.scenario
@click.option("--quick", is_flag=True, help="Do not try out what the arm can do with each object at each location.")
@options.robot
@options.as_json
@options.limits()
def check(scenario: str, quick: bool, robot: str | None, as_json: bool, limits: Limits) -> int:
    """Check a scenario without planning: its size, each task alone, and what the arm can do in its scene.

    Examples:
      prefplan check example
      prefplan check case_study_3 --robot fetch --quick

    Likely mistakes are warnings on stderr. The exit status is 2 if the arm cannot work in the scene (all faults are
    listed) or a task needs what the arm cannot do, and 3 if a task cannot be satisfied even alone.
    """
    from experiments.checks import checkup

    load_planner()
    with limits:
        loaded = pp.load(scenario)
    check_arm_options(loaded)
    with Bars() as bars:
        found = checkup.check(loaded, robot=robot, quick=quick, limits=limits, tell=bars)
    stopped = not found["complete"] and (found["interrupted"] or limits.out_of_time)
    if as_json:
        output.print_json(found)
    else:
        _show(Console(), found, loaded.problem().display, stopped=stopped)
    for warning in found["warnings"]:
        tell(f"warning: {warning}")
    for fault in found["faults"]:
        tell(f"{loaded.path}: {fault}")
    if found["interrupted"]:
        tell("interrupted")
        return INTERRUPTED
    if stopped:
        tell("stopped by the time limit; not all was checked")
    if found["faults"]:
        return BAD_INPUT
    impossible = checkup.impossible(found)
    with limits:
        return no_plan(checkup.reason(loaded.problem(), impossible)) if impossible else DONE


def _show(console: Console, found: Mapping[str, Any], display: DisplayNames, *, stopped: bool) -> None:
    """Print what `experiments.checks.checkup.check` found, and whether it was stopped."""
    console.print(f"{found['scenario']}: a {found['kind']} model", style="bold")
    if found["states"] is None:
        size = "states not counted" if stopped else "more states than could be listed"
    else:
        unreachable = found["states"] - found["reachable"]
        beyond = f" ({unreachable} cannot be reached)" if unreachable else ""
        size = f"{found['states']} states{beyond}, {found['edges']} actions in them"
    console.print(f"  {size}, {len(found['propositions'])} propositions")
    costs, preferences = found["costs"], found["preferences"]
    if len(costs) == len(preferences) == 1:
        if found["contract"] not in ("additive", "convex"):  # these ask nothing of the user
            console.print(f"  preference: {found['contract']} contract; {found['meaning']}")
    else:
        console.print(f"  costs: {', '.join(costs)}")
        for one in preferences:
            needs = f"; a front needs --at-most {one['of']}=VALUE" if one["contract"] == "general" else ""
            told = f"  preference {one['name']}, of {one['of']}: {one['contract']} contract{needs}"
            console.print(told)
    if found["scene"] is not None:
        console.print(f"  the arm {'can' if found['scene'] else 'cannot'} work in its scene")
    if found["places"]:
        _show_places(console, found["places"], display, complete=found["complete"])
    rows = [_task_row(task, display.task(task["name"]), costs) for task in found["tasks"]]
    heads = ["task", *(f"least {name}" for name in costs), "automaton", "may be", "formula"]
    if not any(row[-2] for row in rows):
        heads, rows = [*heads[:-2], heads[-1]], [[*row[:-2], row[-1]] for row in rows]
    console.print(table("Each task alone", heads, rows, right=range(1, 2 + len(costs)), bold=[0]))


def _task_row(task: Mapping[str, Any], shown: str, costs: Sequence[str]) -> list[str]:
    """Return what is found of a task: its name, costs, automaton, what may be done instead, and its formula."""
    unknown = "impossible" if task["achievable"] is not None else "unknown"
    options = []
    if count := task["relaxations"]:
        options.append("relaxed" if count == 1 else f"relaxed ({count} entries)")
    if task["skip"] is not None:
        options.append(f"skipped for {number(task['skip'])}")
    least = [unknown if task["costs"] is None else number(task["costs"][name]) for name in costs]
    return [shown, *least, f"{task['automaton_states']} states", " or ".join(options), task["formula"]]


def _show_places(
    console: Console, places: Sequence[Mapping[str, Any]], display: DisplayNames, *, complete: bool
) -> None:
    """Print what the arm cannot do with each object at each location; one line if it can do everything."""
    reasons = defaultdict[tuple[str, str], list[str]](list)
    for one in places:
        if one["reason"] is not None:
            reasons[one["object"], one["reason"]].append(one["location"])
    if not reasons:
        count = f"{len(places)} pairs tried"
        what = f"every object at every place ({count})" if complete else f"the object of each of the {count}"
        console.print(f"  it can grasp and put down {what}")
        return
    impossible = sum(one["reason"] is not None for one in places)
    title = f"What the arm cannot do: {impossible} of {len(places)} pairs"
    rows = [
        (display.obj(obj), ", ".join(map(display.location, locations)), reason)
        for (obj, reason), locations in reasons.items()
    ]
    console.print(table(title, ("object", "at", "why not"), rows, bold=[0]))
