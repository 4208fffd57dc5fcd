"""Where a film is seen from."""

from __future__ import annotations

from typing import Literal

import mujoco
import numpy as np

from sim.world.scene import AZIMUTH, ELEVATION, WRIST, Scene

DISTANCE = 3.5
"""Distance of the camera from its target, in halves of the table's longer side."""

NEAREST = 1.9
"""The same at least, so that the arm fits into the picture over a small table, m."""

SWING = 70.0
"""How far `orbit` goes to either side, degrees: beyond, the arm hides what it does."""

Camera = Literal["fixed", "orbit", "wrist"]
"""`fixed` sees the whole table; `orbit` goes round its front, once to and fro in a film; `wrist` rides on the hand."""


def camera(scene: Scene, name: Camera = "fixed", *, share: float = 0.0) -> mujoco.MjvCamera:
    """Return a camera.

    Args:
        scene: what it looks at.
        name: which.
        share: of the film that has passed, 0 .. 1.
    """
    view = mujoco.MjvCamera()
    if name == "wrist":
        view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        view.fixedcamid = scene.mujoco.camera(WRIST).id
        return view
    turn = SWING * np.sin(2 * np.pi * share) if name == "orbit" else 0.0
    view.lookat = scene.focus
    view.azimuth, view.elevation = AZIMUTH + turn, ELEVATION
    view.distance = max(NEAREST, DISTANCE * scene.span)
    return view
