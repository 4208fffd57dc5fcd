"""Joint limits: how much farther joints would have to move for the tool to reach a pose."""

from __future__ import annotations

import mujoco
import numpy as np

from sim.motion.kinematics import ANGLE_TOLERANCE_RAD, POSITION_TOLERANCE_M, Arm
from sim.motion.trajectory import ToolPose

MAX_STEPS = 200
"""Number of steps after which a pose counts as out of reach."""

DAMPING = 1e-3
"""Damping of the least-squares steps."""

MAX_TURN_RAD = 0.3
"""Greatest turn of a joint in one step."""


def missing_turns(arm: Arm, goal: ToolPose) -> dict[str, float]:
    """Return by how much joints would have to exceed their ranges for the tool to reach a pose, rad or m, by name.

    Empty if the tool does not reach the pose even so, or if no joint exceeds its range. The search is by damped least
    squares from home and ignores the ranges.
    """
    model, names = arm.model, arm.robot.joints
    data, site = mujoco.MjData(model), model.site(arm.robot.tool).id
    data.qpos[:] = arm.robot.home
    jacobian, error, here, turn, wanted = np.empty((6, model.nv)), np.empty(6), *np.empty((3, 4))
    mujoco.mju_mat2Quat(wanted, goal.rotation.ravel())
    for _ in range(MAX_STEPS):
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], site)
        error[:3] = goal.position - data.site_xpos[site]
        mujoco.mju_mat2Quat(here, data.site_xmat[site])
        mujoco.mju_negQuat(here, here)
        mujoco.mju_mulQuat(turn, wanted, here)
        mujoco.mju_quat2Vel(error[3:], turn, 1.0)
        if np.linalg.norm(error[:3]) < POSITION_TOLERANCE_M and np.linalg.norm(error[3:]) < ANGLE_TOLERANCE_RAD:
            break
        step = np.linalg.solve(jacobian.T @ jacobian + DAMPING * np.eye(model.nv), jacobian.T @ error)
        data.qpos += step * min(1.0, MAX_TURN_RAD / float(np.abs(step).max()))
    else:
        return {}
    low, high = model.jnt_range.T
    hinge = model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE
    whole = np.where(hinge, 2 * np.pi, np.inf)
    q = np.where(hinge, data.qpos - whole * np.round((data.qpos - (low + high) / 2) / whole), data.qpos)
    beyond = np.maximum(np.maximum(low - q, q - high), 0.0)
    return {name: float(excess) for name, excess in zip(names, beyond, strict=True) if excess > 0}
