"""Transition systems that are known state by state; all states are listed only when something asks for them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Hashable, Sequence
from dataclasses import fields
from functools import cached_property
from typing import Any, TypeVar, overload

from prefplan.models.transition_system import TransitionSystem

T = TypeVar("T")

LISTS = frozenset(field.name for field in fields(TransitionSystem))
"""Attributes that tell of all states, unless a system has them by itself."""


class OnDemand(Sequence[T]):
    """A sequence that makes its entries."""

    def __init__(self, length: Callable[[], int], make: Callable[[int], T]) -> None:
        """Take what tells the length, asked only if it matters, and what makes an entry or raises IndexError."""
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

    A subclass has `start`, `unit`, `propositions` and `resolution`, and what it knows without a list: it defines
    `listed`, `state`, `label`, `steps`, `shared_units` and `quotient`. States keep their numbers when they are listed.
    """

    def __init__(self, **attributes: Any) -> None:
        """Take what is known without a list."""
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
        """Return what a state is called."""

    @property
    def states(self) -> Sequence[Hashable]:  # type: ignore[override]
        """See `TransitionSystem`; their number is known once they are listed."""
        return OnDemand(lambda: len(self.offsets) - 1, self.state)
