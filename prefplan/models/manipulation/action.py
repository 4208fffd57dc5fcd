"""Actions and propositions of a manipulation model as values, and how each is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from prefplan.errors import ModelError, choices


@dataclass(frozen=True)
class Action:
    """A symbolic action; its text, such as `transport blue san`, names what it has in this order.

    Attributes:
        kind: the operator's.
        obj: the object that it is about, or "".
        location: the location that it is about, or "".
    """

    kind: str
    obj: str = ""
    location: str = ""

    def __str__(self) -> str:
        """Return the text that plans and logs have."""
        return " ".join(part for part in (self.kind, self.obj, self.location) if part)


def kind_of(text: str) -> str:
    """Return the kind of the action that a text means."""
    return text.partition(" ")[0]


def parse_action(text: str, parameters: Mapping[str, Sequence[str]]) -> Action:
    """Return the action that a text means; an action of each kind has some of the parameters `obj` and `location`.

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
