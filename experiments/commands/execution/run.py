"""`prefplan run`: a plan carried out in simulation, with a video."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import prefplan as pp
from experiments.checks.no_plan import chosen_plan
from experiments.cli import options, output
from experiments.cli.choice import Wanted
from experiments.cli.command import command
from experiments.cli.console import Console
from experiments.cli.files import only_writer, write_json
from experiments.cli.progress import Bars
from experiments.cli.start import load_planner, loading_simulation
from experiments.cli.status import DONE, FAILED, INTERRUPTED, tell
from experiments.runs.geometry import asking_in

if TYPE_CHECKING:
    from experiments.runs.outcome import Outcome
    from experiments.runs.run_plan import Conditions


@command
@options.scenario
@options.as_json
@options.which
@options.out()
@options.seed("as --perturb says")
@options.perturb
@options.fault
@options.robot
@options.no_video
@options.look
def run(
    scenario: str,
    as_json: bool,
    wanted: Wanted,
    out: Path | None,
    seed: int | None,
    perturb: str | None,
    faults: Sequence[str],
    robot: str | None,
    no_video: bool,
    look: options.LookOptions,
) -> int:
    """Carry a plan out in simulation and render a video of it.

    Examples:
      prefplan run case_study_3 --plan preference
      prefplan run case_study_3 --plan 0 --seed 7 --no-video --json
    """
    with loading_simulation():
        from experiments.cli import simulation_options as simulation
        from experiments.runs.evidence import prove
        from experiments.runs.outcome import outcome_json
        from experiments.runs.run_plan import run_plan, scene_of

    load_planner()
    loaded = pp.load(scenario)
    path = (out or Path("out", loaded.name)) / (wanted.plan if isinstance(wanted.plan, str) else f"plan_{wanted.plan}")
    conditions: Conditions = {
        "seed": seed,
        "perturbation": simulation.perturbation_of(perturb, seed=seed),
        "faults": simulation.faults_of(faults, loaded),
        "choice": wanted.continuation,
    }
    scene = scene_of(loaded, robot=robot, faults=conditions["faults"])
    view = simulation.look_of(scene, look)
    loaded = asking_in(loaded, scene, robot=robot)
    with Bars() as bars, only_writer(path.parent):
        bars("planning", 0, 0, "")
        chosen = chosen_plan(loaded, pp.Planner(loaded.problem()), wanted, as_json=as_json)
        bars("planning", 1, 1, "")
        video = None if no_video else path.with_suffix(".mp4")
        outcome = run_plan(loaded, scene, chosen, video=video, tell=bars, **view, **conditions)
        bars("checking", 0, 0, "the log")
        outcome = prove(outcome, path.with_suffix(".npz"))
        write_json(path.with_suffix(".json"), outcome_json(outcome))
    return _ended(outcome, as_json=as_json)


def _ended(outcome: Outcome, *, as_json: bool) -> int:
    """Print an outcome and return the exit status; stderr has the faults that did not happen, and why a run failed."""
    from experiments.runs.outcome import NEWS, outcome_json, show_outcome

    if as_json:
        output.print_json(outcome_json(outcome))
    else:
        show_outcome(Console(), outcome)
    for event in outcome.run.events:
        if event.kind == "not injected":
            tell(NEWS[event.kind].format(**event.detail))
    if outcome.no_video:
        tell(f"no video: {outcome.no_video}")
    if outcome.interrupted:
        tell("interrupted")
        return INTERRUPTED
    if outcome.completed:
        return DONE
    if as_json:
        tell(f"execution failed {outcome.reason}")
    return FAILED
