"""Actions and propositions of a manipulation model, and their text."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Action:
    """A symbolic action; its text has these parts in order, such as `transport blue san`.

    Attributes:
        kind: the kind of its operator.
        obj: its object, or "".
        location: its location, or "".
    """

    kind: str
    obj: str = ""
    location: str = ""

    def __str__(self) -> str:
        """Return the action's text in plans and logs."""
        return " ".join(part for part in (self.kind, self.obj, self.location) if part)


def holding(obj: str) -> str:
    """Return the proposition that the hand holds an object."""
    return f"holding_{obj}"


def at(obj: str, location: str) -> str:
    """Return the proposition that an object rests at a location."""
    return f"{obj}_{location}"


def marked(obj: str, mark: str) -> str:
    """Return the proposition that an object carries a mark."""
    return f"{obj}_{mark}"
