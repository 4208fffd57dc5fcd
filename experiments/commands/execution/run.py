"""`prefplan run`: a plan carried out in simulation and filmed."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from experiments import scenarios
from experiments.cli import output
from experiments.cli.arguments import (
    Commands,
    add_command,
    add_fault,
    add_film,
    add_json,
    add_max_cost,
    add_perturb,
    add_plan,
    add_robot,
    add_scenario,
    number,
    whole,
)
from experiments.cli.console import Console
from experiments.cli.files import make_folder, write_json
from experiments.cli.progress import Bars
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import DONE, FAILED, INTERRUPTED, no_plan
from prefplan.errors import PrefplanError
from prefplan.exact_costs import Number
from prefplan.front import Front, NoPlanError, Plan
from prefplan.planner import Planner


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "Carry a plan out in simulation and film it."
    examples = (
        "prefplan run case_study_3 --plan preference",
        "prefplan run case_study_3 --plan 0 --seed 7 --no-video --json",
    )
    parser = add_command(commands, run, summary, *examples)
    add_scenario(parser)
    add_json(parser)
    add_plan(parser)
    add_max_cost(parser)
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for the results (default: out/SCENARIO)")
    parser.add_argument(
        "--seed", type=whole, metavar="N", help="start otherwise than nominal, each object moved as --perturb says"
    )
    add_perturb(parser)
    add_fault(parser)
    parser.add_argument("--noise", type=number, metavar="MM", help="see objects with a random error of this size, mm")
    add_robot(parser)
    add_film(parser)


def run(options: argparse.Namespace) -> int:
    """Carry out `prefplan run`."""
    # MuJoCo takes a second to load, which the other commands are spared.
    with loading():
        from experiments.cli.perturb import faults_of, perturbation_of, sensor_of
        from experiments.runs.carry_out import carry_out, scene_of
        from experiments.runs.evidence import prove
        from experiments.runs.outcome import no_outcome_json, outcome_json, show_outcome
        from sim.rendering.quality import QUALITIES

    scenario = scenarios.find(options.scenario)
    perturbation = perturbation_of(options.perturb, seed=options.seed)
    faults = faults_of(options.fault, scenario)
    folder = options.out or Path("out", scenario.name)
    name = options.plan if isinstance(options.plan, str) else f"plan_{options.plan}"
    tell_if_compiling()
    try:
        with Bars() as bars:
            scene = scene_of(scenario, robot=options.robot, faults=faults)
            make_folder(folder)
            bars("planning", 0, 0, "")
            planner = Planner(scenario.problem())
            chosen = choose(planner, options.plan, max_cost=options.max_cost)
            bars("planning", 1, 1, "")
            video = None if options.no_video else folder / f"{name}.mp4"
            outcome = carry_out(
                scenario,
                scene,
                chosen,
                seed=options.seed,
                perturbation=perturbation,
                faults=faults,
                sensor=sensor_of(options.noise, seed=options.seed),
                choice=options.plan,
                video=video,
                quality=QUALITIES[options.quality],
                camera=options.camera,
                tell=bars,
            )
            drawn = None if options.seed is None else str(perturbation)
            setting: dict[str, object] = {"seed": options.seed, "perturbation": drawn}
            if faults:
                setting["faults"] = [str(fault) for fault in faults]
            if options.noise:
                setting["noise_mm"] = float(options.noise)
            outcome = prove(scenario, scene, outcome, folder / f"{name}.npz", setting=setting)
    except NoPlanError as error:
        if options.json:
            output.print_json(output.front_json(scenario, Front((), reason=error.reason, stats=planner.stats)))
        return no_plan(error.reason)
    except KeyboardInterrupt:
        if options.json:
            output.print_json(no_outcome_json())
        raise
    write_json(folder / f"{name}.json", outcome_json(outcome))
    if options.json:
        output.print_json(outcome_json(outcome))
    else:
        show_outcome(Console(highlight=False), scenario, outcome)
    if outcome.no_video:
        print(f"prefplan: no video: {outcome.no_video}", file=sys.stderr)
    if outcome.interrupted:
        print("prefplan: interrupted", file=sys.stderr)
        return INTERRUPTED
    if not outcome.rollout.completed:
        if options.json:
            print(f"prefplan: execution failed {outcome.rollout.reason}", file=sys.stderr)
        return FAILED
    return DONE


def choose(planner: Planner, wanted: str | int, *, max_cost: Number | None = None) -> Plan:
    """Return the plan that `--plan` names, among those of at most some cost.

    Raises:
        NoPlanError: there is none at all.
        PreferenceError: a bound on the cost is needed.
        PrefplanError: the front has no plan of that number.
    """
    if wanted == "cost":
        return planner.cheapest(max_cost=max_cost)
    if wanted == "preference":
        return planner.preferred(max_cost=max_cost)
    found = planner.front(max_cost=max_cost)
    if found.reason:
        raise NoPlanError(found.reason)
    if int(wanted) >= len(found):
        there = "one plan, 0" if len(found) == 1 else f"plans 0 to {len(found) - 1}"
        raise PrefplanError(f"--plan {wanted}: the front has {there}")
    return found[int(wanted)]
