"""Colours that people with colour vision deficiency can tell apart.

P. Tol, "Colour Schemes", SRON technical note, 2021: `bright` for lines, `light` for areas with black text on them.
"""

from __future__ import annotations

from collections.abc import Iterable

AREAS = ("#77aadd", "#ee8866", "#eedd88", "#ffaabb", "#99ddff", "#44bb99", "#bbcc33", "#aaaa00", "#dddddd")
"""Colours of areas, in turn."""

PATH = "#222255"
"""Colour of a path over areas."""

GOOD, START = "#228833", "#bb5566"
"""Colours of satisfied tasks and of the start."""


def areas(names: Iterable[str]) -> dict[str, str]:
    """Return a colour for each name, in turn."""
    return {name: AREAS[i % len(AREAS)] for i, name in enumerate(names)}
