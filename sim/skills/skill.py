"""A skill: an operator, which says when an action exists and what it does, with the motion that does it."""

from __future__ import annotations

from abc import ABC, abstractmethod

from prefplan.models.manipulation.action import Action
from prefplan.models.manipulation.operators import Operator
from sim.errors import SimulationError
from sim.simulation.workcell import Workcell


class SkillError(SimulationError):
    """A skill that ended without its effect; the message says why."""


class Skill(Operator, ABC):
    """An operator that can be carried out in simulation."""

    @abstractmethod
    def perform(self, cell: Workcell, action: Action) -> None:
        """Carry out one action.

        The arm may still be ending its last movement, out of which the next action's first one then begins.

        Raises:
            SkillError: it ended without its effect.
            BlockedError: bodies are in the way of the arm or of the fingers.
            SimulationError: the goal is out of reach.
        """
