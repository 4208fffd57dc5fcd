"""Colours, finishes, lights and backdrop: everything that decides how the scene looks but no geometry."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

Rgba = tuple[float, float, float, float]

OBJECT_COLOURS: tuple[Rgba, ...] = (
    (0.10, 0.32, 0.85, 1),
    (0.93, 0.42, 0.62, 1),
    (0.16, 0.60, 0.32, 1),
    (0.96, 0.70, 0.15, 1),
    (0.55, 0.30, 0.75, 1),
    (0.90, 0.30, 0.18, 1),
    (0.10, 0.65, 0.70, 1),
    (0.45, 0.45, 0.50, 1),
)
"""Colours of objects that have none of their own, in turn."""


@dataclass(frozen=True)
class Finish:
    """How a surface takes light: MuJoCo's `rgba`, `specular` and `shininess`, each in 0 .. 1."""

    rgba: Rgba
    specular: float
    shininess: float


FINISHES = {
    "panda_shell": Finish((0.88, 0.88, 0.87, 1), 0.45, 0.55),
    "panda_trim": Finish((0.17, 0.175, 0.185, 1), 0.30, 0.35),
    "panda_metal": Finish((0.42, 0.43, 0.45, 1), 0.70, 0.60),
    "panda_rubber": Finish((0.09, 0.09, 0.095, 1), 0.12, 0.15),
    "bin": Finish((0.24, 0.26, 0.29, 1), 0.35, 0.40),
    "bin_floor": Finish((0.15, 0.16, 0.18, 1), 0.10, 0.10),
    "pad": Finish((0.84, 0.86, 0.88, 1), 0.50, 0.60),
    "lamp": Finish((0.22, 0.23, 0.25, 1), 0.60, 0.60),
    "table_edge": Finish((0.36, 0.25, 0.17, 1), 0.20, 0.30),
    "table_frame": Finish((0.12, 0.12, 0.13, 1), 0.40, 0.40),
    "floor": Finish((0.46, 0.47, 0.49, 1), 0.0, 0.0),
}

GLOW_OFF: Rgba = (0.55, 0.53, 0.62, 1)
"""A sanitizer's tubes at rest: frosted glass."""

GLOW_ON: Rgba = (0.62, 0.50, 1.0, 1)
"""A sanitizer's tubes at work: the violet that people know from ultraviolet lamps."""

HORIZON = (0.62, 0.65, 0.69)
ZENITH = (0.20, 0.24, 0.31)


def add_finishes(spec: mujoco.MjSpec) -> None:
    """Add every finish as a material of its own name."""
    for name, finish in FINISHES.items():
        spec.add_material(name=name, rgba=finish.rgba, specular=finish.specular, shininess=finish.shininess)


def add_studio(spec: mujoco.MjSpec, *, target: np.ndarray) -> None:
    """Add lights, backdrop and render settings of a small photo studio.

    Args:
        spec: what to add them to.
        target: (3,) what the lights point at, m.
    """
    visual = spec.visual
    visual.global_.fovy = 40
    visual.quality.shadowsize = 2048
    visual.quality.offsamples = 4
    visual.map.znear, visual.map.zfar = 0.05, 12
    visual.map.shadowclip, visual.map.shadowscale = 1.2, 0.8
    visual.headlight.ambient, visual.headlight.diffuse = [0.22] * 3, [0.12] * 3
    visual.headlight.specular = [0.0] * 3
    visual.rgba.haze = [*HORIZON, 1]
    visual.map.haze = 0.6
    spec.add_texture(
        name="backdrop",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=ZENITH,
        rgb2=HORIZON,
        width=256,
        height=1536,
    )
    _spot(spec, "key", target, np.array([0.7, -1.0, 1.9]), (0.78, 0.75, 0.70), shadow=True)
    _spot(spec, "fill", target, np.array([0.6, 1.6, 1.2]), (0.20, 0.23, 0.28), shadow=False)
    _spot(spec, "rim", target, np.array([-1.6, 0.5, 1.6]), (0.22, 0.22, 0.24), shadow=False)


def _spot(
    spec: mujoco.MjSpec,
    name: str,
    target: np.ndarray,
    offset: np.ndarray,
    colour: tuple[float, float, float],
    *,
    shadow: bool,
) -> None:
    light = spec.worldbody.add_light(name=name, pos=target + offset, dir=-offset, castshadow=shadow)
    light.type = mujoco.mjtLightType.mjLIGHT_SPOT
    light.diffuse, light.specular, light.ambient = colour, np.multiply(colour, 0.6), [0.0] * 3
    light.cutoff, light.exponent = 50, 6
