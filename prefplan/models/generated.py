"""Transition systems that are known state by state; all states are listed only when something asks for them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Hashable, Sequence
from dataclasses import fields
from functools import cached_property
from typing import Any, overload

from prefplan.models.transition_system import TransitionSystem

LISTS = frozenset(field.name for field in fields(TransitionSystem))
"""Attributes that tell of all states, unless a system has them by itself."""


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
        return _States(self)


class _States(Sequence[Hashable]):
    """What the states of a system are called."""

    def __init__(self, system: GeneratedSystem) -> None:
        self._system = system

    def __len__(self) -> int:
        return len(self._system.offsets) - 1

    @overload
    def __getitem__(self, index: int) -> Hashable: ...

    @overload
    def __getitem__(self, index: slice) -> list[Hashable]: ...

    def __getitem__(self, index: int | slice) -> Hashable | list[Hashable]:
        if isinstance(index, slice):
            return [self._system.state(i) for i in range(len(self))[index]]
        if index < 0:
            index = range(len(self))[index]
        return self._system.state(index)
