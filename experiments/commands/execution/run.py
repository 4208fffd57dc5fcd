"""`prefplan run`: a plan carried out in simulation, with a video."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from experiments.cli import output
from experiments.cli.arguments import Commands, add_command, number
from experiments.cli.choice import chosen_plan, continuation, plan_name, show_no_plan
from experiments.cli.console import Console
from experiments.cli.files import make_folder, write_json
from experiments.cli.options import PLAN, VIDEO, add_options
from experiments.cli.progress import Bars
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import DONE, FAILED, INTERRUPTED
from prefplan.front import NoPlanError
from prefplan.planner import Planner
from prefplan.scenario.decode import Scenario, load

if TYPE_CHECKING:
    from experiments.runs.outcome import Outcome


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    examples = (
        "prefplan run case_study_3 --plan preference",
        "prefplan run case_study_3 --plan 0 --seed 7 --no-video --json",
        "prefplan run case_study_3 --no-video --key private.pem",
    )
    parser = add_command(commands, run, *examples)
    add_options(
        parser, "scenario", "--json", *PLAN, "--out", "--seed", "--perturb", "--fault", starts="as --perturb says"
    )
    parser.add_argument("--noise", type=number, metavar="MM", help="random error of sensed object positions, mm")
    add_options(parser, "--robot", *VIDEO)
    parser.add_argument("--key", type=Path, metavar="FILE", help="sign the log with this private Ed25519 key")


def run(options: argparse.Namespace) -> int:
    """Carry a plan out in simulation and render a video of it."""
    # MuJoCo takes a second to load.
    with loading():
        from experiments.runs.outcome import no_outcome_json, outcome_json, show_outcome

    scenario = load(options.scenario)
    planner = Planner(scenario.problem())
    name = plan_name(options.plan)
    folder = options.out or Path("out", scenario.name)
    try:
        outcome = _simulate(options, scenario, planner, folder, name)
    except NoPlanError as error:
        return show_no_plan(options, scenario, planner, error)
    except KeyboardInterrupt:
        if options.json:
            output.print_json(no_outcome_json())
        raise
    write_json(folder / f"{name}.json", outcome_json(outcome))
    if options.json:
        output.print_json(outcome_json(outcome))
    else:
        show_outcome(Console(highlight=False), scenario, outcome)
    return _status(options, outcome)


def _simulate(options: argparse.Namespace, scenario: Scenario, planner: Planner, folder: Path, name: str) -> Outcome:
    """Plan, carry the plan out, and write its video and log into a folder."""
    with loading():
        from experiments.cli import simulation_options as simulation
        from experiments.runs.carry_out import carry_out, scene_of
        from experiments.runs.evidence import prove
        from sim.evidence.signature import read_private_key

    key = read_private_key(options.key) if options.key else None
    perturbation = simulation.perturbation_of(options.perturb, seed=options.seed)
    faults = simulation.faults_of(options.fault, scenario)
    robot = simulation.robot_of(options.robot)
    look = simulation.look_of(options, partial(scene_of, scenario, robot=robot))
    tell_if_compiling(quiet=options.quiet)
    with Bars(quiet=options.quiet) as bars:
        scene = scene_of(scenario, robot=robot, faults=faults)
        make_folder(folder)
        bars("planning", 0, 0, "")
        plan = chosen_plan(planner, options)
        bars("planning", 1, 1, "")
        outcome = carry_out(
            scenario,
            scene,
            plan,
            seed=options.seed,
            perturbation=perturbation,
            faults=faults,
            sensor=simulation.sensor_of(options.noise, seed=options.seed),
            choice=continuation(options.plan, options.max_preference),
            video=None if options.no_video else folder / f"{name}.mp4",
            tell=bars,
            **look,
        )
        if options.noise:
            outcome = replace(outcome, setting=outcome.setting | {"noise_mm": float(options.noise)})
        bars("checking", 0, 0, "the log")
        return prove(scenario, scene, outcome, folder / f"{name}.npz", key=key)


def _status(options: argparse.Namespace, outcome: Outcome) -> int:
    """Return the exit status; say on stderr which faults did not happen, why there is no video, and why it is not 0."""
    from experiments.runs.outcome import NEWS

    for event in outcome.rollout.events:
        if event.kind == "not injected":
            print(f"prefplan: {NEWS[event.kind].format(**event.detail)}", file=sys.stderr)
    if outcome.no_video:
        print(f"prefplan: no video: {outcome.no_video}", file=sys.stderr)
    if outcome.interrupted:
        print("prefplan: interrupted", file=sys.stderr)
        return INTERRUPTED
    if outcome.completed:
        return DONE
    if options.json:
        print(f"prefplan: execution failed {outcome.reason}", file=sys.stderr)
    return FAILED
