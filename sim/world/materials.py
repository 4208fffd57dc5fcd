"""The look of a scene: colours, finishes, lights and backdrop of a studio, and the camera on the hand."""

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from sim.robots.robot import Robot

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
class Glow:
    """Colours of a glowing part of a location: off, on, and of its light when on."""

    off: Rgba
    on: Rgba
    light: tuple[float, float, float]


def glow_of(kind: str | None) -> Glow:
    """Return the colours in which a location of a kind glows."""
    if kind == "stove":  # rings printed on the glass, and red heat
        return Glow((0.16, 0.155, 0.16, 1), (1.0, 0.24, 0.05, 1), (0.75, 0.20, 0.05))
    # A sanitizer: frosted glass, and the violet that people know from ultraviolet lamps.
    return Glow((0.55, 0.53, 0.62, 1), (0.25, 0.08, 1.0, 1), (0.30, 0.10, 1.0))


ASSETS = Path(__file__).parents[2] / "assets"

KEY_LIGHT = "studio_key"
"""Name of the light that casts the shadows."""

SHADOW_WIDTH = 1.55
"""Half width of the shadow map over half the table's longer side: it covers the corners."""

ARM_SHADOW_M = 0.85
"""Least half width of the shadow map, m: it covers the arm."""

WRIST = "wrist"
"""Name of the camera on the hand."""

WRIST_EYE_M = np.array([0.11, 0.0, 0.05])
"""Position of the camera in the hand's frame, m."""

WRIST_AIM_M = np.array([0.0, 0.0, 0.01])
"""Point that the camera looks at, relative to the tool's origin, m."""


def add_studio(spec: mujoco.MjSpec, *, target: np.ndarray, span: float) -> None:
    """Add finishes, lights, backdrop and render settings of a small photo studio.

    The lights aim at a (3,) target, m, which becomes the model's `stat.center`. The shadow map has to cover `span`,
    half the longer side of the table, m.
    """
    studio = mujoco.MjSpec.from_file(str(ASSETS / "studio.xml"))
    spec.visual = studio.visual
    spec.visual.map.shadowclip = max(ARM_SHADOW_M, SHADOW_WIDTH * span)
    spec.stat.center, spec.stat.extent = target, 1.0
    spec.attach(studio, prefix="studio_", frame=spec.worldbody.add_frame(pos=target))


def add_wrist_camera(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Add a camera beside the fingers that looks between them."""
    tool = spec.site(robot.tool)
    ahead = tool.pos + WRIST_AIM_M - WRIST_EYE_M
    ahead /= np.linalg.norm(ahead)
    right = np.array([0.0, -1.0, 0.0])
    view = tool.parent.add_camera(name=WRIST, pos=WRIST_EYE_M, fovy=70.0)
    view.alt.type = mujoco.mjtOrientation.mjORIENTATION_XYAXES
    view.alt.xyaxes = [*right, *np.cross(right, ahead)]
