"""Numbers of codes, in the order in which they are found."""

from __future__ import annotations

import numpy as np

MAX_TABLE_CODES = 2**24
"""Greatest number of possible codes for which a table of all of them is kept."""


class Numbering:
    """The numbers of codes, and the codes by number."""

    def __init__(self, bound: int) -> None:
        """Begin with none; codes are less than a bound."""
        self._layers: list[np.ndarray] = []
        self._count = 0
        self._index = np.full(bound, -1, dtype=np.int32) if bound <= MAX_TABLE_CODES else None
        self._sorted = np.empty(0, dtype=np.int64)
        self._numbers = np.empty(0, dtype=np.int32)

    def __len__(self) -> int:
        """Return how many codes have numbers."""
        return self._count

    @property
    def all(self) -> np.ndarray:
        """All codes, by number."""
        return np.concatenate(self._layers)

    def add(self, codes: np.ndarray) -> np.ndarray:
        """Number codes that are new, smallest first, and return them."""
        codes = np.unique(codes)
        new = codes[self.number(codes) < 0]
        numbers = np.arange(self._count, self._count + len(new), dtype=np.int32)
        if self._index is not None:
            self._index[new] = numbers
        else:
            places = np.searchsorted(self._sorted, new)
            self._sorted = np.insert(self._sorted, places, new)
            self._numbers = np.insert(self._numbers, places, numbers)
        self._layers.append(new)
        self._count += len(new)
        return new

    def number(self, codes: np.ndarray) -> np.ndarray:
        """Return the numbers of codes, int32, -1 for those that have none."""
        if self._index is not None:
            return self._index[codes]
        places = np.searchsorted(self._sorted, codes)
        known = places < self._count
        known[known] = self._sorted[places[known]] == codes[known]
        numbers = np.full(len(codes), -1, dtype=np.int32)
        numbers[known] = self._numbers[places[known]]
        return numbers
