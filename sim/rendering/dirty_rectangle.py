"""The dirty rectangle: the part of a picture that can differ from the one before; only this is rendered again.

A geom that moves changes the picture within the boxes round it before and after, and where its shadow falls.
"""

import mujoco
import numpy as np

from sim.geometry.mjcf import VISIBLE, box_corners
from sim.geometry.rectangle import Rectangle
from sim.rendering.cameras import Camera
from sim.rendering.labels import PixelBox

MOVED_M = 1e-5
"""Least distance by which a corner of the box round a geom moves that changes a picture: a fiftieth of a pixel."""

SUNK_M = 0.01
"""A point that is lower than the table's top by more than this does not rest on the table, m."""

BESIDE_M = 0.001
"""A low point that sticks out from under the table's top by more than this is beside the table, m."""

ROUNDING_PX = 2
"""Greatest error of a projected corner, pixels."""


class DirtyRectangle:
    """Follows the geoms that a camera sees."""

    def __init__(self, model: mujoco.MjModel, camera: Camera, light: int, table: Rectangle | None) -> None:
        """Begin with an unknown picture of a camera that is not mounted.

        `light` casts the shadows, and `table` is the outline of the table's top, at height 0; None if there is none.
        """
        self._camera, self._light, self._table = camera, light, table
        self._geoms = np.flatnonzero(model.geom_group <= VISIBLE)
        shadows = np.flatnonzero(model.light_castshadow).tolist()
        stands = (model.body_weldid[model.light_bodyid] == 0) & (
            model.light_mode == mujoco.mjtCamLight.mjCAMLIGHT_FIXED
        )
        # With mirrors, other shadows, lights that move, or shapes that are no geoms, a motion may change any pixel.
        only_geoms = not (model.mat_reflectance.any() or model.nskin or model.nflex)
        self._is_local = only_geoms and set(shadows) <= {light} and bool(stands.all())
        self._shown: np.ndarray | None = None
        self._look: object = None

    def update(self, data: mujoco.MjData, share: float, look: object = None) -> PixelBox:
        """Return the box of pixels that can have changed since the last call: at first all, none if nothing moved.

        The data are after `mj_kinematics`, at a share of the video. `look` is everything else on which the picture
        depends, such as the view and the lamps: if it differs, all pixels can have changed.
        """
        corners = box_corners(data, self._geoms)
        if self._shown is None or self._look != look or not self._is_local:
            self._shown, self._look = corners, look
            return 0, 0, *self._camera.size
        moved = (np.abs(corners - self._shown) > MOVED_M).any(axis=(1, 2))
        if not moved.any():
            return 0, 0, 0, 0
        boxes = np.concatenate([self._shown[moved], corners[moved]])
        self._shown[moved] = corners[moved]
        ray = data.model.light_dir[self._light]
        points = np.concatenate([boxes, self._shadows(boxes, corners, ray / -ray[2])]).reshape(-1, 3)
        pixels = self._camera.pixels(points, share)
        first, last = np.floor(pixels.min(axis=0)) - ROUNDING_PX, np.ceil(pixels.max(axis=0)) + ROUNDING_PX
        left, top, right, bottom = np.clip([first, last], 0, self._camera.size).astype(int).ravel().tolist()
        return left, top, right, bottom

    def _shadows(self, boxes: np.ndarray, corners: np.ndarray, ray: np.ndarray) -> np.ndarray:
        """Return the (N, 8, 3) ends of boxes' shadows: level with the table, or below all geoms if they may pass it.

        If nothing low stands beside the table, only a shadow that comes from beside the table falls below its top. The
        corners of all geoms are (G, 8, 3), m; the ray is the light's (3,) direction per metre downwards.
        """
        level, below = (boxes + (boxes[..., 2:] - height) * ray for height in (0.0, corners[..., 2].min()))
        if self._table is None:
            return below
        low = corners[corners[..., 2] < -SUNK_M]
        if (np.abs(self._table.local(low[:, :2])) > self._table.half + BESIDE_M).any():
            return below
        beside = self._table.local(level[..., :2]) * np.sign(self._table.axes @ ray[:2]) < -self._table.half
        passes = (beside | (boxes[..., 2:] < -SUNK_M)).any(axis=(1, 2), keepdims=True)
        return np.where(passes, below, level)
