"""Label placement on maps: near what a label names, without overlaps, and off what should stay visible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

STEPS = 48
"""Number of positions tried along each axis of the frame."""

BESIDE, PER_LINE = 2.0, 1.5
"""Penalties of a position outside its target, and per distance of one line height from it."""

PATH, AREA, DOT = 1.0, 2.0, 40.0
"""Penalties of covering a point of a path, an area and a mark."""


@dataclass(frozen=True)
class MapLabel:
    """A label to place; rectangles are (left, low, right, high).

    Attributes:
        size: width and height.
        target: (4,) rectangle that it names.
        inside: whether the label may lie in that rectangle; otherwise it must lie beside it.
    """

    size: tuple[float, float]
    target: np.ndarray
    inside: bool


Obstacle = tuple[np.ndarray, float]
"""What labels should not cover: its (4,) rectangle, and the penalty of covering it."""


def place(
    labels: Sequence[MapLabel], frame: np.ndarray, obstacles: Sequence[Obstacle], *, line: float
) -> list[np.ndarray | None]:
    """Return the rectangle of each label, None if it would overlap another label at every position.

    Labels with little space are placed first, each at the free position of least penalty. All coordinates are those of
    the (4,) frame, which no label leaves; `line` is the height of a line of text.
    """
    taken: list[np.ndarray] = []
    places: list[np.ndarray | None] = [None] * len(labels)
    covered, costs = (np.array([one[k] for one in obstacles]) for k in (0, 1))
    for i in sorted(range(len(labels)), key=lambda i: (labels[i].inside, _area(labels[i].target))):
        rectangles = _candidates(labels[i], frame)
        if taken:
            rectangles = rectangles[~_overlaps(rectangles, np.array(taken)).any(axis=1)]
        if len(rectangles):
            penalties = _penalties(rectangles, labels[i], line)
            if len(covered):
                others = (covered != labels[i].target).any(axis=1)
                penalties += _overlaps(rectangles, covered[others]) @ costs[others]
            places[i] = best = rectangles[np.argmin(penalties)]
            taken.append(best)
    return places


def leader(rectangle: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Return the (2, 2) ends of a leader line from a label to its target, which ends slightly inside the target."""
    middle = (target[:2] + target[2:]) / 2
    start = np.clip(middle, rectangle[:2], rectangle[2:])
    return np.array([start, np.clip(start, *_shrunk(target))])


def gap(rectangles: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Return the (R,) distances of (R, 4) rectangles from a (4,) target."""
    apart = np.maximum(rectangles[:, :2] - target[2:], target[:2] - rectangles[:, 2:]).clip(min=0)
    return np.hypot(*apart.T)


def _shrunk(target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    inset = np.minimum(4.0, (target[2:] - target[:2]) / 2)
    return target[:2] + inset, target[2:] - inset


def _area(rectangle: np.ndarray) -> float:
    return float(np.prod(rectangle[2:] - rectangle[:2]))


def _candidates(label: MapLabel, frame: np.ndarray) -> np.ndarray:
    """Return (R, 4) candidate rectangles of a label in the frame: on a grid, and around its target."""
    low, high = frame[:2], frame[2:] - label.size
    if (high < low).any():
        return np.empty((0, 4))
    left, bottom, right, top = label.target
    width, height = label.size
    near = (
        (left, (left + right - width) / 2, right - width, left - width, right),
        (bottom - height, bottom, top - height, top),
    )
    x, y = (
        np.unique(np.concatenate([np.linspace(a, b, STEPS), np.clip(places, a, b)]))
        for a, b, places in zip(low, high, near, strict=True)
    )
    corners = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    rectangles = np.hstack([corners, corners + label.size])
    return rectangles if label.inside else rectangles[~_overlaps(rectangles, label.target[None])[:, 0]]


def _overlaps(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return for (R, 4) and (S, 4) rectangles which overlap, (R, S)."""
    one = one[:, None]
    beside = (one[..., 0] < other[:, 2]) & (other[:, 0] < one[..., 2])
    return np.asarray(beside & (one[..., 1] < other[:, 3]) & (other[:, 1] < one[..., 3]))


def _penalties(rectangles: np.ndarray, label: MapLabel, line: float) -> np.ndarray:
    """Return the (R,) penalties of (R, 4) rectangles for where they lie beside the label's target."""
    left, low, right, high = label.target
    within = (rectangles[:, :2] >= (left, low)).all(axis=1) & (rectangles[:, 2:] <= (right, high)).all(axis=1)
    # Inside an area, prefer its upper left corner, where a reader looks first.
    corner = np.hypot(rectangles[:, 0] - left, rectangles[:, 3] - high) / line
    return np.where(within, 0.05 * corner, BESIDE + PER_LINE * gap(rectangles, label.target) / line)
