"""`prefplan sweep`: a plan carried out many times, each time with other random differences."""

from __future__ import annotations

import argparse
import hashlib
import json
import shlex
import sys
import time
from collections.abc import Iterable
from contextlib import closing
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from experiments import scenarios
from experiments.cli import output
from experiments.cli.arguments import (
    Commands,
    add_command,
    add_jobs,
    add_json,
    add_look,
    add_out,
    add_perturb,
    add_plan,
    add_robot,
    add_scenario,
    positive,
    whole,
)
from experiments.cli.choice import chosen_plan, plan_name, show_no_plan
from experiments.cli.console import Console
from experiments.cli.files import make_folder, write_json
from experiments.cli.journal import Journal, read_journal
from experiments.cli.progress import Bars
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import DONE, FAILED, INTERRUPTED
from prefplan.errors import PrefplanError
from prefplan.front import NoPlanError
from prefplan.planner import Planner
from prefplan.scenario.decode import Scenario

if TYPE_CHECKING:
    from experiments.sweep.job import Sweep


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "Carry a plan out many times with random differences, and say how often it succeeds."
    examples = (
        "prefplan sweep case_study_3 --rollouts 20",
        "prefplan sweep case_study_3 --plan preference --rollouts 200 --perturb position=8,angle=10",
        "prefplan sweep case_study_3 --replay 17 --camera wrist",
    )
    parser = add_command(commands, sweep, summary, *examples)
    add_scenario(parser)
    add_json(parser)
    parser.add_argument("--rollouts", type=positive, default=100, metavar="N", help="number of runs (default: 100)")
    add_jobs(parser)
    add_plan(parser)
    parser.add_argument("--seed", type=whole, default=0, metavar="N", help="seed of all random numbers (default: 0)")
    add_perturb(parser)
    add_robot(parser)
    parser.add_argument("--faults", choices=["random"], help="one to three random faults in each run")
    add_out(parser, "out/SCENARIO/sweep_PLAN; an interrupted sweep goes on there")
    parser.add_argument(
        "--cluster", metavar="ADDRESS", help="run on a Dask cluster, e.g. tcp://127.0.0.1:8786, not on this machine"
    )
    replay = parser.add_argument_group("replay")
    replay.add_argument(
        "--replay",
        type=whole,
        metavar="K",
        help="carry out the K-th finished rollout of the sweep in that folder again, from 0, with its recorded seed, "
        "differences, faults and robot, and render a video into DIR/rollout_K",
    )
    add_look(replay)
    parser.set_defaults(look={name: parser.get_default(name) for name in ("quality", "camera", "size")})


def sweep(options: argparse.Namespace) -> int:
    """Carry out `prefplan sweep`."""
    with loading():
        from experiments.cli.simulation_options import perturbation_of, robot_of
        from experiments.runs.carry_out import scene_of
        from experiments.sweep.job import Sweep, pack
        from experiments.sweep.summary import show_summary, summarise

    scenario = scenarios.find(options.scenario)
    folder = options.out or Path("out", scenario.name, f"sweep_{options.plan}")
    if options.replay is not None:
        return replay(options, scenario, folder)
    for name, default in options.look.items():
        if getattr(options, name) != default:
            raise PrefplanError(f"--{name}: a sweep renders no videos; it goes with --replay K")
    perturbation, robot = perturbation_of(options.perturb, seed=options.seed), robot_of(options.robot)
    tell_if_compiling(quiet=options.quiet)
    interrupted = False
    with Bars(quiet=options.quiet) as bars:
        scene_of(scenario, robot=robot)
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
            faults=options.faults == "random",
            folder=folder,
            max_cost=options.max_cost,
            max_preference=options.max_preference,
            robot=robot,
        )
        header = define(scenario, job)
        with Journal(folder / "rollouts.jsonl", header, key="rollout") as records:
            try:
                work(job, records, options, bars)
            except KeyboardInterrupt:
                interrupted = True
        # Ctrl-C may have come between writing a record and counting it: the file decides.
        with Journal(records.path, header, key="rollout") as records:
            finished = [records.done[i] for i in sorted(records.done) if i < options.rollouts]
    result = summarise(header, finished, rollouts=options.rollouts)
    write_json(folder / "summary.json", result)
    if options.json:
        output.print_json(result)
    else:
        console = Console(highlight=False)
        show_summary(console, result)
        console.print(f"\nRecords: {records.path}", style="dim")
    if interrupted:
        print("prefplan: interrupted; the same command goes on", file=sys.stderr)
        return INTERRUPTED
    return DONE


