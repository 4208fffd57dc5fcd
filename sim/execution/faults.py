"""Faults to inject, written as `slip@2` or `move:pink@3`."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from prefplan.errors import choices
from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError
from sim.world.objects import why_no_spares

SPELLINGS = {
    "slip": "slip@K",
    "move": "move:OBJECT@K",
    "knock": "knock:OBJECT@K",
    "miss": "miss:N@K",
    "foreign": "foreign:LOCATION@K",
    "blind": "blind:SECONDS@K",
}
"""How each kind of fault is written; K is the number of the executed action, from 1, at which it falls due."""


@dataclass(frozen=True)
class Fault:
    """A fault to inject.

    Attributes:
        kind: `slip` (the held object slips from the hand), `move` (an object is moved), `knock` (an object is knocked
            over), `miss` (grasps close on nothing), `foreign` (an unknown object is put at a location) or `blind` (no
            object is observed).
        action: number of the executed action, from 1, at which it falls due; it happens as soon after that as it can.
        target: the object or the location.
        amount: number of grasps missed, or duration for which nothing is observed, s.
    """

    kind: str
    action: int
    target: str = ""
    amount: float = 0.0

    def __str__(self) -> str:
        """Return the fault as `read_fault` reads it."""
        what = self.target or (f"{self.amount:g}" if self.amount else "")
        return f"{self.kind}{':' if what else ''}{what}@{self.action}"


def targets_of(kind: str, model: ManipulationModel) -> tuple[str, ...]:
    """Return the objects or locations that a fault of a kind may name; one empty name if it names none."""
    if kind in ("move", "knock"):
        return tuple(obj.name for obj in model.objects)
    return tuple(place.name for place in model.locations) if kind == "foreign" else ("",)


def why_impossible(fault: Fault, model: ManipulationModel) -> str | None:
    """Return why a fault cannot happen in a model's scene, whatever is done there; None if it can."""
    if fault.kind in ("slip", "miss") and all(obj.fixed for obj in model.objects):
        return "no object is ever grasped"
    if fault.kind != "foreign":
        return None
    place = model.location(fault.target)
    if place.on:
        return f"{place.name} is on top of objects; unknown objects appear on the table"
    return why_no_spares(model)


def read_fault(text: str, model: ManipulationModel) -> Fault:
    """Return the fault that a text describes.

    Raises:
        SimulationError: it describes none, names an object or a location that the model does not have, or cannot happen
            in its scene.
    """
    fault = _spelled(text, model)
    if reason := why_impossible(fault, model):
        raise SimulationError(f"{text!r}: cannot happen: {reason}")
    return fault


def _spelled(text: str, model: ManipulationModel) -> Fault:
    """Return the fault that a text describes, whether or not it can happen."""
    kind = re.split("[:@]", text)[0]
    if kind not in SPELLINGS:
        raise SimulationError(f"{text!r}: unknown fault {kind!r} {choices(kind, SPELLINGS)}")
    spelling = SPELLINGS[kind]
    head, _, number = text.rpartition("@")
    if not re.fullmatch("0*[1-9][0-9]*", number) or not head:
        raise SimulationError(f"{text!r}: must end with @ and the number of an action from 1, as in {spelling}")
    _, colon, what = head.partition(":")
    if bool(colon) != (":" in spelling) or kind != head.partition(":")[0]:
        raise SimulationError(f"{text!r}: is written {spelling}")
    if kind in ("miss", "blind"):
        return Fault(kind, int(number), amount=_amount(text, kind, what))
    if kind == "slip":
        return Fault(kind, int(number))
    names = targets_of(kind, model)
    if what not in names:
        noun = "location" if kind == "foreign" else "object"
        raise SimulationError(f"{text!r}: unknown {noun} {what!r} {choices(what, names)}")
    return Fault(kind, int(number), target=what)


def _amount(text: str, kind: str, what: str) -> float:
    noun = "how many grasps are missed" if kind == "miss" else "for how many seconds nothing is seen"
    try:
        amount = float(what)
    except ValueError:
        amount = math.nan
    if not (math.isfinite(amount) and amount > 0) or (kind == "miss" and amount != int(amount)):
        raise SimulationError(f"{text!r}: {what!r} does not say {noun}, as in {SPELLINGS[kind]}")
    return amount
