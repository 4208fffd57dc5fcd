"""Collision checks of the robot and its load, among themselves and with the world, at given joint angles."""

from __future__ import annotations

import copy

import mujoco
import numpy as np

from sim.perception.sensors import ObjectPose, Poses
from sim.perception.touch import ContactMonitor
from sim.world.contacts import set_margins
from sim.world.scene import Scene

ADJACENT_M = 0.01
"""Links nearer than this to each other with the arm at home and the hand closed never count as in collision."""


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
        self._is_robot = scene.robot.bodies(model)
        scene.robot.let_links_collide(model)
        self._margins = np.full(model.ngeom, ADJACENT_M)
        set_margins(model, self._margins)
        scene.robot.put(self._data, scene.robot.home, width=0.0)
        mujoco.mj_kinematics(model, self._data)
        mujoco.mj_collision(model, self._data)
        self._adjacent = self._links_in_contact()

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
        margins = np.where(self._contacts.moving, clearance, 0.0)
        if not np.array_equal(margins, self._margins):
            self._margins = margins
            set_margins(model, margins)
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
        links = {model.body(high).name for _, high in self._links_in_contact() - self._adjacent}
        return sorted({other for _, other in self._contacts.touches(data)} - {handled} | links)

    def _links_in_contact(self) -> set[tuple[int, int]]:
        """Return the pairs of the robot's own bodies that are in contact, the lower number first."""
        pairs = self._model.geom_bodyid[self._data.contact.geom.reshape(-1, 2)]
        own = np.sort(pairs[self._is_robot[pairs].all(axis=1)], axis=1)
        return {(int(low), int(high)) for low, high in own}

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