def define(scenario: Scenario, job: Sweep) -> dict[str, Any]:
    """Return everything that defines the rollouts of a sweep, except for their number."""
    return {
        "prefplan": version("prefplan"),
        "mujoco": version("mujoco"),
        "scenario": scenario.name,
        "scenario_sha256": fingerprint(scenario),
        "plan": job.which,
        "cost": job.plan.cost,
        "preference": job.plan.preference,
        "actions": list(job.plan.actions),
        "seed": job.seed,
        "perturb": str(job.perturbation),
        "robot": job.robot,
        "faults": "random" if job.faults else None,
    }


def fingerprint(scenario: Scenario) -> str:
    """Return the hash of a scenario's file."""
    return hashlib.sha256(scenario.path.read_bytes()).hexdigest()


def work(job: Sweep, records: Journal, options: argparse.Namespace, bars: Bars) -> None:
    """Carry out every rollout that has no record yet."""
    from joblib import cpu_count

    from experiments.sweep.workers import on_cluster, on_this_machine

    missing = [number for number in range(options.rollouts) if number not in records.done]
    done = options.rollouts - len(missing)
    good = sum(records.done[number]["completed"] for number in range(options.rollouts) if number in records.done)
    bars("sweeping", done, options.rollouts, "")
    if not missing:
        return
    if options.cluster:
        results = on_cluster(job, missing, address=options.cluster)
    else:
        results = on_this_machine(job, missing, jobs=options.jobs or cpu_count())
    began = time.monotonic()
    with closing(results):
        for new, record in enumerate(results, start=1):
            records.add(record)
            good += record["completed"]
            left = (time.monotonic() - began) / new * (len(missing) - new)
            rate = good / (done + new)
            bars("sweeping", done + new, options.rollouts, f"{rate:.1%} completed, {duration(left)} left")


def replay(options: argparse.Namespace, scenario: Scenario, folder: Path) -> int:
    """Carry out one recorded rollout again, with a video, and return the exit status of the run."""
    path, wanted = folder / "rollouts.jsonl", options.replay
    if not path.exists():
        raise PrefplanError(f"--replay {wanted}: {folder} holds no sweep; run the sweep first, or give its --out")
    header, records = read_journal(path, key="rollout")
    if header["scenario_sha256"] != fingerprint(scenario):
        raise PrefplanError(f"--replay {wanted}: {scenario.path} has changed since the sweep in {folder}")
    if wanted not in records:
        there = spans(records) or "none"
        raise PrefplanError(f"--replay {wanted}: no such rollout in {path}; valid: {there}")
    record, into = records[wanted], folder / f"rollout_{wanted}"
    _, command, _, *conditions = shlex.split(record["replay"])
    look = ["--camera", options.camera, "--quality", options.quality]
    look += ["--size", "{}x{}".format(*options.size)] if options.size else []
    look += ["--json"] if options.json else []
    look += ["--quiet"] if options.quiet else []
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
        print(f"prefplan: rollout {wanted} ended otherwise than recorded with {made}: {told}", file=sys.stderr)
    elif not options.json:
        print(f"rollout {wanted} ended as recorded: {'completed' if record['completed'] else record['reason']}")
    return status


def spans(numbers: Iterable[int]) -> str:
    """Return whole numbers as text, such as `0 to 5, 7`."""
    found: list[list[int]] = []
    for number in sorted(numbers):
        if found and found[-1][-1] == number - 1:
            found[-1][1:] = [number]
        else:
            found.append([number])
    return ", ".join(" to ".join(map(str, span)) for span in found)


def duration(seconds: float) -> str:
    """Return a duration as h:mm:ss."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{rest:02}"
