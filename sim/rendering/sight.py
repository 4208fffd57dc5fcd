"""What a camera sees past fixtures."""

from __future__ import annotations

import mujoco
import numpy as np

from sim.world.fixtures import body_name
from sim.world.scene import Scene


def visible(scene: Scene, eye: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return (N,) bool: which of (N, 3) points, m, no fixture hides from a (3,) eye, m."""
    model, data = scene.mujoco, mujoco.MjData(scene.mujoco)
    mujoco.mj_kinematics(model, data)
    bodies = [model.body(body_name(fixture.name)).id for fixture in scene.model.fixtures]
    boxes = np.isin(model.geom_bodyid, bodies) & (model.geom_type == mujoco.mjtGeom.mjGEOM_BOX)
    hidden = np.zeros(len(points), dtype=bool)
    for geom in np.flatnonzero(boxes):
        # Both ends in the frame of the box: it hides what lies beyond the slab in which it is, along every axis.
        axes, half = data.geom_xmat[geom].reshape(3, 3), model.geom_size[geom]
        start, along = (eye - data.geom_xpos[geom]) @ axes, (points - eye) @ axes
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.stack([(-half - start) / along, (half - start) / along])
        enters, leaves = ends.min(axis=0).max(axis=1), ends.max(axis=0).min(axis=1)
        hidden |= (enters < leaves) & (leaves > 0) & (enters < 1)
    return ~hidden
