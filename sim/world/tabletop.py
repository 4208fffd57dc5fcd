"""The picture on the table top: wood; for 3-D models, also the locations' names."""

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from prefplan.limits import check_limits
from sim.geometry.rectangle import Rectangle

TABLE_TOP = "tabletop"
"""Name of the picture's texture and material."""

PIXELS_PER_M = 1500
"""Resolution of the picture."""

MAX_SIDE_PX = 4096
"""Longest side of the picture, pixels of 25 bytes; for a table longer than 2.7 m, the resolution is lower."""

PLANK_M = 0.13
"""Width of a plank, m."""

LETTERS_M = 0.026
"""Height of the letters of a name, m."""

INK = (221, 214, 201)
"""Colour of the letters."""


def text_size(text: str) -> tuple[float, float]:
    """Return width and height of a printed name, m."""
    return ImageFont.load_default(size=100).getlength(text) / 100 * LETTERS_M, LETTERS_M


def picture(table: Rectangle, names: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the texture of the table top, (W, H, 3) uint8; rows run along +y, columns along +x.

    `names` has the (2,) middle of each name to print, m.
    """
    scale = min(PIXELS_PER_M, MAX_SIDE_PX / (2 * float(table.half.max())))
    width, height = (round(2 * float(side) * scale) for side in table.half[::-1])
    image = Image.fromarray(_wood(width, height, round(PLANK_M * scale)))
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(size=max(1.0, LETTERS_M * scale))
    for name, middle in names.items():
        x, y = map(float, (middle - (table.centre - table.half)) * scale)
        draw.text((y, x), name, fill=INK, font=font, anchor="mm")
    return np.asarray(image).transpose(1, 0, 2)


@lru_cache(maxsize=2)  # drawing wood takes a fifth of the time of building a scene
def _wood(width: int, height: int, plank: int) -> np.ndarray:
    """Return (height, width, 3) planks along the rows, `plank` pixels wide, each with its own tone and grain."""
    rng, colour = np.random.default_rng(3), np.array([0.50, 0.365, 0.255], dtype=np.float32)
    wood = np.empty((height, width, 3), dtype=np.uint8)
    growth = np.linspace(0, 3.0, plank, dtype=np.float32)[:, None]
    for top in range(0, height, plank):
        check_limits()
        warp = _noise(rng, (4, 2 + width // 700), (width, plank))
        rings = np.sin(2 * np.pi * (growth + 1.6 * warp + rng.uniform(0, 1)))
        fibre = _noise(rng, (plank, 2 + width // 170), (width, plank))
        fine = _noise(rng, (plank, 2 + width // 25), (width, plank))
        tone = 0.035 * rings + 0.07 * fibre + 0.035 * fine + rng.uniform(-0.05, 0.05)
        tone[:2] -= 0.22
        wood[top : top + plank] = 255 * np.clip(colour * (1 + tone[: height - top, :, None]), 0, 1)
    return wood


def _noise(rng: np.random.Generator, cells: tuple[int, int], size: tuple[int, int]) -> np.ndarray:
    """Return smooth noise in -1 .. 1: (rows, columns) random cells, enlarged to (width, height) pixels."""
    grid = Image.fromarray(rng.uniform(-1, 1, cells).astype(np.float32))
    return np.asarray(grid.resize(size, Image.Resampling.BICUBIC))
