"""Errors of the simulation, all of them a `PrefplanError`."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from typing import Self

from prefplan.errors import PrefplanError


class SimulationError(PrefplanError):
    """A scene that cannot be built, or a motion that is impossible, e.g. to a location out of the arm's reach.

    Attributes:
        faults: what is wrong, a sentence for each fault.
    """

    def __init__(self, *faults: str) -> None:
        """Store a sentence for each fault; the message has all of them."""
        super().__init__("; ".join(faults))
        self.faults = faults


@contextmanager
def collecting(faults: list[str]) -> Iterator[None]:
    """Add the faults of a `SimulationError` in this context to a list, each once, and suppress the error."""
    try:
        yield
    except SimulationError as error:
        faults += [fault for fault in error.faults if fault not in faults]


def in_metres(position: Iterable[float], *, decimals: int = 3) -> str:
    """Return a (3,) position, m, for a message."""
    return f"({', '.join(f'{x:.{decimals}f}' for x in position)}) m"


class BlockedError(SimulationError):
    """A motion for which no collision-free path or grasp was found; it fails again unless something is moved.

    Attributes:
        by: names of the bodies in the way: objects, or fixtures; empty if none is in the way.
        at_goal: whether these bodies are where the fingers would be, so that no other path of the hand avoids them.
        collisions: the bodies in collision in each candidate that was tried.
    """

    def __init__(
        self, message: str, by: Collection[str], *, at_goal: bool = False, collisions: Sequence[Collection[str]] = ()
    ) -> None:
        """Store a message, and the names of the bodies in the way."""
        super().__init__(message)
        self.by, self.at_goal, self.collisions = tuple(sorted(by)), at_goal, collisions or (by,)

    @classmethod
    def on_the_way(cls, by: Collection[str], *, load: str | None = None) -> Self:
        """Return the error of a motion with bodies on its path; `by` has the load, too, if it would touch the arm."""
        names = sorted(set(by) - {load})
        if load in by:
            names.append(f"the arm, which {load} would touch")
        return cls(f"the way is blocked by {' and '.join(names)}", by)

    @classmethod
    def beside_fingers(cls, collisions: Sequence[Collection[str]], *, movable: Collection[str] = ()) -> Self:
        """Return the error of a grasp or a release: in every candidate, bodies are where the fingers would be.

        It names few bodies that together block all candidates; those that are not `movable` are chosen first.
        """
        by, left = set[str](), list(collisions)
        while left:
            counts = Counter(chain.from_iterable(left))
            name = max(sorted(counts), key=lambda name: (name not in movable, counts[name]))
            by.add(name)
            left = [bodies for bodies in left if name not in bodies]
        words = f"no room for the fingers: they would touch {' and '.join(sorted(by))}"
        return cls(words, by, at_goal=True, collisions=collisions)


class UnstableError(PrefplanError):
    """A simulation that diverged, so that MuJoCo reset its state; unlike a `SimulationError`, it ends the run."""

    def __init__(self, seconds: float) -> None:
        """Name the time in the simulation, s."""
        super().__init__(f"the simulation became unstable at {seconds:.2f} s: its state holds NaN or huge numbers")


class RenderingError(PrefplanError):
    """A picture or video that cannot be made, e.g. because OpenGL is missing; the message says why."""


class RobotError(PrefplanError):
    """A robot that is unknown, unsuitable or not available on this machine."""


class LogError(PrefplanError):
    """A file that is not the log of a run, or cannot be read."""
