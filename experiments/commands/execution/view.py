"""`prefplan view`: a plan carried out live in the browser."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

import prefplan as pp
from experiments.checks.no_plan import chosen_plan
from experiments.cli import options
from experiments.cli.choice import Wanted
from experiments.cli.command import command
from experiments.cli.progress import Bars
from experiments.cli.start import load_planner, loading_simulation
from experiments.cli.status import DONE, say
from prefplan.errors import PreferenceError, PrefplanError

if TYPE_CHECKING:
    from experiments.runs.run_plan import Conditions
    from experiments.viewer.live_run import Begin
    from prefplan.exact_costs import Number

FRONT_TIMEOUT_S = 20.0
"""Time limit of the search for the other plans of the front, s."""


@command
@options.scenario
@options.which
@options.seed()
@options.fault
@options.robot
@options.camera
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    metavar="P",
    help="Port of the page, 0 for any free one (default: 8080 or the next free one).",
)
@options.no_open
def view(
    scenario: str,
    wanted: Wanted,
    seed: int | None,
    faults: Sequence[str],
    robot: str | None,
    camera: str,
    port: int | None,
    no_open: bool,
) -> int:
    """Carry plans out live in the browser, where you can interfere. Ctrl-C ends it, with status 0.

    Examples:
      prefplan view case_study_3 --plan preference
      prefplan view case_study_3 --fault slip@3 --camera wrist --port 0
    """
    if not all(importlib.util.find_spec(name) for name in ("viser", "mjviser")):
        install = "pip install '.[sim,viewer]', in a clone of prefplan"
        raise PrefplanError(f"view needs the libraries viser and mjviser: {install}")
    with loading_simulation():
        from experiments.cli.browser import open_page
        from experiments.cli.simulation_options import camera_of, faults_of
        from experiments.runs.geometry import asking_in
        from experiments.runs.run_plan import begin, scene_of
        from experiments.viewer.session import Show, watch

    load_planner()
    loaded = pp.load(scenario)
    injected = faults_of(faults, loaded)
    with Bars() as bars:
        scene = scene_of(loaded, robot=robot, faults=injected)
        camera = camera_of(camera, scene)
        bars("planning", 0, 0, "")
        problem = asking_in(loaded, scene, robot=robot).problem()
        planner = pp.Planner(problem)
        first = chosen_plan(loaded, planner, wanted)
        plans = front_with(first, planner, max_cost=wanted.max_cost)
    chosen = plans.index(first)

    def ready(address: str) -> None:
        say(f"{loaded.name}: {address} (Ctrl-C ends it)")
        if not no_open:
            open_page(address)

    def start(i: int) -> Begin:
        conditions: Conditions = {"seed": seed, "faults": injected, "choice": wanted.continuation if i == chosen else i}
        return lambda tell: begin(problem, scene, plans[i], tell=tell, **conditions)

    watch(Show(problem, scene, plans, start, loaded.name, chosen, camera), port=port, ready=ready)
    return DONE


def front_with(plan: pp.Plan, planner: pp.Planner, *, max_cost: Number | None) -> list[pp.Plan]:
    """Return the plans of the front found within `FRONT_TIMEOUT_S`, with a plan that is already known among them."""
    try:
        front = [*planner.front(max_cost=max_cost, max_seconds=FRONT_TIMEOUT_S)]
    except PreferenceError:
        # The front under a general preference needs a bound on the cost, and the user gave none.
        front = []
    known = {tuple(other.objectives.values()): other for other in (*front, plan)}
    return sorted(known.values(), key=lambda other: other.cost)
