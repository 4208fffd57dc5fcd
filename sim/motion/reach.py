"""How far an arm reaches whatever its posture: most poses out of reach are told without a search."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from sim.motion.trajectory import ToolPose


@dataclass(frozen=True)
class Reach:
    """A bound of the distance between two points of an arm, of which a pose of the tool determines the second.

    They are the (3,) origin of the first link at home, m, and that of the last link, the flange, in the tool's frame,
    m; their greatest distance is the sum of the links' lengths, m.
    """

    centre: np.ndarray
    flange: np.ndarray
    greatest: float

    @classmethod
    def of(cls, model: mujoco.MjModel, home: np.ndarray, tool: str) -> Reach:
        """Bound the distance in a model of an arm alone, from its (n,) home configuration and the site of its tool."""
        data = mujoco.MjData(model)
        data.qpos[:] = home
        mujoco.mj_kinematics(model, data)
        first, body = model.jnt_bodyid[[0, -1]]
        site = data.site(tool)
        flange = site.xmat.reshape(3, 3).T @ (data.xpos[body] - site.xpos)
        slides = model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE
        greatest = 2 * np.linalg.norm(model.jnt_pos, axis=1).sum() + np.abs(model.jnt_range[slides]).sum()
        while body != first:
            greatest += np.linalg.norm(model.body_pos[body])
            body = model.body_parentid[body]
        return cls(data.xpos[first].copy(), flange, float(greatest))

    def excludes(self, pose: ToolPose) -> bool:
        """Return whether no configuration brings the tool to a pose."""
        return float(np.linalg.norm(pose.position + pose.rotation @ self.flange - self.centre)) > self.greatest
