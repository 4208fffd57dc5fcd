"""Carry out a plan in simulation, plan again after a mismatch, and render a video of the run."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypedDict, Unpack

from experiments.cli.progress import Tell
from experiments.cli.status import tell
from experiments.runs.outcome import Outcome
from prefplan import ManipulationModel, NoPlanError, Plan, Problem, Scenario, ScenarioError
from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.models.system import System
from prefplan.replanning import Past, continue_as_preferred, continue_cheaply
from sim.errors import RenderingError, SimulationError
from sim.execution.closed_loop import ClosedLoop, GoOn
from sim.execution.executor import Execution
from sim.execution.faults.fault import Fault, spares_for
from sim.perception.sensors import NoisySensor
from sim.rendering.quality import DRAFT, Look, Quality
from sim.simulation.run import ledger_of
from sim.world.randomization import NONE, Perturbation, drawn
from sim.world.scene import Scene, build_scene


class Conditions(TypedDict, total=False):
    """Conditions under which a plan is carried out; all are optional.

    Attributes:
        seed: of all random numbers; None for the nominal scene.
        perturbation: greatest random changes of the scene, drawn with the seed; None for 5 mm and 5 degrees.
        faults: faults to inject; the scene must hold the spare objects that they need.
        choice: the plan to follow after a mismatch: `cost` (default) or `preference`; `bounded` and a number stand for
            the cheapest plan whose mu is not greater than the first plan's, or the preferred one if there is none.
    """

    seed: int | None
    perturbation: Perturbation | None
    faults: Sequence[Fault]
    choice: str | int


def scene_of(
    scenario: Scenario, *, robot: str | None = None, faults: Sequence[Fault] = (), any_costs: bool = False
) -> Scene:
    """Return the scene of a scenario's manipulation model.

    It has the spare objects that faults need. The robot is one of `sim.robots.catalogue.ROBOTS`, or the scenario's.
    `any_costs` allows several costs and preferences, for commands that carry out no plan.

    Raises:
        ScenarioError: the scenario has another kind of model, several costs or preferences, or a scene in which the arm
            cannot work; the message names the file and the key.
        RobotError: the robot is not available.
    """
    if not isinstance(scenario.model, ManipulationModel):
        raise ScenarioError(
            f"{scenario.path}: model.kind: only a manipulation model can be carried out; try `prefplan front` or "
            "`prefplan plan` with this scenario"
        )
    if not any_costs and (len(scenario.model.cost_names) > 1 or len(scenario.preferences or (None,)) != 1):
        raise ScenarioError(
            f"{scenario.path}: only plans of one cost and one preference are carried out; try `prefplan front` or "
            "`prefplan plan` with this scenario"
        )
    try:
        scene = build_scene(scenario.model, robot=robot, spares=spares_for(faults))
    except SimulationError as error:
        raise ScenarioError(f"{scenario.path}: " + "; ".join(f"model.{fault}" for fault in error.faults)) from None
    for warning in scene.warnings:
        tell(f"warning: {scenario.path}: model.{warning}")
    if robot is not None and isinstance(scenario.model.costs, MeasuredCosts) and not any_costs:
        if (own := scenario.model.robot_setup.source) != robot:
            tell(f"warning: {scenario.path}: model.costs.measured: costs are predicted for {own}, not for {robot}")
    return scene


def run_plan(
    scenario: Scenario,
    scene: Scene,
    plan: Plan,
    *,
    video: Path | None = None,
    quality: Quality = DRAFT,
    camera: str = "fixed",
    captioned: bool = True,
    tell: Tell = lambda stage, done, total, what: None,
    **conditions: Unpack[Conditions],
) -> Outcome:
    """Carry out a plan to its end, planning again after a mismatch, and render a video of the run.

    The scene is one from `scene_of`, the plan one of the scenario's. The file of a video appears only when it is
    complete; its camera is as for `sim.rendering.cameras.Camera`.
    """
    problem = scenario.problem()

    def acting(done: int, total: int, action: str) -> None:
        tell("carrying out", done, total, problem.display.action(action))

    loop = begin(problem, scene, plan, tell=acting, **conditions)
    # After a mismatch the model may have more locations; the video shows those of the first model.
    scene, interrupted = loop.execution.scene, False
    try:
        loop.run()
    except KeyboardInterrupt:
        interrupted = True
    run, happened = loop.record(), loop.execution.injector.happened
    seed, faults = conditions.get("seed"), conditions.get("faults", ())
    perturbation = conditions.get("perturbation") or Perturbation()
    # Without a seed, only the sensor differs from the nominal world.
    applied = perturbation if seed is not None else replace(NONE, noise=perturbation.noise)
    differs = seed is not None or applied != NONE
    setting: dict[str, object] = {"seed": seed, "perturbation": str(applied) if differs else None}
    outcome = Outcome(
        scenario,
        scene,
        loop.plan,
        replace(run, reason="interrupted") if interrupted else run,
        ledger_of(problem, loop.plan, run.steps),
        setting=setting | ({"faults": [str(fault) for fault in faults]} if faults else {}),
        faults=tuple((fault, happened.get(i)) for i, fault in enumerate(faults)),
        interrupted=interrupted,
    )
    if video is None or interrupted:
        return outcome
    return _filmed(outcome, video, captioned=captioned, tell=tell, quality=quality, camera=camera)


def _filmed(outcome: Outcome, video: Path, *, captioned: bool, tell: Tell, **look: Unpack[Look]) -> Outcome:
    """Render a video of an outcome, and return the outcome with its file, or with why there is none."""
    from experiments.runs.captions import captions  # both are loaded when there is a video
    from sim.rendering.video import render_video

    told = captions(outcome) if captioned else ()

    def progress(done: int, total: int) -> None:
        tell("rendering", done, total, "")

    try:
        render_video(outcome.scene, outcome.run, told, video, progress=progress, **look)
    except RenderingError as error:
        return replace(outcome, no_video=str(error))
    except KeyboardInterrupt:
        return replace(outcome, interrupted=True)
    return replace(outcome, video=video)


def begin(
    problem: Problem,
    scene: Scene,
    plan: Plan,
    *,
    tell: Callable[[int, int, str], None] = lambda done, total, action: None,
    **conditions: Unpack[Conditions],
) -> ClosedLoop:
    """Return the closed loop of a plan before its first action.

    The arguments are those of `run_plan`; `tell` is called before each action with the number of actions done, that of
    all actions, and its name.
    """
    seed, perturbation = conditions.get("seed"), conditions.get("perturbation") or Perturbation()
    scene, start, bias = drawn(scene, perturbation, seed=seed)
    is_exact = not (perturbation.noise or bias.any())
    sensor = None if is_exact else NoisySensor(perturbation.noise, seed=seed or 0, bias=bias)
    run = Execution(scene, start, system=problem.system, sensor=sensor, faults=conditions.get("faults", ()), seed=seed)
    go_on = _go_on(conditions.get("choice", "cost"), plan, problem.measure.contract)
    return ClosedLoop(run, problem, plan, go_on=go_on, on_progress=tell)


def _go_on(choice: str | int, plan: Plan, contract: str) -> GoOn:
    """Return how to plan after a mismatch, given the choice of the first plan.

    Preferred plans under a `general` preference need a bound on the cost, and after a mismatch there is none.
    """
    if choice == "cost" or contract == "general":
        return continue_cheaply
    if choice == "preference":
        return continue_as_preferred

    def keep_preference(problem: Problem, past: Past, system: System) -> Plan:
        try:
            return continue_cheaply(problem, past, system, max_preference=plan.preference)
        except NoPlanError as error:
            if error.reason.kind != "bound":
                raise
            return continue_as_preferred(problem, past, system)

    return keep_preference
