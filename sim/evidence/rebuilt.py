"""The scene of a logged run, built again from a scenario, the log's own or a given one, and the log's setting."""

from __future__ import annotations

import functools
from bisect import bisect_left
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from prefplan.errors import PrefplanError
from prefplan.models.manipulation.model import ManipulationModel
from prefplan.scenario.decode import Scenario, loads
from sim.errors import LogError, RobotError
from sim.evidence.log import About, Log
from sim.external.bundle import unpacked
from sim.geometry.mjcf import columns
from sim.robots.catalogue import DEFAULT, ROBOTS, robot_for, robot_named
from sim.robots.robot import Robot
from sim.world.randomization import KEYS, Perturbation, camera_bias, perturbed, read_perturbation
from sim.world.scene import Scene, build_scene, initial_state

MIN_QUATERNION = 1e-3
"""Least norm of a quaternion that gives an orientation."""

MAX_UNKNOWN_OBJECTS = 20
"""Greatest number of objects that are not in the scenario."""


def described(about: About) -> Scenario:
    """Return the scenario that a log describes, with its files.

    Raises:
        LogError: it cannot be used.
    """
    return _decoded(about.text, about.scenario, tuple(sorted(about.files.items())))


@functools.lru_cache(maxsize=4)
def _decoded(text: str, name: str, files: tuple[tuple[str, str], ...]) -> Scenario:
    try:
        scenario = loads(text, name=name, measured=False)
        if not isinstance(scenario.model, ManipulationModel):
            raise LogError("the scenario in the log cannot be used: it has no manipulation model")
        return replace(scenario, model=unpacked(scenario.model, dict(files)))
    except LogError:
        raise
    except PrefplanError as error:
        raise LogError(f"the scenario in the log cannot be used: {error}") from None


def built(scenario: Scenario, about: About) -> tuple[Scene, bool]:
    """Return the scene of a log in a scenario, and whether the arm has meshes here.

    Joints that are neither the robot's nor an object's belong to objects that faults added.
    """
    model = scenario.model
    if not isinstance(model, ManipulationModel):
        raise LogError("nothing can be carried out in the given scenario: it has no manipulation model")
    try:
        moving = _robot(model, about.robot)
        others = len(about.joints) - len(moving.joints + moving.gripper.joints) - len(model.objects)
        spares = min(max(0, others), MAX_UNKNOWN_OBJECTS)
        # The scene is built even if no robot could work in it: what it did there, the frames show.
        scene = _scene(_ById(model), moving, spares, None)
        if scene.dressed and not about.meshes:
            return _scene(_ById(model), moving, spares, False), True
        return scene, scene.dressed
    except RobotError as error:
        raise LogError(f"the log cannot be checked: {error}") from None
    except PrefplanError as error:
        raise LogError(f"the scenario in the log cannot be used: {error}") from None


@dataclass(frozen=True, eq=False)
class _ById:
    """A model, whose scene is built once: a model with dictionaries cannot be hashed."""

    model: ManipulationModel

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _ById) and self.model is other.model

    def __hash__(self) -> int:
        return id(self.model)


@functools.lru_cache(maxsize=4)
def _scene(known: _ById, robot: Robot, spares: int, meshes: bool | None) -> Scene:
    return build_scene(known.model, robot=robot, spares=spares, meshes=meshes, judged=False)


def words_for(scene: Scene) -> str:
    """Return which shapes the arm has in a scene."""
    if scene.robot.name != DEFAULT:
        return f"the shapes of the robot `{scene.robot.name}`"
    return "the arm's meshes" if scene.dressed else "plain shapes of the arm"


def _robot(model: ManipulationModel, name: str) -> Robot:
    """Return the robot of a log: the scenario's own, or one of the catalogue.

    Raises:
        RobotError: it is unknown, or cannot be loaded here.
    """
    if model.robot_setup.mjcf is not None and name not in ROBOTS:
        own = robot_for(model.robot_setup)
        if own.name == name:
            return own
    return robot_named(name)


def perturbed_as_said(scene: Scene, about: About) -> tuple[Scene, np.ndarray, float, np.ndarray]:
    """Return a scene perturbed as the setting of a run says, the (nq,) positions at its start, noise and bias, m."""
    seed, text = about.setting.get("seed"), about.setting.get("perturbation")
    try:
        perturbation = read_perturbation(text) if isinstance(text, str) else Perturbation()
        bias = np.zeros(3)
        if seed is not None:
            scene = perturbed(scene, perturbation, seed=seed)
            bias = camera_bias(perturbation, seed=seed)
        start = initial_state(scene, seed=seed, position=perturbation.position, angle=perturbation.angle)
        noise = float(about.setting.get("noise_mm", 1000 * perturbation.noise)) / 1000
        if not 0 <= 1000 * noise <= KEYS["noise"].greatest:
            raise ValueError(f"a noise of {1000 * noise:g} mm")
        list(about.setting.get("faults") or ())
    except (PrefplanError, TypeError, ValueError, OverflowError) as error:
        raise LogError(f"the setting in the log cannot be used: {error}") from None
    return scene, start.qpos, noise, bias


def states_of(log: Log, robot: Robot, model: mujoco.MjModel, objects: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the (T, nq) recorded positions and the (T, nv) velocities in the order of a model's joints."""
    for name in robot.load_limits:
        if getattr(log, name).shape[1] != len(robot.joints):
            raise LogError(f"the log is broken: {name} are not those of the {len(robot.joints)} joints of the arm")
    if log.pad_forces.shape[1] != len(robot.gripper.pads):
        raise LogError(f"the log is broken: pad_forces are not those of the {len(robot.gripper.pads)} pads of the hand")
    fixed = (*robot.joints, *robot.gripper.joints)
    free = sorted(place for name, place in log.about.joints.items() if name not in fixed)
    qpos, qvel = np.tile(model.qpos0, (len(log.times), 1)), np.zeros((len(log.times), model.nv))
    for name in (*fixed, *objects):
        pose, rates = columns(model, name)
        positions, velocities = pose.stop - pose.start, rates.stop - rates.start
        first = log.about.joints.get(name, -1)
        # A free joint has seven positions and six velocities.
        speed = first - bisect_left(free, first)
        if not 0 <= first <= log.qpos.shape[1] - positions or not 0 <= speed <= log.qvel.shape[1] - velocities:
            raise LogError(f"the log is broken: a frame has no position of {name!r}")
        qpos[:, pose] = log.qpos[:, first : first + positions]
        qvel[:, rates] = log.qvel[:, speed : speed + velocities]
        if positions == 7 and np.linalg.norm(qpos[:, pose][:, 3:], axis=1).min() < MIN_QUATERNION:
            raise LogError(f"the log is broken: a frame has no orientation of {name!r}")
    return qpos, qvel
