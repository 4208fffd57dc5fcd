"""Arrays of a log as integers that compress well: second differences of neighbouring rows, column by column."""

from __future__ import annotations

import numpy as np

ORDER = 2
"""How often neighbouring rows are subtracted: what moves evenly becomes zeros."""


def pack(rows: np.ndarray, *, scale: int = 1) -> np.ndarray:
    """Return (T, ...) rows, times a scale and rounded, as (..., T) integers that `unpack` reads.

    Args:
        rows: numbers whose scaled values are below 2**60.
        scale: how many units of the integers are one.
    """
    columns = np.rint(rows * scale).astype(np.int64).T
    zeros = np.zeros((*columns.shape[:-1], ORDER), dtype=np.int64)
    differences = np.diff(columns, n=ORDER, axis=-1, prepend=zeros)
    most = int(np.abs(differences).max(initial=0))
    return differences.astype(
        next(kind for kind in (np.int8, np.int16, np.int32, np.int64) if most <= np.iinfo(kind).max)
    )


def unpack(columns: np.ndarray, *, scale: int = 1) -> np.ndarray:
    """Return the rows that `pack` was given: integers for a scale of 1, otherwise floats."""
    sums = columns.astype(np.int64)
    for _ in range(ORDER):
        sums = np.cumsum(sums, axis=-1)
    rows = np.ascontiguousarray(sums.T)
    return rows if scale == 1 else rows / scale
