"""What all kinds of faults have in common: how they are read, drawn at random and injected."""

from __future__ import annotations

import importlib
import math
import pkgutil
import re
from abc import ABC, abstractmethod
from collections.abc import Iterator, MutableMapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from prefplan.errors import choices
from prefplan.models.manipulation.model import ManipulationModel
from sim.errors import SimulationError
from sim.execution import faults
from sim.simulation.workcell import Workcell
from sim.skills.skill import Skill

_KINDS: dict[str, type[Fault]] = {}
"""The kinds of faults that are defined, by name."""


@dataclass
class Injection:
    """What a fault acts on.

    Attributes:
        cell: the running simulation.
        skills: the run's skills, by kind of action; a fault may wrap one.
        spares: names of objects in store below the table, which no other fault has used.
        rng: random numbers of this fault alone.
        delay: random time for which the fault waits while it could happen, s; 0 if a user injects it.
        since: simulated time since which the fault could happen, s; inf while it cannot.
        height: height of the handled object when it was gripped, m; inf while none is.
    """

    cell: Workcell
    skills: MutableMapping[str, Skill]
    spares: Iterator[str]
    rng: np.random.Generator
    delay: float
    since: float = math.inf
    height: float = math.inf


@dataclass(frozen=True)
class Fault(ABC):
    """A fault to inject.

    Attributes:
        action: number of the executed action, from 1, at which it falls due; it happens as soon after that as it can.
        argument: text after the kind and a colon; empty for none.
        kind: name of the kind of fault.
        noun: what the argument is, such as `OBJECT`; empty for none.
        refusal: why the fault cannot happen at the moment at which a user asks for it.
        spares: number of spare objects that it needs.
        grasps: whether it happens only to a hand that grasps.
    """

    action: int
    argument: str = ""
    kind: ClassVar[str]
    noun: ClassVar[str] = ""
    refusal: ClassVar[str] = "it cannot happen now"
    spares: ClassVar[int] = 0
    grasps: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        """Add the kind to those that `read_fault` reads; a class without a `kind` is a base class."""
        if "kind" in vars(cls):
            _KINDS[cls.kind] = cls

    def __str__(self) -> str:
        """Return the fault as `read_fault` reads it."""
        return f"{self.kind}{':' if self.argument else ''}{self.argument}@{self.action}"

    @classmethod
    def form(cls) -> str:
        """Return how faults of this kind are written, such as `move:OBJECT@K`."""
        return f"{cls.kind}{':' if cls.noun else ''}{cls.noun}@K"

    @classmethod
    def candidates(cls, model: ManipulationModel, rng: np.random.Generator) -> Sequence[str]:
        """Return the arguments from which to draw; with some of them, the fault may be impossible in the scene."""
        return [""]

    def objection(self, model: ManipulationModel) -> str | None:
        """Return why the argument is not valid for this kind; None if it is."""
        return None

    def unavailable_because(self, model: ManipulationModel) -> str | None:
        """Return why the fault cannot happen in a model's scene, whatever is done there; None if it can."""
        return "no object is ever grasped" if self.grasps and not model.movable else None

    @abstractmethod
    def inject(self, injection: Injection) -> dict[str, str] | None:
        """Let the fault happen now; return details for its event, such as the `object`, or None if it cannot.

        It is called in every control period in which the fault is due, until it happens.
        """


def kinds() -> dict[str, type[Fault]]:
    """Return the kinds of faults by name: those in the files of this folder, and other subclasses of `Fault`.

    They are sorted, so that what a seed draws does not depend on the order of imports.
    """
    for module in pkgutil.iter_modules(faults.__path__):
        importlib.import_module(f"{faults.__name__}.{module.name}")
    return dict(sorted(_KINDS.items()))


def unknown(name: str, names: Sequence[str], noun: str) -> str | None:
    """Return the message that a name is not among some names; None if it is."""
    return None if name in names else f"unknown {noun} {name!r} {choices(name, names)}"


def read_fault(text: str, model: ManipulationModel) -> Fault:
    """Return the fault that a text describes.

    Raises:
        SimulationError: the text describes no fault, or names an object or a location that the model does not have, or
            the fault cannot happen in the model's scene.
    """
    name = re.split("[:@]", text)[0]
    if name not in (known := kinds()):
        raise SimulationError(f"{text!r}: unknown fault {name!r} {choices(name, known)}")
    kind = known[name]
    head, _, number = text.rpartition("@")
    if not re.fullmatch("0*[1-9][0-9]*", number) or not head:
        raise SimulationError(f"{text!r}: must end with @ and the number of an action from 1, as in {kind.form()}")
    before, colon, argument = head.partition(":")
    if bool(colon) != bool(kind.noun) or before != name:
        raise SimulationError(f"{text!r}: is written {kind.form()}")
    fault = kind(int(number), argument)
    if words := fault.objection(model):
        raise SimulationError(f"{text!r}: {words}")
    if reason := fault.unavailable_because(model):
        raise SimulationError(f"{text!r}: cannot happen: {reason}")
    return fault


def draw_fault(kind: str, action: int, model: ManipulationModel, rng: np.random.Generator) -> Fault:
    """Return a random fault of a kind that can happen in a model's scene.

    Raises:
        SimulationError: no fault of the kind can happen; the message says why.
    """
    drawn = kinds()[kind]
    options = [drawn(action, argument) for argument in drawn.candidates(model, rng)]
    reasons = [fault.unavailable_because(model) for fault in options]
    possible = [fault for fault, reason in zip(options, reasons, strict=True) if reason is None]
    if not possible:
        raise SimulationError("; ".join(sorted({reason for reason in reasons if reason})))
    return possible[rng.integers(len(possible))]


def spares_for(injected: Sequence[Fault]) -> int:
    """Return the number of spare objects that a scene must hold for some faults."""
    return sum(fault.spares for fault in injected)
