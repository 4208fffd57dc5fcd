"""Antialiasing and removal of specks, at a quarter of the cost of multisampling on a software renderer.

After Lottes, "FXAA" (NVIDIA white paper, 2009), simplified: blend each pixel on an edge with others along the edge.
"""

from __future__ import annotations

import numpy as np
from PIL import Image
from scipy.ndimage import map_coordinates

CONTRAST = 16
"""Least difference of brightness (0 .. 255) between neighbours that counts as an edge."""

REACH_PX = 8
"""Greatest length along an edge over which pixels are blended."""

SPECK = 6
"""A pixel darker than all its neighbours but one by more than this is a speck, an artefact of shadow maps."""


def smooth_edges(frame: np.ndarray) -> np.ndarray:
    """Return a frame with smooth edges and each speck replaced by the median of its neighbours.

    Args:
        frame: (height, width, 3) uint8.
    """
    width = frame.shape[1]
    pixels, shades, at, ring = _without_specks(frame)
    upper_left, _, upper_right, _, lower_right, _, lower_left, _ = shades[at + ring].astype(np.float32)
    along = np.stack(
        [lower_left + upper_left - lower_right - upper_right, lower_left + lower_right - upper_left - upper_right]
    )
    bright = upper_left + upper_right + lower_left + lower_right
    along = np.clip(along / (abs(along).min(axis=0) + np.maximum(bright / 32, 2)), -REACH_PX, REACH_PX)
    shares = np.array([-0.4, 0.0, 0.4])[:, None]
    places = [at // width + shares * along[0], at % width + shares * along[1]]
    picture = pixels.reshape(frame.shape)
    colours = [map_coordinates(picture[..., i], places, np.float32, order=1, mode="nearest") for i in range(3)]
    pixels[at] = np.mean(colours, axis=1).T
    return picture


def fill_specks(frame: np.ndarray) -> np.ndarray:
    """Return a frame without specks, its edges unchanged: for a mean of several frames.

    Args:
        frame: (height, width, 3) uint8.
    """
    return _without_specks(frame)[0].reshape(frame.shape)


def _without_specks(frame: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return (N, 3) pixels and (N,) greys without specks, the indices of edges, and offsets to a pixel's neighbours."""
    width = frame.shape[1]
    pixels = frame.reshape(-1, 3).copy()
    shades = np.asarray(Image.fromarray(frame).convert("L")).ravel().copy()
    ring = np.array([-width - 1, -width, -width + 1, 1, width + 1, width, width - 1, -1])[:, None]
    at = _edges(shades, width)
    around = shades[at + ring]
    specks = at[np.partition(around, 1, axis=0)[1] > shades[at].astype(int) + SPECK]
    pixels[specks] = np.median(pixels[specks + ring], axis=0)
    shades[specks] = np.median(shades[specks + ring], axis=0)
    return pixels, shades, at, ring


def _edges(shades: np.ndarray, width: int) -> np.ndarray:
    """Return the indices of pixels in contrast to a neighbour, leaving out the picture's rim."""
    end = len(shades) - width
    middle = shades[width:end]
    sides = [shades[width + step : end + step] for step in (-width, width, -1, 1)]
    high, low = middle, middle
    for side in sides:
        high, low = np.maximum(high, side), np.minimum(low, side)
    at = np.flatnonzero(high - low > np.maximum(CONTRAST, high >> 3)) + width
    return at[(at % width > 0) & (at % width < width - 1)]
