"""A small second view of the scene, in the corner of the picture where it hides least."""

from __future__ import annotations

import numpy as np

from sim.rendering.cameras import Camera
from sim.rendering.framing import hand_corners, object_corners
from sim.rendering.labels import PixelBox, overlaps
from sim.world.scene import Scene

INSETS = ("wrist", "top")
"""Views that an inset may have; written after the camera, such as `fixed+wrist`."""

SHARE = 0.2
"""Width of an inset, as a share of the picture's; its aspect ratio is 16 to 9."""

FRAME = (245, 246, 248)
"""Colour of the line round an inset."""


def inset_box(scene: Scene, camera: Camera) -> PixelBox:
    """Return the box in a corner where an inset hides least of the objects and the hand, in all views of a camera."""
    width = round(SHARE * camera.size[0])
    free = np.array(camera.size) - (width, height := round(width * 9 / 16))
    corners = np.array([(free[0], free[1]), (0, free[1]), (free[0], 0), (0, 0)])
    if camera.mounted:
        left, top = corners[0]  # the palm and the fingers are in the upper half
    else:
        points = np.concatenate([object_corners(scene), hand_corners(scene)]).reshape(-1, 3)
        seen = np.stack([camera.pixels(points, share).reshape(-1, 8, 2) for share in camera.shares()])
        boxes = np.broadcast_to(np.concatenate([corners, corners + (width, height)], axis=1), (len(seen), 4, 4))
        covered = overlaps(boxes, np.concatenate([seen.min(axis=2), seen.max(axis=2)], axis=2)).max(axis=0)
        left, top = corners[int(covered.argmin())]
    return int(left), int(top), int(left) + width, int(top) + height


def with_inset(picture: np.ndarray, small: np.ndarray, box: PixelBox) -> np.ndarray:
    """Return a picture with a small one in a box, framed by a line.

    Args:
        picture: (height, width, 3) uint8.
        small: (bottom - top, right - left, 3) uint8.
        box: of the small picture.
    """
    left, top, right, bottom = box
    line = max(1, round(picture.shape[0] / 360))
    whole = picture.copy()
    whole[top:bottom, left:right] = FRAME
    whole[top + line : bottom - line, left + line : right - line] = small[line:-line, line:-line]
    return whole
