"""Antialiasing and removal of specks, at a twentieth of the cost of multisampling on a software renderer.

After Lottes, "FXAA" (NVIDIA white paper, 2009), simplified: blend each pixel on an edge with others along the edge.
"""

import numpy as np
from numba import njit
from PIL import Image

CONTRAST = 16
"""Least difference of brightness (0 .. 255) between neighbours that counts as an edge."""

REACH_PX = 8
"""Greatest length along an edge over which pixels are blended."""

SPECK = 6
"""A pixel darker than all its neighbours but one by more than this is a speck, an artefact of shadow maps."""

MARGIN_PX = REACH_PX + 2
"""Greatest distance between a pixel and those on which its smoothed colour depends."""


def smooth_edges(frame: np.ndarray) -> np.ndarray:
    """Return a (height, width, 3) uint8 frame with smooth edges; specks become the median of their neighbours."""
    return _blended(*_without_specks(frame))


def fill_specks(frame: np.ndarray) -> np.ndarray:
    """Return a (height, width, 3) uint8 frame without specks, its edges unchanged: for a mean of several frames."""
    return _without_specks(frame)[0]


def _without_specks(frame: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a frame and its (height, width) uint8 greys without specks, and the indices of pixels on edges."""
    width = frame.shape[1]
    frame, greys = frame.copy(), np.array(Image.fromarray(frame).convert("L"))
    pixels, shades = frame.reshape(-1, 3), greys.ravel()
    ring = np.array([-width - 1, -width, -width + 1, 1, width + 1, width, width - 1, -1])[:, None]
    at = _edges(greys)
    similar = (shades[at + ring] <= shades[at].astype(np.int16) + SPECK).sum(axis=0)
    specks = at[similar < 2]
    pixels[specks] = np.median(pixels[specks + ring], axis=0)
    shades[specks] = np.median(shades[specks + ring], axis=0)
    return frame, greys, at


def _edges(greys: np.ndarray) -> np.ndarray:
    """Return the indices of pixels in contrast to a neighbour, leaving out the picture's rim."""
    middle = greys[1:-1, 1:-1]
    high, low = middle, middle
    for side in (greys[:-2, 1:-1], greys[2:, 1:-1], greys[1:-1, :-2], greys[1:-1, 2:]):
        high, low = np.maximum(high, side), np.minimum(low, side)
    on_edge = np.zeros(greys.shape, dtype=bool)
    on_edge[1:-1, 1:-1] = high - low > np.maximum(CONTRAST, high >> 3)
    return np.flatnonzero(on_edge)


@njit(cache=True)
def _blended(pixels: np.ndarray, greys: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return pixels with each one on an edge blended with others along the edge."""
    height, width = greys.shape
    picture = pixels.copy()
    for index in at:
        y, x = divmod(index, width)
        upper_left, upper_right = float(greys[y - 1, x - 1]), float(greys[y - 1, x + 1])
        lower_left, lower_right = float(greys[y + 1, x - 1]), float(greys[y + 1, x + 1])
        down = lower_left + upper_left - lower_right - upper_right
        right = lower_left + lower_right - upper_left - upper_right
        bright = upper_left + upper_right + lower_left + lower_right
        scale = min(abs(down), abs(right)) + max(bright / 32, 2.0)
        down = min(max(down / scale, -REACH_PX), REACH_PX)
        right = min(max(right / scale, -REACH_PX), REACH_PX)
        for channel in range(3):
            total = 0.0
            for share in (-0.4, 0.0, 0.4):
                row = min(max(y + share * down, 0.0), height - 1.0)
                column = min(max(x + share * right, 0.0), width - 1.0)
                top, left = min(int(row), height - 2), min(int(column), width - 2)
                below, beside = row - top, column - left
                total += (1 - below) * (
                    (1 - beside) * pixels[top, left, channel] + beside * pixels[top, left + 1, channel]
                )
                total += below * (
                    (1 - beside) * pixels[top + 1, left, channel] + beside * pixels[top + 1, left + 1, channel]
                )
            picture[y, x, channel] = int(total / 3)
    return picture
