"""The errors that the planner raises on purpose, with a common base class."""

from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager

MOST_COMPARED = 10_000
"""Most names that are compared with a wrong one to find the nearest, which takes a second."""

MOST_LISTED = 40
"""Most names in a message."""

LONGEST_SHOWN = 40
"""Most characters of a wrong value in a message; of a longer value only the type is shown."""


class PrefplanError(Exception):
    """Base class of all errors meant for a user: the message says what is wrong, where, and what would be valid."""


class FormulaError(PrefplanError):
    """A formula that cannot be parsed, is not co-safe (or for a rule, not safety), or needs too large an automaton."""


class ModelError(PrefplanError):
    """An invalid model, or an invalid number or name in one."""


class PreferenceError(PrefplanError):
    """A preference that is invalid, does not fit the tasks, or needs a cost bound."""


class ScenarioError(PrefplanError):
    """A scenario file that cannot be used; the message starts with the file and the key."""


class LimitError(PrefplanError):
    """A limit was reached; `ended` says which: `time`, `memory` or `interrupt`."""

    def __init__(self, ended: str) -> None:
        """Keep which limit was reached."""
        super().__init__(f"stopped by the {ended} limit")
        self.ended = ended


@contextmanager
def prefixed(
    prefix: str, kind: type[PrefplanError] = PrefplanError, *, new: type[PrefplanError] | None = None
) -> Iterator[None]:
    """Put a prefix, such as a key, before the messages of errors of a class; convert the errors to `new` if given.

    LimitError stays as it is.
    """
    try:
        yield
    except LimitError:
        raise
    except kind as error:
        raise (new or type(error))(f"{prefix}{error}") from None


def choices(wrong: str, valid: Iterable[str]) -> str:
    """Return the bracketed end of a message: the valid name nearest to a wrong one, else the valid names."""
    import difflib  # for messages only

    valid = list(valid)
    near = difflib.get_close_matches(wrong, valid, n=1) if len(valid) <= MOST_COMPARED else []
    if near:
        return f"(did you mean {near[0]!r}?)"
    if len(valid) > MOST_LISTED:
        return f"(valid: {', '.join(valid[:MOST_LISTED])} and {len(valid) - MOST_LISTED} more)"
    return f"(valid: {', '.join(valid)})" if valid else "(there are none)"


def describe(value: object) -> str:
    """Return what a wrong value is, for a message: itself if it is short, and its type."""
    if isinstance(value, type):
        return f"the class {value.__name__}"
    if value is None:
        return "None"
    shown = repr(value)
    kind = type(value).__name__
    return f"{shown} ({kind})" if len(shown) <= LONGEST_SHOWN else f"a {kind}"


def check_known(
    where: str, noun: str, name: object, valid: Collection[str], kind: type[PrefplanError] = ModelError
) -> None:
    """Raise an error that starts with the key `where` unless a name is valid; `noun` is what it names, e.g. `task`."""
    if name not in valid:
        raise kind(f"{where}: unknown {noun} {name!r} {choices(str(name), valid)}")
