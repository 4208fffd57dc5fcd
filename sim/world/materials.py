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

SPARE_COLOUR: Rgba = (0.42, 0.42, 0.44, 1)
"""Colour of spare objects, which the model does not have."""


@dataclass(frozen=True)
class Finish:
    """How a surface takes light: MuJoCo's `rgba`, `specular` and `shininess`, each in 0 .. 1."""

    rgba: Rgba
    specular: float
    shininess: float


FINISHES = {
    "panda_shell": Finish((0.84, 0.845, 0.85, 1), 0.45, 0.55),
    "panda_trim": Finish((0.17, 0.175, 0.185, 1), 0.30, 0.35),
    "panda_metal": Finish((0.42, 0.43, 0.45, 1), 0.70, 0.60),
    "panda_rubber": Finish((0.09, 0.09, 0.095, 1), 0.12, 0.15),
    "bin": Finish((0.52, 0.55, 0.58, 1), 0.35, 0.40),
    "bin_floor": Finish((0.33, 0.35, 0.37, 1), 0.10, 0.10),
    "pad": Finish((0.50, 0.52, 0.56, 1), 0.30, 0.40),
    "steel": Finish((0.60, 0.61, 0.62, 1), 0.60, 0.50),
    "glass": Finish((0.045, 0.045, 0.052, 1), 0.80, 0.85),
    "porcelain": Finish((0.74, 0.735, 0.715, 1), 0.45, 0.60),
    "lamp": Finish((0.22, 0.23, 0.25, 1), 0.60, 0.60),
    "plinth": Finish((0.20, 0.21, 0.23, 1), 0.10, 0.20),
}


@dataclass(frozen=True)
class Glow:
    """Colours of a glowing part of a location: off, on, and of its light when on."""

    off: Rgba
    on: Rgba
    light: tuple[float, float, float]


LAMP_GLOW = Glow((0.55, 0.53, 0.62, 1), (0.52, 0.36, 1.0, 1), (0.52, 0.36, 1.0))
"""A sanitizer's tubes: frosted glass, and the violet that people know from ultraviolet lamps."""

STOVE_GLOW = Glow((0.16, 0.155, 0.16, 1), (1.0, 0.24, 0.05, 1), (0.75, 0.20, 0.05))
"""A stove's plate: rings printed on the glass, and red heat."""


def glow_of(kind: str | None) -> Glow:
    """Return how a location of a kind glows."""
    return STOVE_GLOW if kind == "stove" else LAMP_GLOW


KEY_LIGHT = "key"
"""The light that casts the shadows."""

SHADOW_WIDTH = 1.55
"""Half the width of what the shadow map covers, in halves of the table's longer side: its corners too."""

ARM_SHADOW = 0.85
"""The same at least, for the arm, m."""

BACKDROP_PIXELS = 192
"""Side of each of the backdrop's six pictures; it is smooth, so few are enough."""

BACKDROP_NEAR, BACKDROP_FAR = np.array([0.74, 0.77, 0.80]), np.array([0.24, 0.27, 0.31])
"""Colours in the middle of the glow behind the robot and far from it."""

BACKDROP_WIDTH = np.radians(24)
"""How wide the glow is: the angle at which three fifths of it are left, rad."""


def add_finishes(spec: mujoco.MjSpec) -> None:
    """Add every finish as a material of its own name."""
    for name, finish in FINISHES.items():
        spec.add_material(name=name, rgba=finish.rgba, specular=finish.specular, shininess=finish.shininess)


def add_studio(spec: mujoco.MjSpec, *, target: np.ndarray, span: float, view: np.ndarray) -> None:
    """Add lights, backdrop and render settings of a small photo studio.

    Args:
        spec: what to add them to.
        target: (3,) what the lights point at, m.
        span: half the longer side of the table, which the shadows have to cover, m.
        view: (3,) where the camera looks; the backdrop glows there.
    """
    spec.stat.center, spec.stat.extent = target, 1.0
    visual = spec.visual
    visual.global_.fovy = 36
    visual.quality.offsamples = 0
    visual.map.znear, visual.map.zfar = 0.05, 8
    visual.map.shadowclip = max(ARM_SHADOW, SHADOW_WIDTH * span)
    visual.headlight.ambient, visual.headlight.diffuse = [0.30] * 3, [0.10] * 3
    visual.headlight.specular = [0.0] * 3
    backdrop = spec.add_texture(name="backdrop", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, nchannel=3)
    backdrop.width, backdrop.height = BACKDROP_PIXELS, 6 * BACKDROP_PIXELS
    backdrop.data = _backdrop(view).tobytes()
    _light(spec, KEY_LIGHT, target, np.array([0.9, -1.1, 2.0]), (0.74, 0.72, 0.68), shadow=True)
    _light(spec, "fill", target, np.array([0.7, 1.5, 1.0]), (0.15, 0.17, 0.20), shadow=False)
    _light(spec, "rim", target, np.array([-1.6, 0.6, 1.2]), (0.24, 0.25, 0.27), shadow=False)


def _light(
    spec: mujoco.MjSpec,
    name: str,
    target: np.ndarray,
    offset: np.ndarray,
    colour: tuple[float, float, float],
    *,
    shadow: bool,
) -> None:
    """Add a light that shines everywhere from one side; its shadows reach `shadowclip` about the target."""
    light = spec.worldbody.add_light(name=name, pos=target + offset, dir=-offset, castshadow=shadow)
    light.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    light.diffuse, light.specular, light.ambient = colour, np.multiply(colour, 0.6), [0.0] * 3


def _backdrop(view: np.ndarray) -> np.ndarray:
    """Return the six pictures of a skybox, (6, n, n, 3) uint8: a glow in one direction.

    Their order and sense, found by looking at them: +x -x +z -z -y +y, those at the sides mirrored.
    """
    ahead = np.linspace(-1, 1, BACKDROP_PIXELS)
    down, across = np.meshgrid(ahead, ahead, indexing="ij")
    one = np.ones_like(across)
    faces = [
        (one, across, -down),
        (-one, -across, -down),
        (across, -down, one),
        (across, down, -one),
        (across, -one, -down),
        (-across, one, -down),
    ]
    direction = np.stack([np.stack(face, axis=-1) for face in faces])
    cosine = (direction @ view) / np.linalg.norm(direction, axis=-1) / np.linalg.norm(view)
    glow = np.exp(-0.5 * (np.arccos(np.clip(cosine, -1, 1)) / BACKDROP_WIDTH) ** 2)[..., None]
    # A grain of one step hides the bands that so slow a gradient would show.
    grain = np.random.default_rng(0).uniform(-0.5, 0.5, glow.shape)
    return np.round(255 * (BACKDROP_FAR + glow * (BACKDROP_NEAR - BACKDROP_FAR)) + grain).astype(np.uint8)
