"""What may be a name: of propositions, tasks, locations and objects."""

from __future__ import annotations

import re

NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
"""A name, as a formula may mention it."""

RESERVED = frozenset({"true", "false", "X", "F", "U", "G", "R", "W", "M", "not", "and", "or"})
"""Words that mean something else in a formula."""
