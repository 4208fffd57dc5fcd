"""The picture on the table top: wood, an outline for every spot, and the locations' names."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from PIL import Image, ImageDraw, ImageFont

PIXELS = 2048
"""Pixels along the longer side of the table, about 1.5 a millimetre."""

WOOD = np.array([0.50, 0.365, 0.255])
"""Mean colour of the wood."""

INK = (250, 244, 232)
"""Colour of outlines and names."""

PLANK = 0.13
"""Width of a plank, m."""

LETTERS = 0.026
"""Height of the names' letters, m."""


@dataclass(frozen=True)
class Table:
    """The rectangle of the table top, m: x towards the front, y to the robot's left."""

    x: tuple[float, float]
    y: tuple[float, float]

    @property
    def centre(self) -> np.ndarray:
        """(2,) its middle, m."""
        return np.array([sum(self.x) / 2, sum(self.y) / 2])

    @property
    def half(self) -> np.ndarray:
        """(2,) half its sides, m."""
        return np.array([self.x[1] - self.x[0], self.y[1] - self.y[0]]) / 2


@dataclass(frozen=True)
class Marking:
    """What is printed on the table for one location.

    Attributes:
        text: its name.
        middle: (2,) middle of the text, m.
        outlines: (4, 2) corners of squares to outline, m.
    """

    text: str
    middle: np.ndarray
    outlines: tuple[np.ndarray, ...]


def text_size(text: str) -> tuple[float, float]:
    """Return width and height of a printed name, m."""
    return ImageFont.load_default(size=100).getlength(text) / 100 * LETTERS, LETTERS


def picture(table: Table, markings: list[Marking]) -> np.ndarray:
    """Return the table top as seen by someone in front of it, robot at the far side.

    Returns:
        (height, width, 3) uint8; columns run along +y, rows along +x.
    """
    scale = PIXELS / (2 * table.half.max())
    width, height = (int(round(2 * side * scale)) for side in table.half[::-1])
    image = Image.fromarray(_wood(width, height, scale))
    ink = Image.new("L", image.size, 0)
    draw = ImageDraw.Draw(ink)
    font = ImageFont.load_default(size=LETTERS * scale)
    for marking in markings:
        for corners in marking.outlines:
            points = [_pixel(table, scale, corner) for corner in (*corners, corners[0], corners[1])]
            draw.line(points, fill=140, width=max(1, round(0.0016 * scale)), joint="curve")
        draw.text(_pixel(table, scale, marking.middle), marking.text, fill=215, font=font, anchor="mm")
    image.paste(Image.new("RGB", image.size, INK), mask=ink)
    return np.asarray(image)


def _pixel(table: Table, scale: float, point: np.ndarray) -> tuple[float, float]:
    return (point[1] - table.y[0]) * scale, (point[0] - table.x[0]) * scale


@lru_cache(maxsize=4)  # half of the time that a scene takes
def _wood(width: int, height: int, scale: float) -> np.ndarray:
    """Return planks along the rows, each its own tone and stretch of grain."""
    rng = np.random.default_rng(3)
    plank = max(1, round(PLANK * scale))
    tone = np.zeros((height, width), dtype=np.float32)
    for top in range(0, height, plank):
        rows = min(plank, height - top)
        warp = _noise(rng, (4, 6), (width, rows))
        rings = np.sin(2 * np.pi * (np.linspace(0, 3.0, rows)[:, None] + 1.6 * warp + rng.uniform(0, 1)))
        fibre = _noise(rng, (rows, 24), (width, rows))
        fine = _noise(rng, (rows, 160), (width, rows))
        tone[top : top + rows] = 0.035 * rings + 0.07 * fibre + 0.035 * fine + rng.uniform(-0.05, 0.05)
        tone[top : top + 2] -= 0.22
    return (255 * np.clip(WOOD * (1 + tone[..., None]), 0, 1)).astype(np.uint8)


def _noise(rng: np.random.Generator, cells: tuple[int, int], size: tuple[int, int]) -> np.ndarray:
    grid = Image.fromarray(rng.uniform(-1, 1, cells).astype(np.float32))
    return np.asarray(grid.resize(size, Image.Resampling.BICUBIC))
