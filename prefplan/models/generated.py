"""Transition systems whose states are generated one by one, and listed only if an attribute needs all of them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Hashable, Sequence
from dataclasses import fields
from functools import cached_property
from typing import Any, TypeVar, overload

from prefplan.models.transition_system import TransitionSystem

T = TypeVar("T")

LISTS = frozenset(field.name for field in fields(TransitionSystem))
"""Attributes for which all states are listed, unless a system defines them itself."""


class OnDemand(Sequence[T]):
    """A sequence that computes its entries when they are read."""

    def __init__(self, length: Callable[[], int], make: Callable[[int], T]) -> None:
        """Take functions that return the length, called only if needed, and an entry, or raise IndexError."""
        self._length, self._make = length, make

    def __len__(self) -> int:
        """Return the length."""
        return self._length()

    @overload
    def __getitem__(self, index: int) -> T: ...

    @overload
    def __getitem__(self, index: slice) -> list[T]: ...

    def __getitem__(self, index: int | slice) -> T | list[T]:
        """Return an entry, or several."""
        if isinstance(index, slice):
            return [self._make(i) for i in range(len(self))[index]]
        return self._make(index if index >= 0 else range(len(self))[index])


class GeneratedSystem(TransitionSystem):
    """A transition system that lists its states on demand.

    A subclass has `start`, `unit`, `propositions`, `resolution` and attributes of its own, and defines `listed`,
    `state`, `label`, `steps`, `shared_units` and `quotient`. States keep their numbers when they are listed.
    """

    def __init__(self, **attributes: Any) -> None:
        """Take the attributes that need no list."""
        self.__dict__.update(attributes)

    def __getattr__(self, name: str) -> Any:
        """List all states for an attribute that needs them."""
        if name not in LISTS:
            raise AttributeError(name)
        return getattr(self.listed, name)

    @cached_property
    @abstractmethod
    def listed(self) -> TransitionSystem:
        """All states."""

    @abstractmethod
    def state(self, number: int) -> Hashable:
        """Return the name of a state."""

    @property
    def states(self) -> Sequence[Hashable]:  # type: ignore[override]
        """See `TransitionSystem`; their length lists all states."""
        return OnDemand(lambda: len(self.offsets) - 1, self.state)
