"""Names of the locations, written over the picture where the camera sees them."""

import functools
from collections.abc import Mapping

import numpy as np
from PIL import Image, ImageDraw, ImageFont

PixelBox = tuple[int, int, int, int]
"""Left, top, right and bottom, pixels."""

LETTERS = 0.037
"""Size of the font, as a share of the picture's height."""

PADDING = 0.3
"""Free space around the letters, in sizes of the font."""

INK = (250, 244, 232)
PLATE = (24, 20, 18, 205)
"""Colour and opacity of the plate behind a name."""

OVERSAMPLING = 3
"""Supersampling factor of plates, for smooth edges."""

ROUNDING_PX = 1.0
"""Greatest variation of a name's offset as the camera moves, since names are drawn at whole pixels."""

STEPS = 7
"""Number of distances from its anchor at which a name is tried, in steps of half the name's height."""

DIRECTIONS = 16
"""Number of directions from its anchor in which a name is tried."""


def place_labels(
    anchors: Mapping[str, np.ndarray], obstacles: np.ndarray, size: tuple[int, int]
) -> dict[str, np.ndarray]:
    """Return where to write names such that they overlap neither each other nor obstacles, as far as that is possible.

    Each keeps one offset, (2,) pixels from its anchor to its middle, in all V views of a video, so that it never jumps.

    Args:
        anchors: (V, 2) preferred pixel of each name.
        obstacles: (V, M, 4) boxes to keep clear: left, top, right, bottom.
        size: (width, height) of the picture.
    """
    offsets = dict[str, np.ndarray]()
    taken = np.empty((len(obstacles), 0, 4))
    # From the front to the back, since names in front can hide more.
    for name, anchor in sorted(anchors.items(), key=lambda item: -item[1][:, 1].mean()):
        possible = _offsets(_extent(name, size))
        boxes = _boxes(anchor[:, None] + possible, _extent(name, size), size)
        boxes[~_inside(anchor, size)] = 0.0
        # Other names matter most, then objects, then distance, by which the candidates are ordered.
        cost = (1e6 * overlaps(boxes, taken) + overlaps(boxes, obstacles)).sum(axis=0)
        best = int(cost.argmin())
        offsets[name] = possible[best]
        taken = np.concatenate([taken, boxes[:, [best]]], axis=1)
    return offsets


def label_boxes(
    anchors: Mapping[str, np.ndarray], offsets: Mapping[str, np.ndarray], size: tuple[int, int]
) -> dict[str, PixelBox]:
    """Return the box of each name whose (2,) anchor is in the picture, in one view, at its offset."""
    found: dict[str, PixelBox] = {}
    for name, anchor in anchors.items():
        if _inside(anchor, size):
            left, top, right, bottom = map(int, _boxes(anchor + offsets[name], _extent(name, size), size))
            found[name] = left, top, right, bottom
    return found


def draw_labels(
    frame: np.ndarray,
    placed: Mapping[str, PixelBox],
    anchors: Mapping[str, np.ndarray],
    targets: Mapping[str, np.ndarray],
) -> np.ndarray:
    """Return a frame with names, and a thin line from each name that is far from its anchor to its location.

    The boxes are from `label_boxes`, the (2,) anchors as there; targets are the (2,) pixels in the middle of locations.
    """
    picture = Image.fromarray(frame)
    draw = ImageDraw.Draw(picture)
    for name, box in placed.items():
        if np.linalg.norm(_nearest(box, anchors[name]) - anchors[name]) > box[3] - box[1] + ROUNDING_PX:
            x, y = map(float, targets[name])
            line = (x, y, *map(float, _nearest(box, targets[name])))
            draw.line(line, fill=PLATE[:3], width=4)
            draw.line(line, fill=INK, width=2)
            draw.ellipse((x - 4, y - 4, x + 4, y + 4), fill=INK, outline=PLATE[:3])
    for name, box in placed.items():
        plate = _plate(name, frame.shape[0])
        picture.paste(plate, box[:2], mask=plate)
    return np.asarray(picture)


def _nearest(box: PixelBox, point: np.ndarray) -> np.ndarray:
    """Return the (2,) point of a box that is nearest to another."""
    return np.clip(point, box[:2], box[2:])


def _extent(name: str, size: tuple[int, int]) -> np.ndarray:
    """Return (2,) width and height of a name on its plate."""
    return np.array(_plate(name, size[1]).size)


def _inside(points: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return whether each of (..., 2) points is in the picture."""
    return np.asarray(((points >= 0) & (points < size)).all(axis=-1))


def _offsets(extent: np.ndarray) -> np.ndarray:
    """Return (N, 2) pixels from an anchor to the middle of a name of an extent, the shortest first."""
    angles = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    # Below first, where a name is seldom taken for that of another location.
    ring = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    # Names are wide: scale the ring with their extent.
    rings = [ring * (extent / 2 + step * extent[1] / 2) for step in range(1, STEPS + 1)]
    return np.concatenate([np.zeros((1, 2)), *rings])


def _boxes(middles: np.ndarray, extent: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return (..., 4) boxes of an extent, centred at (..., 2) middles and then moved into the picture."""
    corner = np.clip(np.round(middles - extent / 2), 0, np.array(size) - extent)
    return np.concatenate([corner, corner + extent], axis=-1)


def overlaps(boxes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the (V, N) area that each of (V, N, 4) boxes shares with the (V, M, 4) others of its view."""
    shared = np.minimum(boxes[:, :, None, 2:], others[:, None, :, 2:])
    shared = shared - np.maximum(boxes[:, :, None, :2], others[:, None, :, :2])
    return shared.clip(min=0).prod(axis=-1).sum(axis=-1)


@functools.lru_cache(maxsize=256)
def _plate(text: str, height: int) -> Image.Image:
    """Return a name on a plate with round corners, for a picture of a height."""
    letters = LETTERS * height * OVERSAMPLING
    font = ImageFont.load_default(size=letters)
    padding = PADDING * letters
    size = round(font.getlength(text) + 2 * padding), round(1.25 * letters)
    large = Image.new("RGBA", size, (*PLATE[:3], 0))
    draw = ImageDraw.Draw(large)
    draw.rounded_rectangle((0, 0, size[0] - 1, size[1] - 1), radius=padding, fill=PLATE)
    draw.text((size[0] / 2, size[1] / 2), text, fill=INK, font=font, anchor="mm")
    return large.resize((max(1, size[0] // OVERSAMPLING), max(1, size[1] // OVERSAMPLING)), Image.Resampling.BOX)
