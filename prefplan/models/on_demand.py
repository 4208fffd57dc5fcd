"""Sequences whose entries are computed when they are read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar, overload

T = TypeVar("T")


class OnDemand(Sequence[T]):
    """A sequence that computes its entries when they are read."""

    def __init__(self, length: int, make: Callable[[int], T]) -> None:
        """Take the length, and a function that returns an entry or raises IndexError."""
        self._length, self._make = length, make

    def __len__(self) -> int:
        """Return the length."""
        return self._length

    @overload
    def __getitem__(self, index: int) -> T: ...

    @overload
    def __getitem__(self, index: slice) -> list[T]: ...

    def __getitem__(self, index: int | slice) -> T | list[T]:
        """Return an entry, or several."""
        if isinstance(index, slice):
            return [self._make(i) for i in range(len(self))[index]]
        return self._make(index if index >= 0 else range(len(self))[index])
