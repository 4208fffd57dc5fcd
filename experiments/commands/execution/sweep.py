"""`prefplan sweep`: a plan carried out many times, each time with other random differences."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import prefplan as pp
from experiments.checks.no_plan import show_no_plan
from experiments.cli import options, output
from experiments.cli.choice import choose
from experiments.cli.command import command, is_quiet
from experiments.cli.console import Console
from experiments.cli.files import only_writer, write_json
from experiments.cli.progress import Bars
from experiments.cli.start import load_planner, loading_simulation
from experiments.cli.status import DONE, INTERRUPTED, tell
from experiments.cli.values import POSITIVE, WHOLE
from prefplan.errors import prefixed

if TYPE_CHECKING:
    from experiments.sweep.job import Sweep


@command
@options.scenario
@options.as_json
@click.option("--rollouts", type=POSITIVE, default="100", metavar="N", help="Number of runs (default: 100).")
@options.jobs
@options.which
@click.option("--seed", type=WHOLE, default="0", metavar="N", help="Seed of all random numbers (default: 0).")
@options.perturb
@options.robot
@click.option(
    "--faults",
    cls=options.FaultOption,
    metavar="random|KIND",
    help="One to three random faults in each run, or one of a kind; K is drawn, and what follows the colon",
)
@click.option(
    "--find-boundary",
    metavar="KEY",
    help="Search for the amount of this key of --perturb at which fewer than 95 percent of N runs are completed.",
)
@options.out("out/SCENARIO/sweep_PLAN, or boundary_PLAN_KEY; an interrupted sweep continues there")
def sweep(
    scenario: str,
    as_json: bool,
    plan: str | int,
    seed: int,
    perturb: str | None,
    robot: str | None,
    faults: str | None,
    find_boundary: str | None,
    out: Path | None,
    **settings: Any,
) -> int:
    """Carry a plan out many times with random differences, and say how often it succeeds.

    Examples:
      prefplan sweep case_study_3 --rollouts 20
      prefplan sweep case_study_3 --plan preference --rollouts 200 --perturb position=8,angle=10
      prefplan sweep case_study_3 --find-boundary bias --rollouts 40
    """
    with loading_simulation(quiet=is_quiet()):
        from experiments.cli.simulation_options import checked, perturbation_of
        from experiments.runs.geometry import asking_in
        from experiments.runs.run_plan import scene_of
        from experiments.sweep.job import Sweep, pack
        from sim.world.randomization import KEYS

    load_planner(quiet=is_quiet())
    loaded, key = pp.load(scenario), find_boundary and checked("--find-boundary", find_boundary, KEYS)
    folder = out or Path("out", loaded.name, f"boundary_{plan}_{key}" if key else f"sweep_{plan}")
    perturbation = perturbation_of(perturb, seed=seed)
    scene = scene_of(loaded, robot=robot)
    kind = faults and _kind(faults, scene.model)
    with Bars(quiet=is_quiet()) as bars, only_writer(folder):
        bars("planning", 0, 0, "")
        loaded = asking_in(loaded, scene, robot=robot)
        planner = pp.Planner(loaded.problem())
        try:
            chosen = choose(planner, plan, **{bound: settings[bound] for bound in ("max_preference", "max_cost")})
        except pp.NoPlanError as error:
            return show_no_plan(loaded, planner, error, as_json=as_json)
        bars("planning", 1, 1, "")
        job = Sweep(pack(loaded), scenario, plan, chosen, seed, perturbation, kind, folder, robot=robot, **settings)
        interrupted, show = _search(loaded, job, key, bars) if key else _roll_out(loaded, job, bars)
    show(as_json=as_json)
    if interrupted:
        tell("interrupted; the same command continues it")
    return INTERRUPTED if interrupted else DONE


def _kind(faults: str, model: pp.ManipulationModel) -> str:
    """Return the value of `--faults`, of which some can happen in a model."""
    from experiments.cli.simulation_options import checked
    from experiments.sweep.faults import ANY, possible_kinds
    from sim.execution.faults.fault import kinds

    kind = checked("--faults", faults, (ANY, *kinds()))
    with prefixed("--faults "):
        possible_kinds(model, kind)
    return kind


Shown = tuple[bool, Callable[..., None]]
"""Whether the work was interrupted, and what shows its result."""


def _roll_out(scenario: pp.Scenario, job: Sweep, bars: Bars) -> Shown:
    """Carry out the rollouts."""
    from experiments.sweep.job import define
    from experiments.sweep.summary import show_summary, summarise
    from experiments.sweep.workers import RECORDS, work

    header, path = define(scenario, job), job.folder / RECORDS
    found, interrupted = work(job, job.rollouts, path, header, tell=bars, stage="sweeping", jobs=job.jobs)
    result = summarise(header, found, rollouts=job.rollouts)
    write_json(job.folder / "summary.json", result)
    return interrupted, partial(_show, result, show_summary, f"Records: {path}")


def _search(scenario: pp.Scenario, job: Sweep, key: str, bars: Bars) -> Shown:
    """Search for the boundary."""
    from experiments.figures.boundary import draw
    from experiments.sweep.boundary import search_boundary, show_boundary

    result, figure = search_boundary(scenario, job, key, tell=bars), job.folder / "boundary.png"
    write_json(job.folder / "boundary.json", result)
    draw(result, figure)
    return not result["complete"], partial(_show, result, show_boundary, f"Figure: {figure}")


def _show(
    result: dict[str, Any], show: Callable[[Console, dict[str, Any]], None], where: str, *, as_json: bool
) -> None:
    if as_json:
        output.print_json(result)
        return
    console = Console(highlight=False)
    show(console, result)
    console.print(f"\n{where}", style="dim")
