"""Errors of the simulation, under the planner's root."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Self

from prefplan.errors import PrefplanError


class SimulationError(PrefplanError):
    """A scene that cannot be built or carried out, e.g. a location out of the arm's reach.

    Attributes:
        faults: what is wrong, a sentence for each fault.
    """

    def __init__(self, *faults: str) -> None:
        """Take a sentence for each fault; the message has all of them."""
        super().__init__("; ".join(faults))
        self.faults = faults


@contextmanager
def collecting(faults: list[str]) -> Iterator[None]:
    """Add the faults of a `SimulationError` to a list, each once, and go on after the block."""
    try:
        yield
    except SimulationError as error:
        faults += [fault for fault in error.faults if fault not in faults]


class BlockedError(SimulationError):
    """A motion for which no collision-free path or grip was found; as long as nothing is moved, none will be.

    Attributes:
        by: names of the bodies in the way: objects, or fixtures such as a lamp; empty if none is in the way.
    """

    def __init__(self, message: str, by: Collection[str]) -> None:
        """Take a message, and the names of the bodies in the way."""
        super().__init__(message)
        self.by = tuple(sorted(by))

    @classmethod
    def on_the_way(cls, by: Collection[str]) -> Self:
        """Return the error of a motion with bodies on its way."""
        return cls(f"the way is blocked by {' and '.join(sorted(by))}", by)

    @classmethod
    def beside_fingers(cls, by: Collection[str]) -> Self:
        """Return the error of a grip or a release with bodies where the fingers would be."""
        return cls(f"no room for the fingers: they would touch {' and '.join(sorted(by))}", by)


class RenderingError(PrefplanError):
    """No picture can be made on this machine; the message names what mends it."""


class RobotError(PrefplanError):
    """A robot that is unknown or cannot be fetched; the message names one that can be had."""


class LogError(PrefplanError):
    """A file that is no log of a run, or none that can be read."""
