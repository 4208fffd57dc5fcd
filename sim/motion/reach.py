"""How far an arm reaches whatever its posture: most poses out of reach are told without a search."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import mujoco
import numpy as np

from sim.motion.trajectory import ToolPose

SAMPLES, ROUNDS, VALUES = 500, 4, 33
"""Random configurations, rounds over all joints, and values of a joint tried for the greatest distance."""

SLACK_M = 0.005
"""Added to the greatest distance found, m; it is within 1 mm."""


@dataclass(frozen=True)
class Reach:
    """A bound of the distance between two points of an arm, of which a pose of the tool determines the second.

    Attributes:
        centre: (3,) origin of the first link, m.
        flange: (3,) origin of the last link in the tool's frame, m.
        greatest: distance of both, m.
    """

    centre: np.ndarray
    flange: np.ndarray
    greatest: float

    @classmethod
    def of(cls, model: mujoco.MjModel, home: np.ndarray, tool: str) -> Reach:
        """Find the greatest distance in a model of an arm alone, by coordinate ascent from the best of random (n,) q.

        Args:
            model: of the arm.
            home: (n,) configuration; where the first link can move, it is meant where it is then.
            tool: name of the site that is the tool.
        """
        data = mujoco.MjData(model)
        data.qpos[:] = home
        mujoco.mj_kinematics(model, data)
        first, last = model.jnt_bodyid[[0, -1]]
        centre, site = data.xpos[first].copy(), data.site(tool)
        flange = site.xmat.reshape(3, 3).T @ (data.xpos[last] - site.xpos)

        def distance(q: np.ndarray) -> float:
            data.qpos[:] = q
            mujoco.mj_kinematics(model, data)
            return float(np.linalg.norm(data.xpos[last] - centre))

        low, high = model.jnt_range.T
        farthest = max(np.random.default_rng(0).uniform(low, high, (SAMPLES, model.nq)), key=distance)
        for _, joint in itertools.product(range(ROUNDS), range(model.nq)):
            turned = np.tile(farthest, (VALUES, 1))
            turned[:, joint] = np.linspace(low[joint], high[joint], VALUES)
            farthest = max([farthest, *turned], key=distance)
        return cls(centre, flange, distance(farthest) + SLACK_M)

    def excludes(self, pose: ToolPose) -> bool:
        """Return whether no configuration brings the tool to a pose."""
        return float(np.linalg.norm(pose.position + pose.rotation @ self.flange - self.centre)) > self.greatest
