"""Manipulation model: an arm moves objects between named locations, one at a time."""

from __future__ import annotations

from dataclasses import dataclass

from prefplan.models.manipulation.description import Description, Location, ManipulationState, Object
from prefplan.models.manipulation.state_space import reachable
from prefplan.models.transition_system import TransitionSystem

__all__ = ["Location", "ManipulationModel", "ManipulationState", "Object"]


@dataclass(frozen=True)
class ManipulationModel(Description):
    """Locations, objects and action costs; `transition_system` makes the WTS. Attributes are those of `Description`."""

    def transition_system(self, *, start: ManipulationState | None = None) -> TransitionSystem:
        """Return every state reachable from the first as a weighted transition system.

        States are `ManipulationState`s; the actions are `transit L`, `grasp O`, `transport O L` and
        `release O L`, in this order, then in file order.

        Args:
            start: the state to begin in; None for `initial_state`. A hand at no location leaves its pose for good.

        Raises:
            ModelError: the state mentions what the model does not have, or leaves an object without a place.
        """
        return reachable(self, start or self.initial_state)
