"""Label placement on maps: near what a label names, without overlaps, and off what should stay visible."""

from collections.abc import Sequence

import numpy as np

STEPS = 48
"""Number of positions tried along each axis of the frame."""

BESIDE = 2.0
"""Penalty of a label outside its target."""

PER_LINE = 1.5
"""Penalty of a label's distance from its target, per height of a text line."""

PATH = 1.0
"""Penalty of covering a point of a path."""

AREA = 2.0
"""Penalty of covering an area."""

DOT = 40.0
"""Penalty of covering a mark."""

Obstacle = tuple[np.ndarray, float]
"""What labels should not cover: its (4,) rectangle, and the penalty of covering it."""


def place(
    sizes: np.ndarray,
    targets: np.ndarray,
    inside: Sequence[bool],
    frame: np.ndarray,
    obstacles: Sequence[Obstacle],
    *,
    line: float,
) -> list[np.ndarray | None]:
    """Return the rectangle of each label, None if it would overlap another label at every position.

    Labels with little space are placed first, each at the free position of least penalty.

    Args:
        sizes: (L, 2) widths and heights.
        targets: (L, 4) rectangles (left, low, right, high) that the labels name.
        inside: whether each label may lie in its target; otherwise it must lie beside it.
        frame: (4,) rectangle that no label leaves.
        obstacles: what labels should not cover; for a label, its own target does not count.
        line: height of a line of text.
    """
    taken: list[np.ndarray] = []
    places: list[np.ndarray | None] = [None] * len(sizes)
    covered, costs = (np.array([one[k] for one in obstacles]) for k in (0, 1))
    for i in sorted(range(len(sizes)), key=lambda i: (inside[i], np.prod(targets[i, 2:] - targets[i, :2]))):
        rectangles = _candidates(sizes[i], targets[i], frame)
        for kept_off in (taken, [] if inside[i] else [targets[i]]):
            if kept_off:
                rectangles = rectangles[~_overlaps(rectangles, np.array(kept_off)).any(axis=1)]
        if len(rectangles):
            penalties = _penalties(rectangles, targets[i], line)
            if len(covered):
                others = (covered != targets[i]).any(axis=1)
                penalties += _overlaps(rectangles, covered[others]) @ costs[others]
            places[i] = best = rectangles[np.argmin(penalties)]
            taken.append(best)
    return places


def gap(rectangles: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Return the (R,) distances of (R, 4) rectangles from a (4,) target."""
    apart = np.maximum(rectangles[:, :2] - target[2:], target[:2] - rectangles[:, 2:]).clip(min=0)
    return np.hypot(*apart.T)


def _candidates(size: np.ndarray, target: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """Return (R, 4) rectangles of a size in the frame: on a grid, and around the target."""
    low, high = frame[:2], frame[2:] - size
    if (high < low).any():
        return np.empty((0, 4))
    (left, bottom, right, top), (width, height) = target, size
    near = (
        (left, (left + right - width) / 2, right - width, left - width, right),
        (bottom - height, bottom, top - height, top),
    )
    x, y = (
        np.unique(np.concatenate([np.linspace(a, b, STEPS), np.clip(places, a, b)]))
        for a, b, places in zip(low, high, near, strict=True)
    )
    corners = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return np.hstack([corners, corners + size])


def _overlaps(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return for (R, 4) and (S, 4) rectangles which overlap, (R, S)."""
    one = one[:, None]
    beside = (one[..., 0] < other[:, 2]) & (other[:, 0] < one[..., 2])
    return np.asarray(beside & (one[..., 1] < other[:, 3]) & (other[:, 1] < one[..., 3]))


def _penalties(rectangles: np.ndarray, target: np.ndarray, line: float) -> np.ndarray:
    """Return the (R,) penalties of (R, 4) rectangles for where they lie beside a (4,) target."""
    left, low, right, high = target
    within = (rectangles[:, :2] >= (left, low)).all(axis=1) & (rectangles[:, 2:] <= (right, high)).all(axis=1)
    # Inside an area, prefer its upper left corner, where a reader looks first.
    corner = np.hypot(rectangles[:, 0] - left, rectangles[:, 3] - high) / line
    return np.where(within, 0.05 * corner, BESIDE + PER_LINE * gap(rectangles, target) / line)
