"""Perturbations: how far a rollout's world may differ from the nominal one, and scenes that are perturbed."""

import copy
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace

import mujoco
import numpy as np

from prefplan.errors import choices
from sim.errors import SimulationError
from sim.world.contacts import scale_friction
from sim.world.places import START_OFFSET_M, START_TURN_RAD
from sim.world.scene import TIMESTEP_S, Scene, initial_state

MATTER_STREAM = 1
"""Random stream for friction and mass, apart from that of the start poses, which do not depend on these draws."""

DEVICE_STREAM = 4
"""Random stream for the table, the gripper, delays, the camera and centres of mass; faults have streams 2 and 3."""

MAX_CENTRE_SHARE = 0.7
"""Greatest offset of a centre of mass along an axis, as a share of half the object's side: it stays inside."""


@dataclass(frozen=True)
class PerturbationKey:
    """Unit and bound of one key of `--perturb`.

    Attributes:
        unit: in which the amount is given.
        scale: one such unit, in SI units.
        greatest: greatest amount, in that unit.
    """

    unit: str
    scale: float
    greatest: float


def _bound(unit: str, scale: float, greatest: float, *, usual: float = 0.0) -> float:
    """Declare an amount with its `PerturbationKey`; `usual` is its default, in SI units."""
    amount: float = field(default=usual, metadata={"key": PerturbationKey(unit, scale, greatest)})
    return amount


@dataclass(frozen=True)
class Perturbation:
    """Amounts by which a rollout's world may differ from the nominal one.

    Lengths are in m, angles in rad, times in s; the others are shares of 1. Each amount except `noise` is a bound: the
    rollout's seed draws a value within it.

    Attributes:
        position: offset of each object's start along x and along y.
        angle: turn of each object's start about z.
        friction: change of each object's friction, wherever it is touched.
        pads: change of the friction of the gripper's pads.
        table: change of the friction of the table and of other surfaces that objects lie on.
        force: change of the gripper's force.
        mass: change of each object's mass.
        centre: offset of each object's centre of mass along x, y and z, inside it.
        latency: time from a command until the actuators get it.
        noise: standard deviation of every observed position.
        bias: constant error of all observed positions along x, y and z.

    Raises:
        SimulationError: (on construction) for an amount that is negative or greater than its key's greatest.
    """

    position: float = _bound("mm", 0.001, 50, usual=START_OFFSET_M)
    angle: float = _bound("degrees", math.pi / 180, 180, usual=START_TURN_RAD)
    friction: float = _bound("share", 1.0, 0.99)
    pads: float = _bound("share", 1.0, 0.99)
    table: float = _bound("share", 1.0, 0.99)
    force: float = _bound("share", 1.0, 0.99)
    mass: float = _bound("share", 1.0, 0.99)
    centre: float = _bound("mm", 0.001, 15)
    latency: float = _bound("ms", 0.001, 200)
    noise: float = _bound("mm", 0.001, 20)
    bias: float = _bound("mm", 0.001, 20)

    def __post_init__(self) -> None:
        """Check the amounts."""
        for name, value in vars(self).items():
            key = KEYS[name]
            if not 0 <= value / key.scale <= key.greatest * (1 + 1e-9):
                unit = ", a share: 0.2 for 20 %" if key.unit == "share" else f" {key.unit}"
                raise SimulationError(f"{name}: {value / key.scale:g} is not from 0 to {key.greatest:g}{unit}")

    def __str__(self) -> str:
        """Return the text from which `read_perturbation` reads it."""
        amounts = (f"{name}={value / KEYS[name].scale:.12g}" for name, value in vars(self).items() if value)
        return ",".join(amounts) or "none"


KEYS: dict[str, PerturbationKey] = {amount.name: amount.metadata["key"] for amount in fields(Perturbation)}
"""The keys of `--perturb`."""

NONE = Perturbation(position=0.0, angle=0.0)
"""The nominal world."""


def read_perturbation(text: str) -> Perturbation:
    """Return the perturbation that a text describes, e.g. `position=8,angle=10,friction=0.2,mass=0.2,noise=1`.

    Amounts are in the units of `KEYS`. A key that is not named gets 0; `none` perturbs nothing.

    Raises:
        SimulationError: for an unknown or repeated key, and for a value that is no number or out of bounds.
    """
    amounts: dict[str, float] = {}
    for part in text.split(",") if text != "none" else ():
        name, _, value = (piece.strip() for piece in part.partition("="))
        if name not in KEYS:
            raise SimulationError(f"unknown perturbation {name!r} {choices(name, KEYS)}")
        if name in amounts:
            raise SimulationError(f"{name}: given twice")
        try:
            amounts[name] = float(value) * KEYS[name].scale
        except ValueError:
            raise SimulationError(f"{name}: {value!r} is not a number, as in position=8,angle=10") from None
    return replace(NONE, **amounts)


