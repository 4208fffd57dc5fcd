"""Every error the planner raises on purpose, under one root."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager

MOST_COMPARED = 10_000
"""Most names among which the nearest is looked for, which takes a second."""

MOST_LISTED = 40
"""Most names in a message."""


class PrefplanError(Exception):
    """Root of all errors meant for a user: what is wrong, where, and what would be right."""


class FormulaError(PrefplanError):
    """A formula that cannot be read, or is not co-safe."""


class ModelError(PrefplanError):
    """A transition system, grid or manipulation model that makes no sense."""


class PreferenceError(PrefplanError):
    """A preference that does not fit the tasks."""


class ScenarioError(PrefplanError):
    """A scenario file that cannot be used; the message starts with the file and the key."""


class LimitError(PrefplanError):
    """A limit was reached; `ended` says which: `time`, `memory` or `interrupt`."""

    def __init__(self, ended: str) -> None:
        """Keep what ended the work."""
        super().__init__(f"stopped by the {ended} limit")
        self.ended = ended


@contextmanager
def prefixed(
    prefix: str, kind: type[PrefplanError] = PrefplanError, *, new: type[PrefplanError] | None = None
) -> Iterator[None]:
    """Put the place of a mistake, such as a key, in front of the messages of errors of a kind, but for limits.

    Args:
        prefix: the place.
        kind: of the errors.
        new: the kind that they become; None for that which they are.
    """
    try:
        yield
    except LimitError:
        raise
    except kind as error:
        raise (new or type(error))(f"{prefix}{error}") from None


def choices(wrong: str, valid: Iterable[str]) -> str:
    """Return the bracketed end of a message: the nearest valid name, else all of them."""
    valid = list(valid)
    near = difflib.get_close_matches(wrong, valid, n=1) if len(valid) <= MOST_COMPARED else []
    if near:
        return f"(did you mean {near[0]!r}?)"
    if len(valid) > MOST_LISTED:
        return f"(valid: {', '.join(valid[:MOST_LISTED])} and {len(valid) - MOST_LISTED} more)"
    return f"(valid: {', '.join(valid)})" if valid else "(there are none)"


def check_known(
    where: str, noun: str, name: object, valid: Collection[str], kind: type[PrefplanError] = ModelError
) -> None:
    """Raise an error, with a key in front, unless a name of what the noun says is a valid one."""
    if name not in valid:
        raise kind(f"{where}: unknown {noun} {name!r} {choices(str(name), valid)}")
