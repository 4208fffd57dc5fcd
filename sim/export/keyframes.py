"""Keyframes of a motion: samples between which interpolation stays within a tolerance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

POSITION_TOLERANCE_M = 2e-5
"""Greatest distance of an interpolated position from the recorded one."""

ANGLE_TOLERANCE_RAD = 5e-6
"""Greatest angle between an interpolated and the recorded rotation; over seven joints and 0.86 m, less than 0.03 mm."""

Errors = Callable[[int, int], np.ndarray]
"""Function that returns the interpolation error of every sample between two keyframes."""


def position_keys(times: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Return the indices of the keyframes between which straight lines stay within `POSITION_TOLERANCE_M`.

    Args:
        times: (T,) s, increasing.
        positions: (T, 3) m.
    """

    def errors(first: int, last: int) -> np.ndarray:
        between = slice(first + 1, last)
        share = ((times[between] - times[first]) / (times[last] - times[first]))[:, None]
        line = positions[first] + share * (positions[last] - positions[first])
        return np.linalg.norm(line - positions[between], axis=1)

    return _keys(len(times), errors, POSITION_TOLERANCE_M)


def rotation_keys(times: np.ndarray, quaternions: np.ndarray) -> np.ndarray:
    """Return the indices of the keyframes between which spherical interpolation stays within `ANGLE_TOLERANCE_RAD`.

    Args:
        times: (T,) s, increasing.
        quaternions: (T, 4) of length 1, w first.
    """

    def errors(first: int, last: int) -> np.ndarray:
        between = slice(first + 1, last)
        share = (times[between] - times[first]) / (times[last] - times[first])
        begin, end = quaternions[first], quaternions[last]
        end = end if begin @ end >= 0 else -end  # the shorter way round
        whole = _angles(begin, end) / (2 * np.pi)  # between the quaternions, in units of pi, as np.sinc expects
        shares = np.stack([1 - share, share], axis=1)
        arc = shares * np.sinc(shares * whole) / np.sinc(whole) @ np.stack([begin, end])
        return _angles(arc, quaternions[between])

    return _keys(len(times), errors, ANGLE_TOLERANCE_RAD)


def _angles(ones: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the angles between rotations, rad; `q` and `-q` are the same rotation."""
    chords = np.minimum(np.linalg.norm(ones - others, axis=-1), np.linalg.norm(ones + others, axis=-1))
    return 4 * np.arcsin(chords / 2)


def _keys(count: int, errors: Errors, tolerance: float) -> np.ndarray:
    """Return keyframes, first and last included: split each interval at its worst sample (Douglas-Peucker)."""
    keys = {0, count - 1}
    stretches = [(0, count - 1)]
    while stretches:
        first, last = stretches.pop()
        if last - first < 2:
            continue
        found = errors(first, last)
        if found.max() > tolerance:
            worst = first + 1 + int(found.argmax())
            keys.add(worst)
            stretches += [(first, worst), (worst, last)]
    return np.array(sorted(keys))
