"""Smooth edges without the price of multisampling, which costs a software renderer more than the picture itself.

After Lottes, "FXAA" (NVIDIA white paper, 2009): find pixels on an edge, walk along it to both of its ends, and blend
each with the pixel across by how far along it lies. Specks of one or two pixels, which shadow maps leave, are filled.
"""

from __future__ import annotations

import numpy as np
from PIL import Image

CONTRAST = 16
"""Least difference of brightness (0 .. 255) between neighbours that counts as an edge."""

STEPS = 8
"""How far to walk along an edge, pixels."""

SPECK = 6
"""A pixel darker than all its neighbours but one by more than this is a speck."""


def smooth_edges(frame: np.ndarray) -> np.ndarray:
    """Return a frame with smooth edges.

    Args:
        frame: (height, width, 3) uint8.
    """
    height, width, _ = frame.shape
    shades = np.asarray(Image.fromarray(frame).convert("L"))
    at = _edges(shades)
    bright = shades.ravel()
    middle, up, down, left, right = (bright[at + d].astype(np.float32) for d in (0, -width, width, -1, 1))
    diagonal = [bright[at + d].astype(np.float32) for d in (-width - 1, -width + 1, width - 1, width + 1)]
    level = (
        2 * abs(up + down - 2 * middle)
        + abs(diagonal[0] + diagonal[2] - 2 * left)
        + abs(diagonal[1] + diagonal[3] - 2 * right)
    ) >= (
        2 * abs(left + right - 2 * middle)
        + abs(diagonal[0] + diagonal[1] - 2 * up)
        + abs(diagonal[2] + diagonal[3] - 2 * down)
    )
    before, after = np.where(level, up, left), np.where(level, down, right)
    steeper = abs(before - middle) >= abs(after - middle)
    across = np.where(level, width, 1) * np.where(steeper, -1, 1)
    along = np.where(level, 1, width)
    mean = 0.5 * (middle + np.where(steeper, before, after))
    slack = 0.25 * np.maximum(abs(before - middle), abs(after - middle))
    ends = [_walk(bright, at, sign * along, across, mean, slack) for sign in (-1, 1)]
    nearer = np.where(ends[0][0] < ends[1][0], ends[0][1], ends[1][1])
    share = 0.5 - np.minimum(ends[0][0], ends[1][0]) / (ends[0][0] + ends[1][0])
    share = np.where((middle < mean) != (nearer < 0), share, 0.0).astype(np.float32)[:, None]
    pixels = frame.reshape(-1, 3)
    smooth = frame.copy().reshape(-1, 3)
    smooth[at] = pixels[at] * (1 - share) + pixels[at + across] * share
    around = np.partition([up, down, left, right, *diagonal], 1, axis=0)
    specks = at[around[1] > middle + SPECK]
    ring = [-width - 1, -width, -width + 1, -1, 1, width - 1, width, width + 1]
    smooth[specks] = np.median([pixels[specks + step] for step in ring], axis=0)
    return smooth.reshape(frame.shape)


def _edges(shades: np.ndarray) -> np.ndarray:
    """Return the flat indices of pixels in contrast to a neighbour, leaving out the picture's rim."""
    width, flat = shades.shape[1], shades.ravel()
    end = len(flat) - width
    high = low = flat[width:end]
    for step in (-width, width, -1, 1):
        side = flat[width + step : end + step]
        high, low = np.maximum(high, side), np.minimum(low, side)
    at = np.flatnonzero(high - low > np.maximum(CONTRAST, high >> 3)) + width
    column = at % width
    return at[(column > 0) & (column < width - 1)]


def _walk(
    bright: np.ndarray,
    at: np.ndarray,
    along: np.ndarray,
    across: np.ndarray,
    mean: np.ndarray,
    slack: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Follow edges until the brightness astride them changes.

    Returns:
        How many pixels away each edge ends (`STEPS` at most), and by how much the brightness differs there.
    """
    distance = np.full(len(at), float(STEPS), dtype=np.float32)
    difference = np.zeros(len(at), dtype=np.float32)
    walking = np.arange(len(at))
    for step in range(1, STEPS + 1):
        here = np.clip(at[walking] + step * along[walking], 0, len(bright) - 1)
        beside = np.clip(here + across[walking], 0, len(bright) - 1)
        apart = 0.5 * (bright[here].astype(np.float32) + bright[beside]) - mean[walking]
        difference[walking] = apart
        ended = abs(apart) >= slack[walking]
        distance[walking[ended]] = step
        walking = walking[~ended]
    return distance, difference
