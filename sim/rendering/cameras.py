"""The views that a video may have."""

from __future__ import annotations

import mujoco
import numpy as np

from sim.world.scene import AZIMUTH, ELEVATION, WRIST, Scene

DISTANCE = 3.5
"""Distance of the camera from its target, in halves of the table's longer side."""

MIN_DISTANCE_M = 1.9
"""The same at least, so that the arm fits into the picture over a small table, m."""

SWING_DEGREES = 70.0
"""How far `orbit` goes to either side: beyond, the arm hides what it does."""


CAMERAS = ("fixed", "orbit", "wrist")
"""In front of the table; around its front, once to and fro in a video; on the hand."""


def camera(scene: Scene, name: str = "fixed", *, share: float = 0.0) -> mujoco.MjvCamera:
    """Return a camera.

    Args:
        scene: what it looks at.
        name: one of `CAMERAS`.
        share: of the video that has passed, 0 .. 1.
    """
    view = mujoco.MjvCamera()
    if name == "wrist":
        view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        view.fixedcamid = scene.mujoco.camera(WRIST).id
        return view
    turn = SWING_DEGREES * np.sin(2 * np.pi * share) if name == "orbit" else 0.0
    view.lookat = scene.focus
    view.azimuth, view.elevation = AZIMUTH + turn, ELEVATION
    view.distance = max(MIN_DISTANCE_M, DISTANCE * scene.span)
    return view
