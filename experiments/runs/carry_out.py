"""A scenario's plan carried out in simulation and filmed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from experiments.runs.captions import captions
from experiments.runs.outcome import Outcome
from experiments.runs.tally import tally
from prefplan.errors import ScenarioError
from prefplan.front import NoPlanError, Plan
from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.models.transition_system import TransitionSystem
from prefplan.problem import Problem
from prefplan.replanning import Past, continue_as_preferred, continue_cheaply
from prefplan.scenario.decode import Scenario
from sim.errors import RenderingError, SimulationError
from sim.execution.closed_loop import ClosedLoop, GoOn
from sim.execution.executor import Execution
from sim.execution.faults import Fault
from sim.perception.sensors import NoisySensor, Sensor
from sim.rendering.cameras import Camera
from sim.rendering.quality import DRAFT, Quality
from sim.rendering.video import render_video
from sim.world.randomization import Perturbation, perturbed
from sim.world.scene import Scene, build_scene, initial_state

Tell = Callable[[str, int, int, str], None]
"""Called with a stage (`executing` or `rendering`), how much of it is done, how much there is, and what is next."""


def scene_of(scenario: Scenario, *, robot: str = "default", faults: Sequence[Fault] = ()) -> Scene:
    """Return the scene of a scenario's manipulation model.

    Args:
        scenario: what is to be carried out.
        robot: name of one of `sim.robots.catalogue.ROBOTS`.
        faults: what shall go wrong in it.

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
        spares = sum(fault.kind == "foreign" for fault in faults)
        return build_scene(scenario.model, robot=robot, spares=spares)
    except SimulationError as error:
        raise ScenarioError(f"{scenario.path}: model.{error}") from None


def carry_out(
    scenario: Scenario,
    scene: Scene,
    plan: Plan,
    *,
    seed: int | None = None,
    perturbation: Perturbation | None = None,
    faults: Sequence[Fault] = (),
    sensor: Sensor | None = None,
    choice: str | int = "cost",
    film: Path | None = None,
    size: tuple[int, int] | None = None,
    quality: Quality = DRAFT,
    camera: Camera = "fixed",
    tell: Tell = lambda stage, done, total, what: None,
) -> Outcome:
    """Carry out a plan until its end, planning again after surprises, and film what happened.

    Args:
        scenario: what was planned.
        scene: from `scene_of`.
        plan: one of its plans.
        seed: None for the nominal world; otherwise it is perturbed at random.
        perturbation: by how much at most; None for 5 mm and 5 degrees.
        faults: what shall go wrong; the scene holds a spare object for each `foreign` among them.
        sensor: sees the objects; None for one as exact as the perturbation says.
        choice: which plan is followed after a surprise, as `--plan` says; for a number the cheapest one whose mu is
            not greater than the plan's, or if there is none the preferred one.
        film: file to render a video to; None for no video. It appears only when it is complete.
        size: (width, height) of the video in pixels; None for the quality's.
        quality: how much work its pictures are worth.
        camera: where it is seen from.
        tell: told of progress.
    """
    problem = scenario.problem()
    loop = begin(
        problem,
        scene,
        plan,
        seed=seed,
        perturbation=perturbation,
        faults=faults,
        sensor=sensor,
        choice=choice,
        tell=partial(tell, "executing"),
    )
    run, scene = loop.run, loop.run.scene
    interrupted = False
    try:
        loop.pursue()
    except KeyboardInterrupt:
        interrupted = True
    rollout = run.rollout()
    if interrupted:
        rollout = replace(rollout, completed=False, reason="interrupted")
    pursuit, plan = loop.pursuit, loop.plan
    books = tally(problem, plan, rollout.steps)
    happened = tuple((fault, run.injector.happened.get(i)) for i, fault in enumerate(faults))
    costs = scene.model.costs
    outcome = Outcome(
        plan,
        rollout,
        books,
        pursuit,
        seed=seed,
        faults=happened,
        interrupted=interrupted,
        quantity=costs.quantity if isinstance(costs, MeasuredCosts) else None,
    )
    if film is None or interrupted:
        return outcome
    text = captions(scenario.tasks, rollout, books, plan=plan)
    try:
        render_video(
            scene,
            rollout,
            text,
            film,
            size=size,
            quality=quality,
            camera=camera,
            progress=lambda done, total: tell("rendering", done, total, ""),
        )
    except RenderingError as error:
        return replace(outcome, no_video=str(error))
    except KeyboardInterrupt:
        return replace(outcome, interrupted=True)
    return replace(outcome, video=film)


def begin(
    problem: Problem,
    scene: Scene,
    plan: Plan,
    *,
    seed: int | None = None,
    perturbation: Perturbation | None = None,
    faults: Sequence[Fault] = (),
    sensor: Sensor | None = None,
    choice: str | int = "cost",
    tell: Callable[[int, int, str], None] = lambda done, total, action: None,
) -> ClosedLoop:
    """Return the pursuit of a plan before its first action.

    Args:
        problem: what was planned.
        scene: from `scene_of`.
        plan: one of the problem's plans.
        seed: what is left to chance, as in `carry_out`.
        perturbation: by how much at most, as there.
        faults: what shall go wrong.
        sensor: sees the objects, as in `carry_out`.
        choice: which plan is followed after a surprise, as there.
        tell: told before each action how many are done, how many there are, and its name.
    """
    perturbation = perturbation or Perturbation()
    if seed is not None:
        scene = perturbed(scene, perturbation, seed=seed)
    start = initial_state(scene, seed=seed, position=perturbation.position, angle=perturbation.angle)
    if sensor is None and perturbation.noise:
        sensor = NoisySensor(perturbation.noise, seed=seed or 0)
    run = Execution(scene, start, system=problem.system, sensor=sensor, faults=faults, seed=seed)
    go_on = _go_on(choice, plan, problem.measure.contract)
    return ClosedLoop(run, problem, plan, go_on=go_on, on_progress=tell)


def _go_on(choice: str | int, plan: Plan, contract: str) -> GoOn:
    """Return which plan to follow after a surprise, given which one was chosen before any.

    A `general` preference can choose under a bound on the cost only, and after a surprise there is none.
    """
    if choice == "cost" or contract == "general":
        return continue_cheaply
    if choice == "preference":
        return continue_as_preferred

    def keep_the_promise(problem: Problem, past: Past, system: TransitionSystem) -> Plan:
        try:
            return continue_cheaply(problem, past, system, max_preference=plan.preference)
        except NoPlanError as error:
            if error.reason.kind != "bound":
                raise
            return continue_as_preferred(problem, past, system)

    return keep_the_promise
