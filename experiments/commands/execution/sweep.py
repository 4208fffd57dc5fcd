"""`prefplan sweep`: a plan carried out many times, each time with other random differences."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable
from decimal import Decimal
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import click
from click.core import ParameterSource

import prefplan as pp
from experiments.checks.no_plan import show_no_plan
from experiments.cli import options, output
from experiments.cli.choice import choose, plan_name
from experiments.cli.command import command, is_quiet
from experiments.cli.console import Console
from experiments.cli.files import make_folder, write_json
from experiments.cli.journal import Journal, read_journal
from experiments.cli.progress import Bars
from experiments.cli.start import load_planner, loading
from experiments.cli.status import DONE, FAILED, INTERRUPTED, say, tell
from experiments.cli.values import positive, whole
from prefplan.errors import PrefplanError, choices, prefixed

if TYPE_CHECKING:
    from experiments.sweep.job import Sweep


@command
@options.scenario
@options.as_json
@click.option("--rollouts", type=positive, default="100", metavar="N", help="Number of runs (default: 100).")
@options.jobs
@options.which
@click.option("--seed", type=whole, default="0", metavar="N", help="Seed of all random numbers (default: 0).")
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
@click.option("--resimulate", is_flag=True, help="Simulate each run again from its log, as a check.")
@options.out("out/SCENARIO/sweep_PLAN, or boundary_PLAN_KEY; an interrupted sweep continues there")
@click.option(
    "--cluster", metavar="ADDRESS", help="Run on a Dask cluster, e.g. tcp://127.0.0.1:8786, not on this machine."
)
@click.option(
    "--replay",
    type=whole,
    metavar="K",
    help="Carry out rollout K, counted from 0, of the sweep in that folder again, with its recorded seed, differences, "
    "faults and robot, and render a video into DIR/rollout_K; the options below go with it.",
)
@options.no_video
@options.look
def sweep(
    scenario: str,
    as_json: bool,
    rollouts: int,
    jobs: int | None,
    plan: str | int,
    max_preference: Decimal | None,
    max_cost: Decimal | None,
    seed: int,
    perturb: str | None,
    robot: str | None,
    faults: str | None,
    find_boundary: str | None,
    resimulate: bool,
    out: Path | None,
    cluster: str | None,
    replay: int | None,
    no_video: bool,
    **look: Unpack[options.LookOptions],
) -> int:
    """Carry a plan out many times with random differences, and say how often it succeeds.

    Examples:
      prefplan sweep case_study_3 --rollouts 20
      prefplan sweep case_study_3 --plan preference --rollouts 200 --perturb position=8,angle=10
      prefplan sweep case_study_3 --find-boundary bias --rollouts 40
      prefplan sweep case_study_3 --replay 17 --camera wrist
    """
    with loading():
        from experiments.cli.simulation_options import checked, perturbation_of, robot_of
        from experiments.runs.carry_out import scene_of
        from experiments.sweep.faults import ANY, possible_kinds
        from experiments.sweep.job import Sweep, pack
        from sim.execution.faults.fault import KINDS
        from sim.world.randomization import KEYS

    load_planner(quiet=is_quiet())
    loaded, key = pp.load(scenario), find_boundary
    name = f"sweep_{plan}" if key is None else f"boundary_{plan}_{key}"
    folder = out or Path("out", loaded.name, name)
    if replay is not None:
        return _replay(loaded, scenario, folder, replay, as_json=as_json, no_video=no_video, **look)
    for option in ("no_video", *look):
        if click.get_current_context().get_parameter_source(option) is ParameterSource.COMMANDLINE:
            named = option.replace("_", "-")
            raise PrefplanError(f"--{named}: a sweep renders no videos; it goes with --replay K")
    if key is not None:
        checked("--find-boundary", key, KEYS)
    perturbation, robot = perturbation_of(perturb, seed=seed), robot_of(robot)
    faults = faults and checked("--faults", faults, (ANY, *KINDS))
    with Bars(quiet=is_quiet()) as bars:
        scene = scene_of(loaded, robot=robot)
        if faults:
            with prefixed("--faults "):
                possible_kinds(scene.model, faults)
        make_folder(folder)
        bars("planning", 0, 0, "")
        planner = pp.Planner(loaded.problem())
        try:
            chosen = choose(planner, plan, max_preference=max_preference, max_cost=max_cost)
        except pp.NoPlanError as error:
            return show_no_plan(loaded, planner, error, as_json=as_json)
        bars("planning", 1, 1, "")
        job = Sweep(
            packed=pack(loaded),
            given=scenario,
            which=plan,
            plan=chosen,
            seed=seed,
            perturbation=perturbation,
            faults=faults,
            folder=folder,
            max_cost=max_cost,
            max_preference=max_preference,
            robot=robot,
            resimulate=resimulate,
            rollouts=rollouts,
            jobs=jobs,
            cluster=cluster,
        )
        interrupted, show = _roll_out(loaded, job, bars) if key is None else _search(loaded, job, key, bars)
    show(as_json=as_json)
    if interrupted:
        tell("interrupted; the same command continues it")
        return INTERRUPTED
    return DONE


Shown = tuple[bool, Callable[..., None]]
"""Whether the work was interrupted, and what shows its result."""


def _roll_out(scenario: pp.Scenario, job: Sweep, bars: Bars) -> Shown:
    """Carry out the rollouts."""
    from experiments.sweep.recorded import RECORDS, define, work
    from experiments.sweep.summary import show_summary, summarise

    header, interrupted, path = define(scenario, job), False, job.folder / RECORDS
    with Journal(path, header, key="rollout") as records:
        try:
            work(job, records, tell=bars)
        except KeyboardInterrupt:
            interrupted = True
    # Ctrl-C may have come after a record was written and before it was counted: the file decides.
    with Journal(path, header, key="rollout") as records:
        finished = [records.done[i] for i in sorted(records.done) if i < job.rollouts]
    result = summarise(header, finished, rollouts=job.rollouts)
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


def _replay(scenario: pp.Scenario, named: str, folder: Path, wanted: int, **shown: Any) -> int:
    """Carry out one recorded rollout again, with a video, and return the exit status of the run.

    Args:
        scenario: of the sweep.
        named: how the call names it.
        folder: of the sweep's records.
        wanted: number of the rollout.
        **shown: parameters of `prefplan run` that say what is printed and how the video looks.
    """
    with loading():
        from experiments.commands.execution.run import run
        from experiments.sweep.recorded import RECORDS, fingerprint

    path = folder / RECORDS
    if not path.exists():
        raise PrefplanError(f"--replay {wanted}: {folder} holds no sweep; run the sweep first, or give its --out")
    header, records = read_journal(path, key="rollout")
    if header["scenario_sha256"] != fingerprint(scenario):
        raise PrefplanError(f"--replay {wanted}: {scenario.path} has changed since the sweep in {folder}")
    if wanted not in records:
        valid = map(str, sorted(records))
        raise PrefplanError(f"--replay {wanted}: no such rollout in {path} {choices(str(wanted), valid)}")
    record, into = records[wanted], folder / f"rollout_{wanted}"
    _, _, _, *conditions = shlex.split(record["replay"])
    with run.make_context("run", [named, *conditions], parent=click.get_current_context()) as context:
        context.params |= shown | {"out": into}
        status: int = run.invoke(context)
    if status not in (DONE, FAILED):
        return status
    outcome = json.loads((into / f"{plan_name(header['plan'])}.json").read_text(encoding="utf-8"))
    differing = [
        key for key in ("completed", "sim_seconds", "replans") if record.get(key, outcome[key]) != outcome[key]
    ]
    if differing:
        made = f"prefplan {header['prefplan']} and MuJoCo {header['mujoco']}"
        told = ", ".join(f"{key} {outcome[key]}, recorded {record[key]}" for key in differing)
        tell(f"rollout {wanted} differs from its record, made with {made}: {told}")
    elif not shown["as_json"]:
        say(f"rollout {wanted} ended as recorded: {'completed' if record['completed'] else record['reason']}")
    return status
