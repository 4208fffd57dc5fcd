"""Problems of three tasks on three states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from prefplan import Problem, Task, TransitionSystem
from prefplan.preferences.kinds import Preference

NAMES = ("phi1", "phi2", "phi3")


def build(preference: Preference, names: Sequence[str] = NAMES, **task: Any) -> Problem:
    """Return a problem of tasks that all ask for q, on s -1.25-> t -2-> u with p in t, q in u, and r nowhere."""
    edges = [("s", "go", "t", 1.25), ("t", "on", "u", 2)]
    system = TransitionSystem.from_transitions(
        edges, start="s", propositions=["p", "q", "r"], labels={"t": ["p"], "u": ["q"]}
    )
    return Problem(system, [Task(name, "F q", **task) for name in names], preference)