def perturbed(scene: Scene, perturbation: Perturbation, *, seed: int) -> Scene:
    """Return a scene that differs from the nominal one in friction, masses, their centres, gripper force and latency.

    What a seed draws for one key does not depend on the amounts of the others. `initial_state` draws the start poses,
    `camera_bias` the camera's error.
    """
    if replace(perturbation, position=0.0, angle=0.0, noise=0.0, bias=0.0) == NONE:
        return scene
    objects = [obj.name for obj in scene.model.objects]
    rng = np.random.default_rng([seed, MATTER_STREAM])
    matter = rng.uniform(-1, 1, (len(objects), 2)) * [perturbation.friction, perturbation.mass]
    pads = rng.uniform(-1, 1) * perturbation.pads
    devices, centres = _device_draws(seed, len(objects))
    model = copy.copy(scene.mujoco)
    if perturbation.centre:
        model = _with_centres(scene, dict(zip(objects, centres, strict=True)), perturbation.centre)
    for name, change in zip(objects, matter[:, 1], strict=True):
        body = model.body(name)
        body.mass *= 1 + change
        body.inertia *= 1 + change
    scale_friction(
        model,
        dict.fromkeys(scene.spares, 1.0) | dict(zip(objects, 1 + matter[:, 0], strict=True)),
        pads=dict.fromkeys(scene.robot.gripper.pads, 1 + pads),
        table=1 + devices["table"] * perturbation.table,
    )
    motor, force = model.actuator(scene.robot.gripper.actuator), 1 + devices["force"] * perturbation.force
    motor.gainprm[0] *= force
    motor.biasprm[:3] *= force
    motor.forcerange *= force
    mujoco.mj_setConst(model, mujoco.MjData(model))
    latency = TIMESTEP_S * round(abs(devices["latency"]) * perturbation.latency / TIMESTEP_S)
    return replace(scene, mujoco=model, nominal=scene.mujoco, latency=latency)


def drawn(scene: Scene, perturbation: Perturbation, *, seed: int | None) -> tuple[Scene, mujoco.MjData, np.ndarray]:
    """Return the `perturbed` scene, the initial state of a run in it, and the `camera_bias`.

    Without a seed, the scene and its state are the nominal ones, and the camera's error is 0.
    """
    bias = np.zeros(3)
    if seed is not None:
        scene, bias = perturbed(scene, perturbation, seed=seed), camera_bias(perturbation, seed=seed)
    return scene, initial_state(scene, seed=seed, position=perturbation.position, angle=perturbation.angle), bias


def camera_bias(perturbation: Perturbation, *, seed: int) -> np.ndarray:
    """Return the (3,) error of every observed position, m."""
    devices, _ = _device_draws(seed, 0)
    return np.array([devices[f"bias_{axis}"] for axis in "xyz"]) * perturbation.bias


def _device_draws(seed: int, objects: int) -> tuple[dict[str, float], np.ndarray]:
    """Return a number from -1 to 1 for each device, and (objects, 3) such numbers for the centres of mass."""
    rng = np.random.default_rng([seed, DEVICE_STREAM])
    names = ("table", "force", "latency", "bias_x", "bias_y", "bias_z")
    return dict(zip(names, rng.uniform(-1, 1, len(names)).tolist(), strict=True)), rng.uniform(-1, 1, (objects, 3))


def _with_centres(scene: Scene, offsets: Mapping[str, np.ndarray], amount: float) -> mujoco.MjModel:
    """Return the model with centres of mass moved by (3,) shares of an amount, m, limited by `MAX_CENTRE_SHARE`.

    The model is compiled again: compiled with a centre in the middle, it skips terms that would be zero.
    """
    spec = scene.spec.copy()
    for name, offset in offsets.items():
        body, nominal = spec.body(name), scene.mujoco.body(name)
        greatest = np.minimum(amount, MAX_CENTRE_SHARE * scene.shapes[name].half)
        body.explicitinertial, body.mass, body.inertia = True, nominal.mass[0], nominal.inertia
        body.ipos, body.iquat = nominal.ipos + offset * greatest, nominal.iquat
    return spec.compile()
