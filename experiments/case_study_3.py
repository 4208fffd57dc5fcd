"""Case Study 3 of the paper: a Panda sanitizes and bins two blocks of an arch, once cheaply and once as preferred.

Prints the Pareto front, carries out the plans at both its ends in simulation, renders videos of them, also side by
side, and writes a report page.
"""

import sys
from pathlib import Path

from experiments.cli import output
from experiments.cli.console import Console
from experiments.cli.files import make_folder
from experiments.cli.progress import Bars
from experiments.cli.status import DONE, FAILED, INTERRUPTED
from experiments.paper.arm import ABOUT, TITLE, compare_plans
from experiments.paper.study import Study
from experiments.report.page import write_page
from experiments.report.recordings import keep
from experiments.runs.outcome import show_outcome
from experiments.runs.run_plan import run_plan, scene_of
from prefplan import load, pareto_front
from prefplan.text.layout import number
from sim.rendering.clips import compose

SCENARIO = "case_study_3"

OUT = Path("out", SCENARIO)
"""Where the videos and the report go, unless said otherwise."""


def main(out: Path = OUT) -> int:
    """Plan, carry both plans out with videos and a report in a folder, and return the exit status."""
    console = Console()
    scenario = load(SCENARIO)
    front = pareto_front(scenario.problem())
    output.show_front(console, scenario, front, lambda i: f"`prefplan plan {SCENARIO} --plan {i}` prints all")
    console.print()
    study = Study(TITLE, ABOUT)
    compare_plans(study, scenario, front)
    study.show(console)
    scene = scene_of(scenario)
    make_folder(out)
    outcomes, recordings = [], {}
    for name, index in {"cost": 0, "preference": len(front) - 1}.items():
        plan = front[index]
        console.print(f"\nCarrying out the {name}-optimal plan (cost {number(plan.cost)})")
        with Bars() as bars:
            outcome = run_plan(scenario, scene, plan, video=out / f"{name}.mp4", tell=bars)
            if not outcome.interrupted:
                bars("checking", 0, 0, "the log")
                recordings[index] = keep(plan, outcome, out / name)
        show_outcome(console, outcome)
        if outcome.interrupted:
            return INTERRUPTED
        outcomes.append(outcome)
    console.print("\nVideos")
    for outcome in outcomes:
        console.print(f"  {outcome.video or outcome.no_video}")
    videos = [outcome.video for outcome in outcomes if outcome.video]
    if len(videos) == len(outcomes):
        headings = [
            f"{what}: cost {number(outcome.plan.cost)}, penalty {number(outcome.plan.preference)}"
            for what, outcome in zip(("cheapest", "preferred"), outcomes, strict=True)
        ]
        console.print(f"  {compose(videos, out / 'both.mp4', headings=headings)}")
    page = write_page(scenario, front, recordings, out)
    console.print(f"\nReport (open it in a browser)\n  {page}")
    return DONE if all(outcome.run.completed for outcome in outcomes) else FAILED


if __name__ == "__main__":
    sys.exit(main())
