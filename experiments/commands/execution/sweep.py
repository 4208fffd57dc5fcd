"""`prefplan sweep`: a plan carried out many times, each time with other random differences."""

from __future__ import annotations

import argparse
import hashlib
import sys
import time
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
    add_out,
    add_perturb,
    add_plan,
    add_robot,
    add_scenario,
    positive,
    whole,
)
from experiments.cli.choice import chosen_plan, show_no_plan
from experiments.cli.console import Console
from experiments.cli.files import make_folder, write_json
from experiments.cli.journal import Journal
from experiments.cli.progress import Bars
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import DONE, INTERRUPTED
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
    parser.add_argument("--resimulate", action="store_true", help="simulate each run again from its log, as a check")
    add_out(parser, "out/SCENARIO/sweep_PLAN; an interrupted sweep goes on there")
    parser.add_argument(
        "--cluster", metavar="ADDRESS", help="run on a Dask cluster, e.g. tcp://127.0.0.1:8786, not on this machine"
    )


def sweep(options: argparse.Namespace) -> int:
    """Carry out `prefplan sweep`."""
    with loading():
        from experiments.cli.simulation_options import perturbation_of, robot_of
        from experiments.runs.carry_out import scene_of
        from experiments.sweep.job import Sweep, pack
        from experiments.sweep.summary import show_summary, summarise

    scenario = scenarios.find(options.scenario)
    perturbation, robot = perturbation_of(options.perturb, seed=options.seed), robot_of(options.robot)
    folder = options.out or Path("out", scenario.name, f"sweep_{options.plan}")
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
            resimulate=options.resimulate,
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
        "scenario_sha256": hashlib.sha256(scenario.path.read_bytes()).hexdigest(),
        "plan": job.which,
        "cost": job.plan.cost,
        "preference": job.plan.preference,
        "actions": list(job.plan.actions),
        "seed": job.seed,
        "perturb": str(job.perturbation),
        "robot": job.robot,
        "faults": "random" if job.faults else None,
    }


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


def duration(seconds: float) -> str:
    """Return a duration as h:mm:ss."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{rest:02}"
