"""Verdicts of a checker: what was checked, whether it holds, and in words why."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """One claim that was checked.

    Attributes:
        name: what, e.g. `task cost phi1`.
        holds: the verdict.
        words: what was found.
    """

    name: str
    holds: bool
    words: str
