"""`prefplan sweep`: a plan carried out many times, each time with other random differences."""

from pathlib import Path

import click

import prefplan as pp
from experiments.checks.no_plan import chosen_plan
from experiments.cli import options, output
from experiments.cli.choice import Wanted
from experiments.cli.command import command
from experiments.cli.console import Console
from experiments.cli.files import only_writer, write_json
from experiments.cli.progress import Bars
from experiments.cli.start import load_planner, loading_simulation
from experiments.cli.status import DONE, INTERRUPTED, tell
from experiments.cli.values import POSITIVE, WHOLE
from prefplan.errors import check_known, prefixed


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
@options.out("out/SCENARIO/sweep_PLAN; an interrupted sweep continues there")
def sweep(
    scenario: str,
    as_json: bool,
    rollouts: int,
    jobs: int | None,
    wanted: Wanted,
    seed: int,
    perturb: str | None,
    robot: str | None,
    faults: str | None,
    out: Path | None,
) -> int:
    """Carry a plan out many times with random differences, and say how often it succeeds.

    Examples:
      prefplan sweep case_study_3 --rollouts 20
      prefplan sweep case_study_3 --plan preference --rollouts 200 --perturb position=8,angle=10
    """
    with loading_simulation():
        from experiments.cli.simulation_options import perturbation_of
        from experiments.runs.geometry import asking_in
        from experiments.runs.run_plan import scene_of
        from experiments.sweep.faults import ANY, possible_kinds
        from experiments.sweep.job import Sweep, define, pack
        from experiments.sweep.summary import show_summary, summarise
        from experiments.sweep.workers import RECORDS, work
        from sim.execution.faults.fault import kinds

    load_planner()
    loaded = pp.load(scenario)
    folder = out or Path("out", loaded.name, f"sweep_{wanted.plan}")
    perturbation = perturbation_of(perturb, seed=seed)
    scene = scene_of(loaded, robot=robot)
    if faults is not None:
        check_known("--faults", "name", faults, (ANY, *kinds()), pp.PrefplanError)
        with prefixed("--faults "):
            possible_kinds(scene.model, faults)
    with Bars() as bars, only_writer(folder):
        bars("planning", 0, 0, "")
        loaded = asking_in(loaded, scene, robot=robot)
        chosen = chosen_plan(loaded, pp.Planner(loaded.problem()), wanted, as_json=as_json)
        bars("planning", 1, 1, "")
        job = Sweep(pack(loaded), scenario, wanted, chosen, seed, perturbation, faults, folder, robot)
        header, path = define(loaded, job), folder / RECORDS
        found, interrupted = work(job, rollouts, path, header, tell=bars, stage="sweeping", jobs=jobs)
        result = summarise(header, found, rollouts=rollouts)
        write_json(folder / "summary.json", result)
    if as_json:
        output.print_json(result)
    else:
        console = Console()
        show_summary(console, result)
        console.print(f"\nRecords: {path}", style="dim")
    if interrupted:
        tell("interrupted; the same command continues it")
    return INTERRUPTED if interrupted else DONE
