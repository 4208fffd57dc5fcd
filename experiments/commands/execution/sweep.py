"""`prefplan sweep`: a plan carried out many times, each time with other random differences."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from experiments.cli import output
from experiments.cli.arguments import Commands, add_command, positive, whole
from experiments.cli.choice import chosen_plan, plan_name, show_no_plan
from experiments.cli.console import Console
from experiments.cli.files import make_folder, write_json
from experiments.cli.journal import Journal, read_journal
from experiments.cli.options import PLAN, VIDEO, add_options
from experiments.cli.progress import Bars
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import DONE, FAILED, INTERRUPTED
from prefplan.errors import PrefplanError, choices, prefixed
from prefplan.front import NoPlanError
from prefplan.planner import Planner
from prefplan.scenario.decode import Scenario, load

if TYPE_CHECKING:
    from experiments.sweep.job import Sweep


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    examples = (
        "prefplan sweep case_study_3 --rollouts 20",
        "prefplan sweep case_study_3 --plan preference --rollouts 200 --perturb position=8,angle=10",
        "prefplan sweep case_study_3 --find-boundary bias --rollouts 40",
        "prefplan sweep case_study_3 --replay 17 --camera wrist",
    )
    parser = add_command(commands, sweep, *examples)
    add_options(parser, "scenario", "--json")
    parser.add_argument("--rollouts", type=positive, default=100, metavar="N", help="number of runs (default: 100)")
    add_options(parser, "--jobs", *PLAN)
    parser.add_argument("--seed", type=whole, default=0, metavar="N", help="seed of all random numbers (default: 0)")
    add_options(parser, "--perturb", "--robot")
    parser.add_argument(
        "--faults",
        metavar="random|KIND",
        help="one to three random faults in each run, or one of a kind: slip, move, knock, miss, foreign or blind",
    )
    parser.add_argument(
        "--find-boundary",
        metavar="KEY",
        help="search for the amount of this key of --perturb at which fewer than 95 percent of N runs are completed",
    )
    parser.add_argument("--resimulate", action="store_true", help="simulate each run again from its log, as a check")
    add_options(
        parser, "--out", out="out/SCENARIO/sweep_PLAN, or boundary_PLAN_KEY; an interrupted sweep continues there"
    )
    parser.add_argument(
        "--cluster", metavar="ADDRESS", help="run on a Dask cluster, e.g. tcp://127.0.0.1:8786, not on this machine"
    )
    replay = parser.add_argument_group("replay")
    replay.add_argument(
        "--replay",
        type=whole,
        metavar="K",
        help="carry out rollout K, counted from 0, of the sweep in that folder again, with its recorded seed, "
        "differences, faults and robot, and render a video into DIR/rollout_K",
    )
    add_options(replay, *VIDEO)
    look = ("no_video", "quality", "camera", "inset", "size")
    parser.set_defaults(unseen={name: parser.get_default(name) for name in look})


def sweep(options: argparse.Namespace) -> int:
    """Carry a plan out many times with random differences, and say how often it succeeds."""
    with loading():
        from experiments.cli.simulation_options import checked, perturbation_of, robot_of
        from experiments.runs.carry_out import scene_of
        from experiments.sweep.faults import ANY, possible_faults
        from experiments.sweep.job import Sweep, pack
        from sim.execution.faults import SPELLINGS
        from sim.world.randomization import KEYS

    scenario, key = load(options.scenario), options.find_boundary
    name = f"sweep_{options.plan}" if key is None else f"boundary_{options.plan}_{key}"
    folder = options.out or Path("out", scenario.name, name)
    if options.replay is not None:
        return replay(options, scenario, folder)
    for name, default in options.unseen.items():
        if getattr(options, name) != default:
            raise PrefplanError(f"--{name.replace('_', '-')}: a sweep renders no videos; it goes with --replay K")
    if key is not None:
        checked("--find-boundary", key, KEYS)
    perturbation, robot = perturbation_of(options.perturb, seed=options.seed), robot_of(options.robot)
    faults = options.faults and checked("--faults", options.faults, (ANY, *SPELLINGS))
    tell_if_compiling(quiet=options.quiet)
    with Bars(quiet=options.quiet) as bars:
        scene = scene_of(scenario, robot=robot)
        if faults:
            with prefixed("--faults "):
                possible_faults(scene.model, faults)
        make_folder(folder)
        bars("planning", 0, 0, "")
        planner = Planner(scenario.problem())
        try:
            plan = chosen_plan(planner, options)
        except NoPlanError as error:
            return show_no_plan(options, scenario, planner, error)
        bars("planning", 1, 1, "")
        job = Sweep(
            packed=pack(scenario),
            given=options.scenario,
            which=options.plan,
            plan=plan,
            seed=options.seed,
            perturbation=perturbation,
            faults=faults,
            folder=folder,
            max_cost=options.max_cost,
            max_preference=options.max_preference,
            robot=robot,
            resimulate=options.resimulate,
            rollouts=options.rollouts,
            jobs=options.jobs,
            cluster=options.cluster,
        )
        interrupted, show = _roll_out(scenario, job, bars) if key is None else _search(scenario, job, key, bars)
    show(options)
    if interrupted:
        print("prefplan: interrupted; the same command continues it", file=sys.stderr)
        return INTERRUPTED
    return DONE


Shown = tuple[bool, Callable[[argparse.Namespace], None]]
"""Whether the work was interrupted, and what shows its result."""


def _roll_out(scenario: Scenario, job: Sweep, bars: Bars) -> Shown:
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


def _search(scenario: Scenario, job: Sweep, key: str, bars: Bars) -> Shown:
    """Search for the boundary."""
    from experiments.figures.boundary import draw
    from experiments.sweep.boundary import search_boundary, show_boundary

    result, figure = search_boundary(scenario, job, key, tell=bars), job.folder / "boundary.png"
    write_json(job.folder / "boundary.json", result)
    draw(result, figure)
    return not result["complete"], partial(_show, result, show_boundary, f"Figure: {figure}")


def _show(
    result: dict[str, Any], show: Callable[[Console, dict[str, Any]], None], where: str, options: argparse.Namespace
) -> None:
    if options.json:
        output.print_json(result)
        return
    console = Console(highlight=False)
    show(console, result)
    console.print(f"\n{where}", style="dim")


def replay(options: argparse.Namespace, scenario: Scenario, folder: Path) -> int:
    """Carry out one recorded rollout again, with a video, and return the exit status of the run."""
    from experiments.sweep.recorded import RECORDS, fingerprint

    path, wanted = folder / RECORDS, options.replay
    if not path.exists():
        raise PrefplanError(f"--replay {wanted}: {folder} holds no sweep; run the sweep first, or give its --out")
    header, records = read_journal(path, key="rollout")
    if header["scenario_sha256"] != fingerprint(scenario):
        raise PrefplanError(f"--replay {wanted}: {scenario.path} has changed since the sweep in {folder}")
    if wanted not in records:
        valid = map(str, sorted(records))
        raise PrefplanError(f"--replay {wanted}: no such rollout in {path} {choices(str(wanted), valid)}")
    record, into = records[wanted], folder / f"rollout_{wanted}"
    _, command, _, *conditions = shlex.split(record["replay"])
    look = ["--camera", options.camera, "--quality", options.quality]
    look += ["--size", "{}x{}".format(*options.size)] if options.size else []
    look += ["--inset", options.inset] if options.inset else []
    look += [f"--{name.replace('_', '-')}" for name in ("no_video", "json", "quiet") if getattr(options, name)]
    again = options.program.parse_args([command, options.scenario, *conditions, "--out", str(into), *look])
    status: int = again.command(again)
    if status not in (DONE, FAILED):
        return status
    outcome = json.loads((into / f"{plan_name(header['plan'])}.json").read_text(encoding="utf-8"))
    differing = [
        key for key in ("completed", "sim_seconds", "replans") if record.get(key, outcome[key]) != outcome[key]
    ]
    if differing:
        made = f"prefplan {header['prefplan']} and MuJoCo {header['mujoco']}"
        told = ", ".join(f"{key} {outcome[key]}, recorded {record[key]}" for key in differing)
        print(f"prefplan: rollout {wanted} differs from its record, made with {made}: {told}", file=sys.stderr)
    elif not options.json:
        print(f"rollout {wanted} ended as recorded: {'completed' if record['completed'] else record['reason']}")
    return status
