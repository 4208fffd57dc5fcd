"""`prefplan report`: the front, every plan and its video, on one page."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import prefplan as pp
from experiments.checks.no_plan import no_plan
from experiments.cli import options
from experiments.cli.choice import bounds_of, check_arm_options, plan_at
from experiments.cli.command import command
from experiments.cli.files import only_writer
from experiments.cli.progress import Bars
from experiments.cli.start import load_planner, loading_simulation
from experiments.cli.status import DONE, FAILED, INTERRUPTED, say, tell
from experiments.cli.values import plan_numbers

if TYPE_CHECKING:
    from experiments.report.recordings import Recorded
    from prefplan.limits import Limits


@command
@options.scenario
@options.out()
@options.max_cost
@options.at_most
@options.limits("a report of the front so far")
@click.option(
    "--plans",
    type=plan_numbers,
    metavar="I,J,...",
    help="Carry out only these plans of a manipulation scenario, by index from 0 (default: all).",
)
@options.seed()
@options.robot
@options.no_video
@options.look
def report(
    scenario: str,
    out: Path | None,
    max_cost: Decimal | None,
    at_most: dict[str, Decimal],
    limits: Limits,
    plans: tuple[int, ...] | None,
    seed: int | None,
    robot: str | None,
    no_video: bool,
    look: options.LookOptions,
) -> int:
    """Make a page of the front, its plans and their videos.

    Examples:
      prefplan report case_study_1
      prefplan report case_study_3 --size 960x540 --out pages

    Every plan of a manipulation scenario is carried out, which takes minutes. Results of an earlier call with the same
    options in the same folder are reused, so that an interrupted report continues.
    """
    from experiments.report.page import write_page

    load_planner()
    with limits:
        loaded = pp.load(scenario)
    check_arm_options(loaded)
    arm = isinstance(loaded.model, pp.ManipulationModel)
    if arm:  # MuJoCo takes a second to load, and may not be installed
        with loading_simulation():
            from experiments.cli.simulation_options import look_of
            from experiments.report.recordings import record_all
            from experiments.runs.geometry import asking_in
            from experiments.runs.run_plan import scene_of

        with limits:
            scene = scene_of(loaded, robot=robot)
        loaded = asking_in(loaded, scene, robot=robot)
        view = look_of(scene, look)
    folder = out or Path("out", loaded.name)
    with Bars() as bars:
        bars("planning", 0, 0, "")
        with limits:
            planner = pp.Planner(loaded.problem())
            bounds = bounds_of(planner.problem, at_most)
            front = planner.front(max_cost=max_cost, at_most=bounds, keep_on_interrupt=True)
        bars("planning", 1, 1, "")
        chosen = {i: plan_at(front, i, "--plans") for i in (range(len(front)) if plans is None else plans)}
        recorded: Recorded = {}, (), front.ended == "interrupt"
        with only_writer(folder):
            if arm and front and front.ended != "interrupt":
                recorded = record_all(loaded, scene, chosen, folder, seed=seed, video=not no_video, tell=bars, **view)
            recordings, notices, interrupted = recorded
            if planner.geometry is not None and (left_out := planner.geometry.note):
                notices = (left_out, *notices)
            bars("page", 0, 0, "")
            page = write_page(loaded, front, recordings, folder, notices=notices)
    say(page)
    for notice in notices:
        tell(notice)
    return _status(planner, front, {i: recording.outcome for i, recording in recordings.items()}, interrupted)


def _status(planner: pp.Planner, front: pp.Front, outcomes: Mapping[int, Mapping[str, Any]], interrupted: bool) -> int:
    """Say what is wrong with a front, or with the runs of its plans, given their JSON, and return the exit status."""
    if interrupted:
        tell("interrupted; the same command continues from here")
        return INTERRUPTED
    if front.reason:
        return no_plan(front.reason, planner)
    if front.ended:
        tell(front.ending)
    failed = {i: outcome for i, outcome in outcomes.items() if not outcome["completed"]}
    for i, outcome in failed.items():
        tell(f"execution of plan {i} failed {outcome.get('reason')}")
    return FAILED if failed else DONE
