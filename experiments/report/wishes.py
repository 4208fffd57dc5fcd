"""Wishes on a page of three and more objectives: a largest value of one, and what that costs in the others."""

from __future__ import annotations

from typing import Any

from experiments.cli.output import number
from prefplan.front import Front

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
"""Sentences that the page fills in as wishes change; `rest` is the least of what a wish leaves."""

FOUND = {
    "rise": "{name} from {least} to {rest}",
    "cost": "{wishes}, among the plans found: {rises}.",
    "free": "{wishes}: every other objective has its least among the plans found.",
    "conflict": "None of the plans found has {wishes} at once.",
    "alone": "{name} is {rest} among the plans found",
}
"""Those that say less where the front is not known in whole."""


def wishes(front: Front) -> dict[str, Any]:
    """Return what the page has to know for wishes, JSON-ready.

    Values are compared by their places among those that occur, which is exact however large or fine they are.
    """
    exact = front.complete and not front.within
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
