"""Inverse dynamics of an arm that bears a load at its tool."""

import mujoco
import numpy as np


class InverseDynamics:
    """The inertia of an arm with n joints and a mass at its tool, and the torques that it needs."""

    def __init__(self, model: mujoco.MjModel, tool: str) -> None:
        """Compute with the model of an arm alone (`Robot.kinematics`); `tool` is a site."""
        self._model, self._data = model, mujoco.MjData(model)
        self._site = model.site(tool).id

    def inertia(self, q: np.ndarray, *, load: float) -> np.ndarray:
        """Return the (n, n) inertia at (n,) joint angles, rad, with a load, kg; in kg m^2."""
        model, data, inertia = self._model, self._data, np.empty((self._model.nv, self._model.nv))
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_crb(model, data)
        mujoco.mj_fullM(model, data, inertia)
        jacobian = self._jacobians()[0]
        return np.asarray(inertia + load * jacobian.T @ jacobian)

    def torques(
        self, positions: np.ndarray, velocities: np.ndarray, accelerations: np.ndarray, *, load: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the torques, N m, that hold the arm and its load, kg, at rest, and those that its movement adds.

        Positions, velocities, accelerations and both results are (K, n), rad and s.
        """
        model, data = self._model, self._data
        holding, moving = np.empty((2, *positions.shape))
        gravity = model.opt.gravity
        for k, (q, velocity, acceleration) in enumerate(zip(positions, velocities, accelerations, strict=True)):
            data.qpos[:], data.qvel[:], data.qacc[:] = q, 0.0, acceleration
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_comVel(model, data)
            mujoco.mj_rne(model, data, 0, holding[k])
            data.qvel[:] = velocity
            mujoco.mj_comVel(model, data)
            mujoco.mj_rne(model, data, 1, moving[k])
            moving[k] += model.dof_armature * acceleration + model.dof_damping * velocity - holding[k]
            jacobian, change = self._jacobians()
            holding[k] -= load * jacobian.T @ gravity
            moving[k] += load * jacobian.T @ (jacobian @ acceleration + change @ velocity)
        return holding, moving

    def _jacobians(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the (3, n) Jacobian of the tool's position in the state that was computed last, and its rate."""
        model, data, site = self._model, self._data, self._site
        jacobian, change = np.empty((2, 3, model.nv))
        mujoco.mj_jacSite(model, data, jacobian, None, site)
        mujoco.mj_jacDot(model, data, change, None, data.site_xpos[site], model.site_bodyid[site])
        return jacobian, change
