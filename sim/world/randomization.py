"""Perturbations: by how much a rollout's world may differ from the nominal one, and a scene that differs so."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from prefplan.errors import choices
from sim.errors import SimulationError
from sim.world.scene import Scene

UNITS = {"position": 0.001, "angle": math.pi / 180, "friction": 1.0, "mass": 1.0, "noise": 0.001}
"""What one of each stands for when it is written down: millimetres, degrees, shares, shares, millimetres."""

MATTER_STREAM = 1
"""Number of the random stream for friction and mass: the same seed gives the same start poses with and without."""


@dataclass(frozen=True)
class Perturbation:
    """By how much a rollout's world may differ from the nominal one; the rollout's seed says by how much it does.

    Attributes:
        position: greatest offset of an object's start along x and along y, m.
        angle: greatest turn of an object's start about z, rad.
        friction: greatest relative change of the sliding friction of each object, and of the pads.
        mass: greatest relative change of each object's mass.
        noise: standard deviation of an observed position along each axis, m.

    Raises:
        SimulationError: (on construction) for a negative or infinite amount, or a change by the whole or more.
    """

    position: float = 0.005
    angle: float = math.radians(5)
    friction: float = 0.0
    mass: float = 0.0
    noise: float = 0.0

    def __post_init__(self) -> None:
        """Check the amounts."""
        for name, value in vars(self).items():
            if not (math.isfinite(value) and value >= 0):
                raise SimulationError(f"{name}: {value / UNITS[name]:g} is not an amount >= 0")
        for name in ("friction", "mass"):
            if getattr(self, name) >= 1:
                raise SimulationError(f"{name}: {getattr(self, name):g} is not a share below 1, e.g. 0.2 for 20 %")

    def __str__(self) -> str:
        """Return it as `read_perturbation` reads it."""
        return ",".join(f"{name}={value / UNITS[name]:.12g}" for name, value in vars(self).items() if value) or "none"


NONE = Perturbation(position=0.0, angle=0.0)
"""The nominal world."""


def read_perturbation(text: str) -> Perturbation:
    """Return the perturbation that a text says, e.g. `position=8,angle=10,friction=0.2,mass=0.2,noise=1`.

    Positions and noise are in millimetres, angles in degrees, friction and mass in shares. What is not named is not
    perturbed; `none` perturbs nothing.

    Raises:
        SimulationError: for a key or a value that is none.
    """
    amounts: dict[str, float] = {}
    for part in text.split(",") if text != "none" else ():
        name, _, value = (piece.strip() for piece in part.partition("="))
        if name not in UNITS:
            raise SimulationError(f"unknown perturbation {name!r} {choices(name, UNITS)}")
        if name in amounts:
            raise SimulationError(f"{name}: given twice")
        try:
            amounts[name] = float(value) * UNITS[name]
        except ValueError:
            raise SimulationError(f"{name}: {value!r} is not a number, as in position=8,angle=10") from None
    return replace(NONE, **amounts)


def perturbed(scene: Scene, perturbation: Perturbation, *, seed: int) -> Scene:
    """Return a scene whose objects and pads differ in friction and mass from the nominal ones.

    The scene is not compiled again: a copy of its MuJoCo model is changed. Start poses are drawn by `initial_state`.
    """
    if not (perturbation.friction or perturbation.mass):
        return scene
    rng = np.random.default_rng([seed, MATTER_STREAM])
    model = copy.copy(scene.mujoco)
    for obj in scene.model.objects:
        friction, mass = rng.uniform(-1, 1, 2) * [perturbation.friction, perturbation.mass]
        model.geom(obj.name).friction[0] *= 1 + friction
        body = model.body(obj.name)
        body.mass *= 1 + mass
        body.inertia *= 1 + mass
    # The pads' friction alone counts where they press an object, both being of one make.
    grip = 1 + rng.uniform(-1, 1) * perturbation.friction
    for pad in scene.robot.gripper.pads:
        model.geom(pad).friction[0] *= grip
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return replace(scene, mujoco=model)
