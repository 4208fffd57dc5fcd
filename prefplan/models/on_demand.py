"""Sequences whose entries are made when they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar, overload

T = TypeVar("T")


class OnDemand(Sequence[T]):
    """A sequence of known length that makes its entries."""

    def __init__(self, length: int, make: Callable[[int], T]) -> None:
        """Take the length, and what makes the entry of an index 0 <= i < length."""
        self._indices, self._make = range(length), make

    def __len__(self) -> int:
        """Return the length."""
        return len(self._indices)

    @overload
    def __getitem__(self, index: int) -> T: ...

    @overload
    def __getitem__(self, index: slice) -> list[T]: ...

    def __getitem__(self, index: int | slice) -> T | list[T]:
        """Return an entry, or several."""
        found = self._indices[index]
        return self._make(found) if isinstance(found, int) else [self._make(i) for i in found]
