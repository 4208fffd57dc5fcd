"""Inverse dynamics of an arm that bears a load at its tool."""

from copy import copy

import mujoco
import numpy as np

from sim.robots.robot import LOAD


class InverseDynamics:
    """The inertia of an arm with n joints and a mass at its tool, and the torques that it needs."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Compute with the model of an arm alone (`Robot.kinematics`)."""
        self._model, self._data = copy(model), mujoco.MjData(model)  # two arms may bear different loads at a time
        self._load = self._model.body(LOAD)

    def inertia(self, q: np.ndarray, *, load: float) -> np.ndarray:
        """Return the (n, n) inertia at (n,) joint angles, rad, with a load, kg; in kg m^2."""
        model, data, inertia = self._model, self._data, np.empty((self._model.nv, self._model.nv))
        self._load.mass, data.qpos[:] = load, q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_crb(model, data)
        mujoco.mj_fullM(model, data, inertia)
        return inertia

    def torques(
        self, positions: np.ndarray, velocities: np.ndarray, accelerations: np.ndarray, *, load: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the torques, N m, that hold the arm and its load, kg, at rest, and those that its movement adds.

        Positions, velocities, accelerations and both results are (K, n), rad and s.
        """
        model, data = self._model, self._data
        holding, moving = np.empty((2, *positions.shape))
        self._load.mass = load
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
        return holding, moving
