"""Collision checks of the robot and its load at given joint angles."""

from __future__ import annotations

import copy

import mujoco
import numpy as np

from sim.perception.sensors import ObjectPose, Poses
from sim.perception.touch import ContactMonitor
from sim.world.scene import Scene


class CollisionChecker:
    """A copy of the scene in which configurations of the robot are checked."""

    def __init__(self, scene: Scene, contacts: ContactMonitor) -> None:
        """Tell wanted contacts from collisions as `contacts` does."""
        self._model = model = copy.copy(scene.mujoco)
        self._data = mujoco.MjData(model)
        self._contacts = contacts
        self._robot = scene.robot
        self._arm = scene.robot.qpos(model)
        self._fingers = [int(model.joint(name).qposadr[0]) for name in scene.robot.gripper.joints]

    def touches(
        self, now: mujoco.MjData, poses: Poses, q: np.ndarray, *, width: float | None = None, clearance: float = 0.0
    ) -> list[str]:
        """Return the names of the bodies in collision with the robot or its load.

        Args:
            now: the present state, of which the robot knows its own part.
            poses: last observed poses of the objects.
            q: (n,) joint angles to check, rad.
            width: between the pads, m; None for the present one.
            clearance: bodies nearer than this count as in collision, m.
        """
        model, data, handled = self._model, self._data, self._contacts.handled
        model.geom_margin[:] = np.where(self._contacts.moving, clearance, 0.0)
        model.body_margin[:] = clearance
        data.qpos[:] = now.qpos
        for obj, pose in poses.items():
            self._put(obj, pose.position, pose.rotation)
        data.qpos[self._arm] = q
        if width is not None:
            data.qpos[self._fingers] = width / len(self._fingers)
        mujoco.mj_kinematics(model, data)
        if handled and self._contacts.aloft:
            self._carry(now, handled, poses[handled])
        mujoco.mj_collision(model, data)
        return sorted({other for _, other in self._contacts.touches(data)} - {handled})

    def _carry(self, now: mujoco.MjData, obj: str, seen: ObjectPose) -> None:
        """Move an object as the hand moves it."""
        here, there = now.site(self._robot.tool), self._data.site(self._robot.tool)
        turn = there.xmat.reshape(3, 3) @ here.xmat.reshape(3, 3).T
        self._put(obj, there.xpos + turn @ (seen.position - here.xpos), turn @ seen.rotation)
        mujoco.mj_kinematics(self._model, self._data)

    def _put(self, obj: str, position: np.ndarray, rotation: np.ndarray) -> None:
        pose = self._data.joint(obj).qpos
        pose[:3] = position
        mujoco.mju_mat2Quat(pose[3:], rotation.ravel())
