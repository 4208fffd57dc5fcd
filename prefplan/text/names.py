"""Valid names of propositions, tasks, locations and objects, and the labels that people are shown in place of names."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

from prefplan.errors import ModelError
from prefplan.text.forms import Form
from prefplan.text.layout import is_printable

NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
"""A name that a formula may contain."""

Names = Annotated[frozenset[str], Form('a list of names, such as ["shelf"]', 'names, such as {"shelf"}')]
"""Further propositions that formulas may use."""

RESERVED = frozenset({"true", "false", "X", "F", "U", "G", "R", "W", "M", "not", "and", "or"})
"""Words with another meaning in a formula."""

LONGEST_LABEL = 40
"""Greatest number of characters of a label: captions and heads of tables have room for about as many."""


def check_names(names: Iterable[Any], *, where: str) -> None:
    """Raise ModelError, with the key `where` in front, for a name that a formula could not contain."""
    for name in sorted(names, key=str):
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise ModelError(
                f"{where}: {name!r} is not a name (a to z, A to Z, 0 to 9 and _, not starting with a digit)"
            )
        if name in RESERVED:
            raise ModelError(f"{where}: {name!r} is a reserved word ({' '.join(sorted(RESERVED))})")


@dataclass(frozen=True)
class DisplayNames:
    """The labels of a scenario; what has no label is shown by its name.

    Attributes:
        tasks: labels by name of the task.
        objects: labels by name of the object.
        locations: labels by name of the location.
        parameters: which of `obj` and `location` each kind of action names, in order.
    """

    tasks: Mapping[str, str] = field(default_factory=dict)
    objects: Mapping[str, str] = field(default_factory=dict)
    locations: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, Sequence[str]] = field(default_factory=dict, repr=False)

    def task(self, name: str) -> str:
        """Return what is shown for a task, or for a rule, which has no label."""
        return self.tasks.get(name, name)

    def obj(self, name: str) -> str:
        """Return what is shown for an object."""
        return self.objects.get(name, name)

    def location(self, name: str) -> str:
        """Return what is shown for a location."""
        return self.locations.get(name, name)

    def action(self, text: str) -> str:
        """Return what is shown for an action such as `transport pink san`, e.g. `transport pink sanitizer`."""
        kind, *names = text.split(" ")
        parameters = self.parameters.get(kind, ())
        if len(names) != len(parameters):
            return text
        show = {"obj": self.obj, "location": self.location}
        return " ".join([kind, *(show[what](name) for what, name in zip(parameters, names, strict=True))])


def labels_of(kind: str, given: Iterable[tuple[str, str, str | None]]) -> dict[str, str]:
    """Return the labels by name, once checked: each is one short line, and no two names are shown alike.

    `given` has the key as in a scenario file, the name, and the label or None of each; `kind` says what they are.

    Raises:
        ModelError: a label is invalid; the message begins with the key.
    """
    labels: dict[str, str] = {}
    shown: dict[str, str] = {}
    for key, name, label in given:
        if label is not None:
            _check_label(label, f"{key}.label")
            labels[name] = label
        other = shown.setdefault(labels.get(name, name), name)
        if other != name:
            clash = f"{kind}s {other!r} and {name!r} would both be shown as {labels.get(name, name)!r}"
            raise ModelError(f"{key}.label: {clash}")
    return labels


def _check_label(label: object, where: str) -> None:
    if not isinstance(label, str):
        raise ModelError(f"{where}: must be a string, not {label!r}")
    if not (is_printable(label) and label.strip() == label and 1 <= len(label) <= LONGEST_LABEL):
        raise ModelError(
            f"{where}: must be one line of 1 to {LONGEST_LABEL} printable characters without spaces around it, "
            f"not {label!r}"
        )
