"""Actions and propositions of a manipulation model, and their text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from prefplan.errors import ModelError, choices


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


def kind_of(text: str) -> str:
    """Return the kind of an action, given its text."""
    return text.partition(" ")[0]


def parse_action(text: str, parameters: Mapping[str, Sequence[str]]) -> Action:
    """Return the action with a text, given which of the parameters `obj` and `location` each kind has.

    Raises:
        ModelError: the kind is unknown, or the number of names is not that of its parameters.
    """
    kind, *names = text.split() or [""]
    if kind not in parameters:
        raise ModelError(f"unknown action {kind!r} {choices(kind, parameters)}")
    if len(names) != len(parameters[kind]):
        raise ModelError(f"action {text!r}: is written {' '.join((kind, *parameters[kind])).upper()!r}")
    return Action(kind, **dict(zip(parameters[kind], names, strict=True)))


def holding(obj: str) -> str:
    """Return the proposition that the hand holds an object."""
    return f"holding_{obj}"


def at(obj: str, location: str) -> str:
    """Return the proposition that an object rests at a location."""
    return f"{obj}_{location}"


def marked(obj: str, mark: str) -> str:
    """Return the proposition that an object carries a mark."""
    return f"{obj}_{mark}"
