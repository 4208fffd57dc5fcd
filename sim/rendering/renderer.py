"""Pictures of a scene, rendered off screen."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from types import TracebackType

import mujoco
import numpy as np

from sim.errors import RenderingError
from sim.geometry.mjcf import VISIBLE
from sim.rendering.antialias import MARGIN_PX, fill_specks, smooth_edges
from sim.rendering.cameras import Camera, label_offsets
from sim.rendering.dirty_rectangle import DirtyRectangle
from sim.rendering.framing import label_anchors, label_targets
from sim.rendering.labels import PixelBox, draw_labels, label_boxes
from sim.rendering.opengl import gl_context, no_gl
from sim.rendering.quality import Quality
from sim.world.materials import KEY_LIGHT, WRIST, Glow, glow_of
from sim.world.scene import Scene

GOLDEN_ANGLE_RAD = np.pi * (3 - np.sqrt(5))
"""Angle between successive points of a spiral that covers a disc evenly."""


class Painter:
    """Renders states of one scene. Use it as a context manager, and one at a time per process.

    Raises:
        RenderingError: (on construction) there is no OpenGL; the message says how to repair that.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        quality: Quality,
        camera: str,
        opening: float = 0.0,
    ) -> None:
        """Create the OpenGL context; camera and opening are as for `sim.rendering.cameras.Camera`."""
        size = quality.size
        self._scene, self._quality, self._camera = scene, quality, Camera(scene, camera, size, opening=opening)
        if self._camera.mounted:  # no names are written over its pictures
            self._model = scene.with_names()
        else:
            self._model = copy.copy(scene.mujoco)
            self._anchors, self._targets = label_anchors(scene), label_targets(scene)
            self._offsets = label_offsets(scene, self._camera)
        self._model.vis.global_.offwidth, self._model.vis.global_.offheight = size
        # The camera on the hand is close to the shadows.
        self._model.vis.quality.shadowsize = quality.shadow_pixels * (2 if camera == WRIST else 1)
        self._key = self._model.light(KEY_LIGHT).id
        self._key_direction = self._model.light_dir[self._key].copy()
        self._key_home = self._model.light_pos[self._key].copy()
        self._data = mujoco.MjData(self._model)
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = [group <= VISIBLE for group in range(mujoco.mjNGROUP)]
        self._option.sitegroup[:] = 0
        try:
            self._gl = gl_context(*size)
            self._gl.make_current()
            self._context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        except Exception as failure:
            raise RenderingError(no_gl(f"{type(failure).__name__}: {failure}")) from failure
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._drawn = mujoco.MjvScene(self._model, maxgeom=self._model.ngeom + 100)
        self._shown, self._dirty = np.empty((size[1], size[0], 3), dtype=np.uint8), None
        # A mounted camera sees everything move; shadows from other points of the lamp lie beside the one followed.
        if not self._camera.mounted and quality.samples == 1:
            self._dirty = DirtyRectangle(
                self._model, self._camera, self._key, None if scene.model.scene else scene.table
            )

    def __enter__(self) -> Painter:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Free the OpenGL context; otherwise, Mesa complains when the process ends."""
        self._context.free()
        self._gl.free()

    def frame(self, qpos: np.ndarray, *, glow: Sequence[str], share: float = 0.0) -> np.ndarray:
        """Return a picture, (height, width, 3) uint8, of a state when a share, 0 .. 1, of the video has passed.

        `qpos` are the (nq,) positions; `glow` are the marking locations at work.
        """
        for place in self._scene.model.locations:
            if place.marks:
                self._set_glow(place.name, glow_of(place.kind), on=place.name in glow)
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        picture = self._bare(share, glow)
        return picture if self._camera.mounted else self._labelled(picture, share)

    def _labelled(self, bare: np.ndarray, share: float) -> np.ndarray:
        anchors, targets = (
            dict(zip(points, self._camera.pixels(np.array([*points.values()]), share), strict=True))
            for points in (self._anchors, self._targets)
        )
        return draw_labels(bare, label_boxes(anchors, self._offsets, self._camera.size), anchors, targets)

    def _bare(self, share: float, glow: Sequence[str]) -> np.ndarray:
        """Return a picture of the current state with smooth edges, without labels.

        What cannot have changed since the last picture is kept from it.
        """
        view, size = self._camera.view(share), self._camera.size
        if self._dirty is None:
            return self._smooth(view, (0, 0, *size))
        look = (*view.lookat, view.azimuth, view.elevation, view.distance, *glow)
        left, top, right, bottom = self._dirty.update(self._data, share, look)
        if left < right and top < bottom:
            changed = _grown((left, top, right, bottom), size)
            seen = _grown(changed, size)
            fresh = self._smooth(view, seen)
            self._shown[changed[1] : changed[3], changed[0] : changed[2]] = fresh[
                changed[1] - seen[1] : changed[3] - seen[1], changed[0] - seen[0] : changed[2] - seen[0]
            ]
        return self._shown.copy()

    def _smooth(self, view: mujoco.MjvCamera, box: PixelBox) -> np.ndarray:
        """Return a box of a picture with smooth edges, its rim aside."""
        samples = self._quality.samples
        if samples == 1:
            return smooth_edges(self._painted(view, box))
        total = np.full((box[3] - box[1], box[2] - box[0], 3), samples // 2, dtype=np.uint16)
        for k in range(samples):
            self._move_key_light(k, samples)
            shift = (k + 0.5) / samples - 0.5, k * GOLDEN_ANGLE_RAD / np.pi % 1 - 0.5
            total += fill_specks(self._painted(view, box, shift=shift))
        return (total // samples).astype(np.uint8)

    def _painted(self, view: mujoco.MjvCamera, box: PixelBox, *, shift: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
        """Return a box of a rendering of the current state, shifted to the right and up by fractions of a pixel."""
        (width, height), (left, top, right, bottom) = self._camera.size, box
        area = mujoco.MjrRect(0, 0, right - left, bottom - top)
        pixels = np.empty((area.height, area.width, 3), dtype=np.uint8)
        mujoco.mj_camlight(self._model, self._data)
        mujoco.mjv_updateScene(
            self._model, self._data, self._option, None, view, mujoco.mjtCatBit.mjCAT_ALL, self._drawn
        )
        for eye in self._drawn.camera:
            pixel, highest = (eye.frustum_top - eye.frustum_bottom) / height, eye.frustum_top
            eye.frustum_center += ((left + right - width) / 2 + shift[0]) * pixel
            eye.frustum_bottom = highest + (shift[1] - bottom) * pixel
            eye.frustum_top = highest + (shift[1] - top) * pixel
        mujoco.mjr_render(area, self._drawn, self._context)
        mujoco.mjr_readPixels(pixels, None, area, self._context)
        return np.ascontiguousarray(pixels[::-1])

    def _move_key_light(self, k: int, samples: int) -> None:
        """Move the key light to the k-th of several sample points of a round lamp."""
        across = np.cross(self._key_direction, [0.0, 0.0, 1.0])
        across /= np.linalg.norm(across)
        radius = self._quality.lamp_radius_rad * np.sqrt((k + 0.5) / samples)
        angle = k * GOLDEN_ANGLE_RAD
        aside = np.cos(angle) * across + np.sin(angle) * np.cross(self._key_direction, across)
        direction = self._key_direction + radius * aside
        distance = np.linalg.norm(self._key_home - self._model.stat.center)
        self._model.light_dir[self._key] = direction / np.linalg.norm(direction)
        self._model.light_pos[self._key] = self._key_home - distance * radius * aside

    def _set_glow(self, location: str, glow: Glow, *, on: bool) -> None:
        name = f"{location}_glow"
        material, light = self._model.mat(name).id, self._model.light(name).id
        self._model.mat_rgba[material] = glow.on if on else glow.off
        self._model.mat_emission[material] = on
        self._model.light_active[light] = on
        self._model.light_diffuse[light] = glow.light


def _grown(box: PixelBox, size: tuple[int, int]) -> PixelBox:
    """Return a box and the pixels around it that smoothing mixes into it, within a picture of a size."""
    left, top, right, bottom = box
    return (
        max(0, left - MARGIN_PX),
        max(0, top - MARGIN_PX),
        min(size[0], right + MARGIN_PX),
        min(size[1], bottom + MARGIN_PX),
    )
