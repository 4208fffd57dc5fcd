"""`prefplan view`: a plan carried out live in the browser."""

from __future__ import annotations

import argparse
import importlib.util
from typing import TYPE_CHECKING

from experiments.cli.arguments import Commands, add_command
from experiments.cli.browser import open_page
from experiments.cli.choice import chosen_plan, continuation
from experiments.cli.options import PLAN, add_options
from experiments.cli.progress import Bars
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import DONE, no_plan
from prefplan.errors import PreferenceError, PrefplanError
from prefplan.exact_costs import Number
from prefplan.front import NoPlanError
from prefplan.plan import Plan
from prefplan.planner import Planner
from prefplan.scenario.decode import load

if TYPE_CHECKING:
    from experiments.runs.carry_out import Conditions
    from experiments.viewer.live_run import Begin

INSTALL = "pip install '.[sim,viewer]', in a clone of prefplan"
"""Installs the libraries of this command."""

FRONT_TIMEOUT_S = 20.0
"""Time limit of the search for the other plans of the front."""


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    examples = (
        "prefplan view case_study_3 --plan preference",
        "prefplan view case_study_3 --fault slip@3 --camera wrist --port 0",
    )
    parser = add_command(commands, view, *examples)
    add_options(parser, "scenario", *PLAN, "--seed", "--fault", "--robot", "--camera")
    parser.add_argument(
        "--port",
        type=port,
        metavar="P",
        help="port of the page, 0 for any free one (default: 8080 or the next free one)",
    )
    add_options(parser, "--no-open")


def view(options: argparse.Namespace) -> int:
    """Carry plans out live in the browser, where you can interfere. Ctrl-C ends it, with status 0."""
    if not all(importlib.util.find_spec(name) for name in ("viser", "mjviser")):
        raise PrefplanError(f"view needs the libraries viser and mjviser: {INSTALL}")
    with loading():
        from experiments.cli.simulation_options import camera_of, faults_of, robot_of
        from experiments.runs.carry_out import begin, scene_of
        from experiments.viewer.session import Show, watch

    scenario = load(options.scenario)
    faults, robot = faults_of(options.fault, scenario), robot_of(options.robot)
    tell_if_compiling(quiet=options.quiet)
    with Bars(quiet=options.quiet) as bars:
        scene = scene_of(scenario, robot=robot, faults=faults)
        camera = camera_of(options.camera, lambda: scene)
        bars("planning", 0, 0, "")
        problem = scenario.problem()
        try:
            planner = Planner(problem)
            plan = chosen_plan(planner, options)
            plans = front_with(plan, planner, max_cost=options.max_cost)
        except NoPlanError as error:
            return no_plan(error.reason, problem)
    chosen, choice = plans.index(plan), continuation(options.plan, options.max_preference)

    def ready(address: str) -> None:
        print(f"{scenario.name}: {address} (Ctrl-C ends it)", flush=True)
        if not options.no_open:
            open_page(address)

    def start(i: int) -> Begin:
        conditions: Conditions = {"seed": options.seed, "faults": faults, "choice": choice if i == chosen else i}
        return lambda tell: begin(problem, scene, plans[i], tell=tell, **conditions)

    watch(Show(problem, scene, plans, start, scenario.name, chosen, camera), port=options.port, ready=ready)
    return DONE


def front_with(plan: Plan, planner: Planner, *, max_cost: Number | None) -> list[Plan]:
    """Return the part of the front found within `FRONT_TIMEOUT_S`, and in it a plan that is known already."""
    try:
        front = [*planner.front(max_cost=max_cost, max_seconds=FRONT_TIMEOUT_S)]
    except PreferenceError:
        # The front under a general preference needs a bound on the cost, and the user gave none.
        front = []
    points = [(other.cost, other.preference) for other in front]
    point = plan.cost, plan.preference
    if point not in points:
        return sorted([*front, plan], key=lambda other: other.cost)
    front[points.index(point)] = plan
    return front


def port(text: str) -> int:
    """Return a port, 0 to 65535."""
    if text.isascii() and text.isdigit() and int(text) < 1 << 16:
        return int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is not a port, 0 to 65535")
