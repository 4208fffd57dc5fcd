"""The objectives on a page: the values that occur, and the sentences about wishes, which are upper limits of some."""

from __future__ import annotations

from typing import Any

from prefplan.front import Front
from prefplan.text.layout import number

WORDS = {
    "wish": "{name} at most {value}",
    "none": "No wish yet: move a slider to the left.",
    "rise": "{name} from {least} to at least {rest}",
    "cost": "{wishes}: {rises}.",
    "free": "{wishes}: every other objective can still have its least.",
    "conflict": "No plan has {wishes} at once.",
    "alone": "{name} is at least {rest}",
    "instead": "With the other wishes, {alone}.",
    "left": "{left} of {all} plans left.",
}
"""Sentences that the page fills in as wishes change; `rest` is the least value among the plans that a wish leaves."""

FOUND = {
    "rise": "{name} from {least} to {rest}",
    "cost": "{wishes}, among the plans found: {rises}.",
    "free": "{wishes}: every other objective has its least among the plans found.",
    "conflict": "None of the plans found has {wishes} at once.",
    "alone": "{name} is {rest} among the plans found",
}
"""Weaker sentences for a front that is not known completely."""


def words(front: Front) -> dict[str, str]:
    """Return the sentences that are true of wishes on a front."""
    return WORDS if front.complete else WORDS | FOUND


def axes(front: Front) -> dict[str, Any]:
    """Return the values of each objective that occur, rising, and of each plan the ranks of its values; JSON-ready.

    Values are compared by their ranks, since JavaScript's floats could not tell all apart.
    """
    values = {name: sorted({plan.objectives[name] for plan in front}) for name in front.objectives}
    ranks = {name: {value: rank for rank, value in enumerate(found)} for name, found in values.items()}
    return {
        "axes": [
            {"name": name, "values": found, "texts": [number(value) for value in found]}
            for name, found in values.items()
        ],
        "ranks": [[ranks[name][value] for name, value in plan.objectives.items()] for plan in front],
    }
