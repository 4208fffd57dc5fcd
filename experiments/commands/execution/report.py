"""`prefplan report`: the front, every plan and its film, on one page to open."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from experiments import scenarios
from experiments.cli.arguments import (
    Commands,
    add_command,
    add_limits,
    add_max_cost,
    add_scenario,
    in_bytes,
    picture_size,
    plan_numbers,
    whole,
)
from experiments.cli.files import make_folder
from experiments.cli.progress import Bars
from experiments.cli.start import loading, tell_if_compiling
from experiments.cli.status import DONE, FAILED, INTERRUPTED, no_plan
from prefplan.errors import PrefplanError
from prefplan.front import Front
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.planner import Planner


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """Add the command to the program."""
    summary = "Make a page of the front, its plans and their films."
    more = (
        "Every plan of a manipulation scenario is carried out and filmed, which takes minutes. What an earlier call\n"
        "left in the folder for the same scenario, seed and size is used again: an interrupted report goes on."
    )
    parser = add_command(
        commands,
        report,
        summary,
        "prefplan report case_study_1",
        "prefplan report case_study_3 --size 960x540 --out pages",
        more=more,
    )
    add_scenario(parser)
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the report (default: out/SCENARIO)")
    add_max_cost(parser)
    add_limits(parser, "a report of what was found by then")
    parser.add_argument(
        "--plans",
        type=plan_numbers,
        metavar="I,J,...",
        help="carry out only these plans of a manipulation scenario, by their numbers from 0 (default: all)",
    )
    parser.add_argument("--seed", type=whole, metavar="N", help="each object starts up to 5 mm and 5 degrees off")
    parser.add_argument(
        "--size", type=picture_size, default=(1280, 720), metavar="WxH", help="of the films (default: 1280x720)"
    )
    parser.add_argument("--no-video", action="store_true", help="carry plans out, but render nothing")


def report(options: argparse.Namespace) -> int:
    """Carry out `prefplan report`."""
    with loading():
        from experiments.report.page import write_page

    scenario = scenarios.find(options.scenario)
    if isinstance(scenario.model, ManipulationModel):
        # MuJoCo takes a second to load, or is not installed, and other models need none.
        with loading():
            from experiments.report.recordings import record_all
    folder = options.out or Path("out", scenario.name)
    tell_if_compiling()
    with Bars() as bars:
        bars("planning", 0, 0, "")
        front = Planner(scenario.problem()).front(
            max_cost=options.max_cost,
            max_seconds=options.max_seconds,
            max_memory=in_bytes(options.max_memory),
            keep_on_interrupt=True,
        )
        bars("planning", 1, 1, "")
        wanted = _wanted(options.plans, front)
        make_folder(folder)
        if isinstance(scenario.model, ManipulationModel) and front and front.ended != "interrupt":
            recordings, notices, interrupted = record_all(
                scenario,
                {i: front[i] for i in wanted},
                folder,
                seed=options.seed,
                size=options.size,
                video=not options.no_video,
                tell=bars,
            )
        else:
            recordings, notices, interrupted = {}, (), front.ended == "interrupt"
        page = write_page(scenario, front, recordings, folder, notices=notices)
    print(page)
    for notice in notices:
        print(f"prefplan: {notice}", file=sys.stderr)
    if interrupted:
        print("prefplan: interrupted; the same command goes on from here", file=sys.stderr)
        return INTERRUPTED
    if front.reason:
        return no_plan(front.reason)
    if front.ended:
        print(f"prefplan: {front.ending}", file=sys.stderr)
    failed = [i for i, recording in recordings.items() if not recording.outcome["completed"]]
    for i in failed:
        print(f"prefplan: execution of plan {i} failed {recordings[i].outcome.get('reason')}", file=sys.stderr)
    return FAILED if failed else DONE


def _wanted(numbers: tuple[int, ...] | None, front: Front) -> tuple[int, ...]:
    """Return which plans are to be carried out.

    Raises:
        PrefplanError: the front has no plan of such a number.
    """
    for i in numbers or ():
        if i >= len(front):
            there = "one plan, 0" if len(front) == 1 else f"plans 0 to {len(front) - 1}" if front else "no plans"
            raise PrefplanError(f"--plans {i}: the front has {there}")
    return tuple(range(len(front))) if numbers is None else numbers
