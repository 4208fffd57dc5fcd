"""A skill: an operator (precondition and effect of a kind of action) with the motion that achieves the effect."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

from prefplan.models.manipulation.operators import Operator
from prefplan.models.manipulation.symbolic import Action
from sim.errors import BlockedError, SimulationError
from sim.simulation.workcell import Workcell


class SkillError(SimulationError):
    """A skill ended without its effect; the message says why."""


class NoSpaceError(SkillError, BlockedError):
    """An object does not fit between others where it should be put down; the message says by how much."""


class Skill(Operator, ABC):
    """An operator that can be carried out in simulation."""

    @abstractmethod
    def perform(self, cell: Workcell, action: Action, ahead: Sequence[Action] = ()) -> None:
        """Carry out one action; `ahead` are the actions planned after it.

        On return the arm may still be ending its last movement; the next action's first movement is blended with it.

        Raises:
            SkillError: the action ended without its effect.
            BlockedError: bodies are in the way of the arm or of the fingers.
            SimulationError: the goal is out of reach.
        """


def next_release(obj: str, ahead: Sequence[Action]) -> str | None:
    """Return the location at which the actions `ahead` first release an object; None if they never do."""
    return next((action.location for action in ahead if action.kind == "release" and action.obj == obj), None)
