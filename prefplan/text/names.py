"""Valid names of propositions, tasks, locations and objects."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Annotated, Any

from prefplan.errors import ModelError
from prefplan.text.forms import Form

NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
"""A name that a formula may contain."""

Names = Annotated[frozenset[str], Form('a list of names, such as ["shelf"]', 'names, such as {"shelf"}')]
"""Further propositions that formulas may use."""

RESERVED = frozenset({"true", "false", "X", "F", "U", "G", "R", "W", "M", "not", "and", "or"})
"""Words with another meaning in a formula."""


def check_names(names: Iterable[Any], *, where: str) -> None:
    """Raise ModelError, with the key `where` in front, for a name that a formula could not contain."""
    for name in sorted(names, key=str):
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise ModelError(
                f"{where}: {name!r} is not a name (a to z, A to Z, 0 to 9 and _, not starting with a digit)"
            )
        if name in RESERVED:
            raise ModelError(f"{where}: {name!r} is a reserved word ({' '.join(sorted(RESERVED))})")
