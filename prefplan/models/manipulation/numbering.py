"""Consecutive numbers for state codes, in the order in which they are found."""

from __future__ import annotations

import numpy as np

MAX_TABLE_CODES = 2**28
"""Greatest number of possible codes for which a table of all of them is kept."""


class Numbering:
    """The numbers of codes, and the codes by number."""

    def __init__(self, bound: int) -> None:
        """Begin with none; codes are less than a bound."""
        self._layers: list[np.ndarray] = []
        self._count = 0
        self._index = np.full(bound, -1, dtype=np.int32) if bound <= MAX_TABLE_CODES else None
        self._sorted = np.empty(0, dtype=np.int64)

    @property
    def all(self) -> np.ndarray:
        """All codes, by number."""
        return np.concatenate(self._layers)

    def add(self, codes: np.ndarray) -> np.ndarray:
        """Number codes that are new, smallest first, and return them."""
        if self._index is not None:
            new = np.unique(codes[self._index[codes] < 0])
            self._index[new] = np.arange(self._count, self._count + len(new), dtype=np.int32)
        else:
            new = np.setdiff1d(codes, self._sorted)
            self._sorted = np.union1d(self._sorted, new)
        self._layers.append(new)
        self._count += len(new)
        return new

    def number(self, codes: np.ndarray) -> np.ndarray:
        """Return the numbers of codes."""
        if self._index is not None:
            return self._index[codes]
        rank = np.argsort(self.all)
        return rank[np.searchsorted(self.all, codes, sorter=rank)]
