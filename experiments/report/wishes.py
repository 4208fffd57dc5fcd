"""Wishes on a page with three or more objectives: upper limits of some, and what these cost in the others."""

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


def wishes(front: Front) -> dict[str, Any]:
    """Return the page's data on wishes, JSON-ready.

    Values are compared by their ranks among those that occur, since JavaScript's floats could not tell all apart.
    """
    exact = front.complete
    values = {name: sorted({plan.objectives[name] for plan in front}) for name in front.objectives}
    places = {name: {value: place for place, value in enumerate(found)} for name, found in values.items()}
    return {
        "words": WORDS if exact else WORDS | FOUND,
        "axes": [
            {"name": name, "values": found, "texts": [number(value) for value in found]}
            for name, found in values.items()
        ],
        "places": [[places[name][value] for name, value in plan.objectives.items()] for plan in front],
    }
