"""The scene of a logged run, built again from the log's setting and a scenario: the log's own or a given one."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import mujoco
import numpy as np

from prefplan.errors import PrefplanError
from prefplan.models.manipulation.action_costs import MeasuredCosts
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import Scenario, loads
from sim.errors import LogError, RobotError
from sim.evidence.log import About, Log
from sim.external.bundle import unpacked
from sim.robots.catalogue import robot_for
from sim.simulation.recorder import STATE
from sim.world.randomization import NONE, Perturbation, drawn, read_perturbation
from sim.world.scene import Scene, build_scene

MAX_UNKNOWN_OBJECTS = 20
"""Greatest number of objects that are not in the scenario."""

SETTING = {"seed": int, "perturbation": str, "faults": list, "interrupted": bool}
"""Keys of the setting of a run, and the type of each value."""


@contextmanager
def refusing(words: str) -> Iterator[None]:
    """Turn errors in the contents of a log into a `LogError` that begins with some words."""
    try:
        yield
    except LogError:
        raise
    except (PrefplanError, TypeError, ValueError, OverflowError) as error:
        raise LogError(f"{words}: {error}") from None


def described(about: About) -> Scenario:
    """Return the scenario that a log describes, with its files and measured costs.

    Raises:
        LogError: it cannot be used.
    """
    with refusing("the scenario in the log cannot be used"):
        scenario = loads(about.text, name=about.scenario, measured=False)
        if not isinstance(scenario.model, ManipulationModel):
            raise LogError("the scenario in the log cannot be used: it has no manipulation model")
        model = unpacked(scenario.model, about.files)
        if isinstance(model.costs, MeasuredCosts):
            entries = {(kind, hand, goal): cost for kind, hand, goal, cost in about.measured}
            model = replace(model, costs=replace(model.costs, entries=entries))
        return replace(scenario, model=model)


def built(scenario: Scenario, about: About) -> Scene:
    """Return the scene of a log in a scenario.

    Joints that are neither the robot's nor an object's belong to objects that faults added.
    """
    model = scenario.model
    if not isinstance(model, ManipulationModel):
        raise LogError("nothing can be carried out in the given scenario: it has no manipulation model")
    try:
        robot = robot_for(model.robot_setup)
        other = None if robot.name == about.robot else about.robot
        robot = robot_for(model.robot_setup, other)
    except RobotError as error:
        raise LogError(f"the log cannot be checked: {error}") from None
    objects = len(about.joints) - len(robot.joints + robot.gripper.joints)
    spares = min(max(0, objects - len(model.objects)), MAX_UNKNOWN_OBJECTS)
    with refusing("the scenario in the log cannot be used"):
        return build_scene(model, robot=other, spares=spares)


def perturbed_as_said(scene: Scene, about: About) -> tuple[Scene, np.ndarray, float, np.ndarray]:
    """Return a scene perturbed as the setting of a run says, the (nq,) positions at its start, noise and bias, m."""
    for key, value in about.setting.items():
        if value is not None and (key not in SETTING or type(value) is not SETTING[key]):
            raise LogError(f"the setting in the log cannot be used: {key} {value!r}")
    seed, text = about.setting.get("seed"), about.setting.get("perturbation")
    with refusing("the setting in the log cannot be used"):
        perturbation = Perturbation() if text is None else read_perturbation(text)
        if seed is None and text is not None and perturbation != replace(NONE, noise=perturbation.noise):
            raise LogError(f"the setting in the log cannot be used: without a seed, nothing is perturbed by {text}")
        scene, start, bias = drawn(scene, perturbation, seed=seed)
    return scene, start.qpos, perturbation.noise, bias


def require_fitting(log: Log, scene: Scene) -> None:
    """Raise LogError unless the arrays of a log are those of a scene."""
    model = scene.mujoco
    joints = {model.joint(i).name: int(model.joint(i).qposadr[0]) for i in range(model.njnt)}
    if log.about.joints != joints:
        raise LogError("the log is broken: its joints are not those of its scenario")
    widths = {"qpos": model.nq, "qvel": model.nv, "controls": model.nu}
    for name, width in (widths | {"interventions": 1 + mujoco.mj_stateSize(model, STATE)}).items():
        if getattr(log, name).shape[1] != width:
            raise LogError(f"the log is broken: {name} has {getattr(log, name).shape[1]} columns, its scenario {width}")
