"""How far an arm reaches whatever its posture: a bound that excludes most poses out of reach without a search."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import dropwhile

import mujoco
import numpy as np

from sim.motion.trajectory import ToolPose

ON_AXIS_M = 1e-6
"""A point nearer to an axis than this, m, counts as on it."""

TOLERANCE_M = 0.003
"""By how much the bound may be exceeded, m: inverse kinematics tolerates errors of the tool's position and turn."""


@dataclass(frozen=True)
class Reach:
    """An upper bound of the distance from an arm's first joint to its flange, which a pose of the tool determines.

    Attributes:
        centre: (3,) anchor of the first joint, m.
        flange: (3,) origin of the last link, the flange, in the tool's frame, m.
        greatest: the bound, m.
    """

    centre: np.ndarray
    flange: np.ndarray
    greatest: float

    @classmethod
    def of(cls, model: mujoco.MjModel, home: np.ndarray, tool: str) -> Reach:
        """Bound the distance in a model of an arm alone, from its (n,) home configuration and the site of its tool.

        The bound is the length of the shortest chain from the first joint's anchor to the flange via anchors of other
        joints. Each link of the chain is the greatest distance of its ends, which at most one joint may change.
        """
        data = mujoco.MjData(model)
        data.qpos[:] = home
        mujoco.mj_kinematics(model, data)
        flange = data.xpos[model.jnt_bodyid[-1]]
        points = np.array([*data.xanchor, flange])
        lengths = np.full(len(points), np.inf)
        lengths[0] = 0.0
        for end in range(1, len(points)):
            lengths[end] = min(lengths[start] + _greatest(model, data, points, start, end) for start in range(end))
        site = data.site(tool)
        return cls(points[0].copy(), site.xmat.reshape(3, 3).T @ (flange - site.xpos), float(lengths[-1]))

    def excludes(self, pose: ToolPose) -> bool:
        """Return whether no configuration brings the tool to a pose, or nearly so."""
        distance = float(np.linalg.norm(pose.position + pose.rotation @ self.flange - self.centre))
        return distance > self.greatest + TOLERANCE_M


def _greatest(model: mujoco.MjModel, data: mujoco.MjData, points: np.ndarray, start: int, end: int) -> float:
    """Return the greatest distance of two of the (n + 1, 3) points, m; infinite if several joints change it.

    Joints next to the start, or to the end, whose axes pass through this point do not change the distance.
    """
    joints = [*dropwhile(lambda joint: _is_on_axis(model, data, joint, points[start]), range(start, end))]
    joints = [*dropwhile(lambda joint: _is_on_axis(model, data, joint, points[end]), reversed(joints))]
    if len(joints) > 1:
        return np.inf
    ends = [points[end]] if not joints else _farthest(model, data, joints[0], points[start], points[end])
    return max(float(np.linalg.norm(place - points[start])) for place in ends)


def _is_on_axis(model: mujoco.MjModel, data: mujoco.MjData, joint: int, point: np.ndarray) -> bool:
    off = np.cross(data.xaxis[joint], point - data.xanchor[joint])
    return bool(model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE and np.linalg.norm(off) < ON_AXIS_M)


def _farthest(
    model: mujoco.MjModel, data: mujoco.MjData, joint: int, start: np.ndarray, end: np.ndarray
) -> Iterator[np.ndarray]:
    """Yield (3,) positions, m, to which one joint can move the end; one of them is the farthest from the start."""
    axis, anchor = data.xaxis[joint], data.xanchor[joint]
    low, high = model.jnt_range[joint] - data.qpos[joint]
    if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE:
        yield from (end + low * axis, end + high * axis)
        return
    radius, target = end - anchor, start - anchor
    along = (radius @ axis) * axis
    across, aside = radius - along, np.cross(axis, radius)
    opposite = np.arctan2(-(target @ aside), -(target @ across))
    inside = (opposite + turn for turn in (-2 * np.pi, 0.0, 2 * np.pi) if low < opposite + turn < high)
    for turn in (low, high, *inside):
        yield anchor + along + np.cos(turn) * across + np.sin(turn) * aside
