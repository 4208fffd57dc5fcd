"""The view of a browser; the first one is that of a camera of the videos."""

from dataclasses import dataclass, replace
from typing import Self

import mujoco
import numpy as np
import viser

from sim.rendering.cameras import Camera, axes_of
from sim.world.scene import Scene, initial_state

PICTURE_PX = (900, 720)
"""Width and height of the picture for which a viewpoint is chosen, px: a common window size without the panel."""


@dataclass(frozen=True)
class Viewpoint:
    """A camera pose and its field of view.

    Attributes:
        eye: (3,) m.
        target: (3,) a point straight ahead, m.
        up: (3,) direction that is up in the picture.
        field: angle of view from top to bottom, rad.
    """

    eye: np.ndarray
    target: np.ndarray
    up: np.ndarray
    field: float

    @classmethod
    def of(cls, scene: Scene, camera: str) -> Self:
        """Return the viewpoint of a camera, as for `sim.rendering.cameras.Camera`, at the start of a run.

        Raises:
            RenderingError: there is no such camera.
        """
        view, upright = Camera(scene, camera, PICTURE_PX).view(), np.array([0.0, 0.0, 1.0])
        if view.type == mujoco.mjtCamera.mjCAMERA_FIXED:
            data = initial_state(scene)
            mujoco.mj_forward(scene.mujoco, data)
            eye, axes = data.cam_xpos[view.fixedcamid], data.cam_xmat[view.fixedcamid].reshape(3, 3)
            field = np.radians(scene.mujoco.cam_fovy[view.fixedcamid])
            return cls(eye.copy(), eye - axes[:, 2], axes[:, 1].copy(), float(field))
        _, _, ahead = axes_of(view)
        field = np.radians(scene.mujoco.vis.global_.fovy)
        return cls(view.lookat - view.distance * ahead, view.lookat.copy(), upright, float(field))

    def beside(self, offset: np.ndarray) -> Self:
        """Return a viewpoint with two scenes in the picture, the second at a (3,) offset, m."""
        back = float(np.linalg.norm(offset)) / 2 / np.tan(self.field / 2) * PICTURE_PX[1] / PICTURE_PX[0]
        ahead = (self.target - self.eye) / np.linalg.norm(self.target - self.eye)
        return replace(self, eye=self.eye + offset / 2 - back * ahead, target=self.target + offset / 2)

    def take(self, server: viser.ViserServer) -> None:
        """Use this viewpoint in all open browsers and in those that connect later."""
        first = server.initial_camera
        first.up, first.position, first.look_at, first.fov = self.up, self.eye, self.target, self.field
        for client in server.get_clients().values():
            now = client.camera
            now.up_direction, now.position, now.look_at, now.fov = self.up, self.eye, self.target, self.field
