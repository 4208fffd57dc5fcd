"""`prefplan report`: the front, every plan and its video, on one page."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path

from experiments.cli.arguments import Commands, add_command, plan_numbers
from experiments.cli.choice import plan_at
from experiments.cli.files import make_folder
from experiments.cli.options import LIMITS, VIDEO, add_options, limits_of
from experiments.cli.progress import Bars
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import DONE, FAILED, INTERRUPTED, no_plan
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.planner import Planner
from prefplan.scenario.decode import load


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    more = (
        "Every plan of a manipulation scenario is carried out, which takes minutes. Results of an earlier call with "
        "the same options in the same folder are reused, so that an interrupted report continues."
    )
    parser = add_command(
        commands,
        report,
        "prefplan report case_study_1",
        "prefplan report case_study_3 --size 960x540 --out pages",
        more=more,
    )
    add_options(parser, "scenario", "--out", "--max-cost", *LIMITS, found="a report of the front so far")
    parser.add_argument(
        "--plans",
        type=plan_numbers,
        metavar="I,J,...",
        help="carry out only these plans of a manipulation scenario, by index from 0 (default: all)",
    )
    add_options(parser, "--seed", "--robot", *VIDEO)


def report(options: argparse.Namespace) -> int:
    """Make a page of the front, its plans and their videos."""
    with loading():
        from experiments.report.page import write_page

    limits = limits_of(options)
    with limits:
        scenario = load(options.scenario)
    if isinstance(scenario.model, ManipulationModel):
        # Other models need no MuJoCo, which takes a second to load and may not be installed.
        with loading():
            from experiments.cli.simulation_options import look_of, robot_of
            from experiments.report.recordings import record_all
            from experiments.runs.carry_out import scene_of

        robot = robot_of(options.robot)
        look = look_of(options, partial(scene_of, scenario, robot=robot))
    folder = options.out or Path("out", scenario.name)
    tell_if_compiling(quiet=options.quiet)
    with Bars(quiet=options.quiet) as bars:
        bars("planning", 0, 0, "")
        with limits:
            front = Planner(scenario.problem()).front(max_cost=options.max_cost, keep_on_interrupt=True)
        bars("planning", 1, 1, "")
        indices = range(len(front)) if options.plans is None else options.plans
        plans = {i: plan_at(front, i, "--plans") for i in indices}
        make_folder(folder)
        if isinstance(scenario.model, ManipulationModel) and front and front.ended != "interrupt":
            recordings, notices, interrupted = record_all(
                scenario,
                plans,
                folder,
                seed=options.seed,
                robot=robot,
                video=not options.no_video,
                tell=bars,
                **look,
            )
        else:
            recordings, notices, interrupted = {}, (), front.ended == "interrupt"
        bars("page", 0, 0, "")
        page = write_page(scenario, front, recordings, folder, notices=notices)
    print(page)
    for notice in notices:
        print(f"prefplan: {notice}", file=sys.stderr)
    if interrupted:
        print("prefplan: interrupted; the same command continues from here", file=sys.stderr)
        return INTERRUPTED
    if front.reason:
        return no_plan(front.reason, scenario.problem())
    if front.ended:
        print(f"prefplan: {front.ending}", file=sys.stderr)
    failed = [i for i, recording in recordings.items() if not recording.outcome["completed"]]
    for i in failed:
        print(f"prefplan: execution of plan {i} failed {recordings[i].outcome.get('reason')}", file=sys.stderr)
    return FAILED if failed else DONE
