"""The picture on the table top: wood and an outline for every spot; for 3-D models, also the locations' names."""

import copy
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from prefplan.limits import check_limits
from sim.geometry.rectangle import Rectangle

TABLE_TOP = "tabletop"
"""Name of the picture's texture and material."""

PIXELS_PER_M = 1500
"""Resolution of the picture."""

MAX_SIDE_PX = 4096
"""Longest side of the picture, which is coarser where the table is longer than 2.7 m: it takes 25 bytes a pixel."""

PLANK_M = 0.13
"""Width of a plank, m."""

LETTERS_M = 0.026
"""Height of the names' letters, m."""


@dataclass(frozen=True)
class Marking:
    """What a location has on the table: a name, at its (2,) middle, and the (4, 2) corners of an outline or None, m."""

    location: str
    middle: np.ndarray
    outline: np.ndarray | None


def text_size(text: str) -> tuple[float, float]:
    """Return width and height of a printed name, m."""
    return ImageFont.load_default(size=100).getlength(text) / 100 * LETTERS_M, LETTERS_M


def with_names(
    model: mujoco.MjModel, table: Rectangle, markings: Sequence[Marking], show: Callable[[str], str]
) -> mujoco.MjModel:
    """Return a copy of a scene's model with names on its table, where none can be written over the picture.

    `show` returns what people are shown for a location.
    """
    shown = copy.copy(model)
    if markings:
        start = int(shown.texture(TABLE_TOP).adr[0])
        pixels = picture(table, markings, show).ravel()
        shown.tex_data[start : start + len(pixels)] = pixels
    return shown


def picture(table: Rectangle, markings: Sequence[Marking], show: Callable[[str], str] | None = None) -> np.ndarray:
    """Return the texture of the table top, (W, H, 3) uint8; rows run along +y, columns along +x.

    `show` returns the text to print for a location; None to print the outlines alone.
    """
    scale = min(PIXELS_PER_M, MAX_SIDE_PX / (2 * float(table.half.max())))
    width, height = (round(2 * float(side) * scale) for side in table.half[::-1])
    image = Image.fromarray(_wood(width, height))

    def pixels(points: np.ndarray) -> list[tuple[float, float]]:
        return [(y, x) for x, y in (points - (table.centre - table.half)) * scale]

    ink = Image.new("L", image.size, 0)
    draw = ImageDraw.Draw(ink)
    font = ImageFont.load_default(size=max(1.0, LETTERS_M * scale))
    for marking in markings:
        if marking.outline is not None:
            corners = pixels(np.concatenate([marking.outline, marking.outline[:2]]))
            draw.line(corners, fill=140, width=max(1, round(0.0016 * scale)), joint="curve")
        if show is not None:
            draw.text(pixels(marking.middle[None])[0], show(marking.location), fill=215, font=font, anchor="mm")
    image.paste(Image.new("RGB", image.size, (250, 244, 232)), mask=ink)
    return np.asarray(image).transpose(1, 0, 2)


@lru_cache(maxsize=2)  # drawing wood takes a fifth of the time of building a scene
def _wood(width: int, height: int) -> np.ndarray:
    """Return (height, width, 3) planks along the rows, each with its own tone and grain."""
    rng = np.random.default_rng(3)
    plank, colour = round(PLANK_M * PIXELS_PER_M), np.array([0.50, 0.365, 0.255], dtype=np.float32)
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
