"""From a scenario and a plan to what came of it: the plan carried out in simulation, filmed and written down."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console

from experiments.captions import captions
from experiments.output import number, plan_json
from experiments.tally import Tally, tally
from prefplan.errors import PrefplanError, ScenarioError
from prefplan.front import Plan
from prefplan.models.manipulation import ManipulationModel
from prefplan.scenario import Scenario
from sim.errors import RenderingError, SimulationError
from sim.execution import Run
from sim.rollout import Rollout
from sim.scene import Scene, build_scene, initial_state
from sim.video import render_video

Tell = Callable[[str, int, int, str], None]
"""Called with a stage (`executing` or `rendering`), how much of it is done, how much there is, and what is next."""


@dataclass(frozen=True)
class Outcome:
    """What came of a plan.

    Attributes:
        plan: what was meant to happen.
        rollout: what happened.
        books: costs and tasks as they were observed.
        video: the film, or None.
        no_video: why there is none although one was wanted, in one sentence.
        interrupted: whether the user ended it early.
    """

    plan: Plan
    rollout: Rollout
    books: Tally
    video: Path | None = None
    no_video: str | None = None
    interrupted: bool = False

    @property
    def executed(self) -> tuple[str, ...]:
        """The actions that were carried out."""
        return tuple(step.action for step in self.rollout.steps)

    @property
    def task_costs(self) -> dict[str, Any]:
        """Each task's cost, by name."""
        return {name: self.books.task_cost(name) for name in self.plan.task_costs}


def scene_of(scenario: Scenario) -> Scene:
    """Return the scene of a scenario's manipulation model.

    Raises:
        ScenarioError: it has another kind of model, or a scene that the arm cannot work in; the message names the
            file and the key.
    """
    if not isinstance(scenario.model, ManipulationModel):
        raise ScenarioError(
            f"{scenario.path}: model.kind: only a manipulation model can be carried out; try `prefplan front` or "
            "`prefplan plan` with this scenario"
        )
    try:
        return build_scene(scenario.model)
    except SimulationError as error:
        raise ScenarioError(f"{scenario.path}: model.{error}") from None


def carry_out(
    scenario: Scenario,
    scene: Scene,
    plan: Plan,
    *,
    seed: int | None = None,
    film: Path | None = None,
    size: tuple[int, int] = (1280, 720),
    tell: Tell = lambda stage, done, total, what: None,
) -> Outcome:
    """Carry out a plan until its end, the first surprise or Ctrl-C, and film what happened.

    Args:
        scenario: what was planned.
        scene: from `scene_of`.
        plan: one of its plans.
        seed: None for nominal poses of the objects; otherwise they are perturbed by up to 5 mm and 5 degrees.
        film: file to render a video to; None for no video. It appears only when it is complete.
        size: (width, height) of the video in pixels.
        tell: told of progress.
    """
    run = Run(scene, initial_state(scene, seed=seed), system=scenario.problem().system)
    interrupted = False
    try:
        for done, action in enumerate(plan.actions):
            tell("executing", done, len(plan.actions), action)
            if not run.carry_out(action):
                break
        else:
            tell("executing", len(plan.actions), len(plan.actions), "")
    except KeyboardInterrupt:
        interrupted = True
    rollout = run.rollout()
    if interrupted:
        rollout = replace(rollout, completed=False, reason="interrupted")
    books = tally(scene.model, scenario.problem(), plan, rollout.steps)
    outcome = Outcome(plan, rollout, books, interrupted=interrupted)
    if film is None or interrupted:
        return outcome
    text = captions(scenario.tasks, rollout, books, total=plan.cost)
    try:
        render_video(
            scene, rollout, text, film, size=size, progress=lambda done, total: tell("rendering", done, total, "")
        )
    except RenderingError as error:
        return replace(outcome, no_video=str(error))
    except KeyboardInterrupt:
        return replace(outcome, interrupted=True)
    return replace(outcome, video=film)


def outcome_json(outcome: Outcome) -> dict[str, Any]:
    """Return what came of a plan as the documented JSON object."""
    rollout = outcome.rollout
    result = {
        "completed": rollout.completed,
        "plan": plan_json(outcome.plan),
        "executed": list(outcome.executed),
        "task_costs": outcome.task_costs,
        "replans": 0,
        "sim_seconds": round(rollout.sim_seconds, 3),
        "max_placement_error_mm": round(rollout.placement_error * 1000, 3),
        "video": None if outcome.video is None else str(outcome.video),
        "events": [{"time": round(event.time, 3), "kind": event.kind} | event.detail for event in rollout.events],
    }
    if rollout.reason is not None:
        result["reason"] = rollout.reason
    if outcome.interrupted:
        result["complete"] = False
    return result


def show_outcome(console: Console, scenario: Scenario, outcome: Outcome) -> None:
    """Print what came of a plan, for people."""
    plan, rollout = outcome.plan, outcome.rollout
    done = f"{len(outcome.executed)} of {len(plan.actions)} actions"
    if rollout.completed:
        console.print(f"{scenario.name}: carried out, {done}, cost {number(outcome.books.cost)}", style="bold")
    else:
        console.print(f"{scenario.name}: stopped after {done}", style="bold")
        console.print(f"  {rollout.reason}")
    for name, cost in outcome.task_costs.items():
        if name in outcome.books.satisfied[-1]:
            console.print(f"  {name} satisfied at cost {number(cost)}")
        else:
            console.print(f"  {name} not satisfied")
    console.print(f"  preference of the plan {number(plan.preference)}")
    console.print(f"  placed to within {rollout.placement_error * 1000:.1f} mm")
    factor = rollout.sim_seconds / rollout.wall_seconds
    console.print(f"  {rollout.sim_seconds:.1f} s simulated, {factor:.0f} x real time")
    if outcome.video:
        console.print(f"  video: {outcome.video}")


def make_folder(path: Path) -> None:
    """Make a folder for results.

    Raises:
        PrefplanError: it cannot be made or written to.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PrefplanError(f"{path}: cannot be made ({error.strerror})") from None
    if not os.access(path, os.W_OK | os.X_OK):
        raise PrefplanError(f"{path}: cannot be written to")


def write_json(path: Path, value: dict[str, Any]) -> None:
    """Write a JSON file that appears only when it is complete."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    draft.write_text(json.dumps(value, indent=1) + "\n", encoding="utf-8")
    os.replace(draft, path)
