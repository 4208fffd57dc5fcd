"""A scenario's plan carried out in simulation and filmed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from experiments.captions import captions
from experiments.outcome import Outcome
from experiments.tally import tally
from prefplan.errors import ScenarioError
from prefplan.front import Plan
from prefplan.models.action_costs import MeasuredCosts
from prefplan.models.manipulation import ManipulationModel
from prefplan.scenario import Scenario
from sim.errors import RenderingError, SimulationError
from sim.execution import Run
from sim.perturbation import Perturbation, perturbed
from sim.scene import Scene, build_scene, initial_state
from sim.video import render_video

Tell = Callable[[str, int, int, str], None]
"""Called with a stage (`executing` or `rendering`), how much of it is done, how much there is, and what is next."""


def scene_of(scenario: Scenario, *, robot: str = "default") -> Scene:
    """Return the scene of a scenario's manipulation model.

    Args:
        scenario: what is to be carried out.
        robot: one of `sim.robots.ROBOTS`.

    Raises:
        ScenarioError: it has another kind of model, or a scene that the arm cannot work in; the message names the
            file and the key.
        RobotError: the robot cannot be had.
    """
    if not isinstance(scenario.model, ManipulationModel):
        raise ScenarioError(
            f"{scenario.path}: model.kind: only a manipulation model can be carried out; try `prefplan front` or "
            "`prefplan plan` with this scenario"
        )
    try:
        return build_scene(scenario.model, robot=robot)
    except SimulationError as error:
        raise ScenarioError(f"{scenario.path}: model.{error}") from None


def carry_out(
    scenario: Scenario,
    scene: Scene,
    plan: Plan,
    *,
    seed: int | None = None,
    perturbation: Perturbation | None = None,
    film: Path | None = None,
    size: tuple[int, int] = (1280, 720),
    tell: Tell = lambda stage, done, total, what: None,
) -> Outcome:
    """Carry out a plan until its end, the first surprise or Ctrl-C, and film what happened.

    Args:
        scenario: what was planned.
        scene: from `scene_of`.
        plan: one of its plans.
        seed: None for the nominal world; otherwise it is perturbed at random.
        perturbation: by how much at most; None for 5 mm and 5 degrees.
        film: file to render a video to; None for no video. It appears only when it is complete.
        size: (width, height) of the video in pixels.
        tell: told of progress.
    """
    perturbation = perturbation or Perturbation()
    if seed is not None:
        scene = perturbed(scene, perturbation, seed=seed)
    start = initial_state(scene, seed=seed, position=perturbation.position, angle=perturbation.angle)
    run = Run(scene, start, system=scenario.problem().system)
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
    books = tally(scenario.problem(), plan, rollout.steps)
    costs = scene.model.costs
    quantity = costs.quantity if isinstance(costs, MeasuredCosts) else None
    outcome = Outcome(plan, rollout, books, interrupted=interrupted, quantity=quantity)
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
