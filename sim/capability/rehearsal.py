"""Rehearsals: actions tried out as in a run, but without physics and with objects arranged for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from prefplan.models.manipulation.symbolic import Action
from sim.capability.arrangement import Places, positions, staged
from sim.errors import SimulationError
from sim.simulation.kinematic_cell import KinematicCell
from sim.skills.catalogue import perform
from sim.skills.skill import Skill
from sim.world.scene import Scene


@dataclass(frozen=True)
class Rehearsal:
    """A sequence of actions, from the arm's home pose.

    Attributes:
        actions: as in plans, such as `transport blue san`.
        places: locations of the objects; others are left out.
        obj: the object to grasp.
        location: where it is put down.
    """

    actions: tuple[str, ...]
    places: Places
    obj: str
    location: str

    def run(self, cell: KinematicCell, scene: Scene, skills: Mapping[str, Skill]) -> tuple[int, SimulationError | None]:
        """Return how many actions succeed in a cell of a scene, and the error of the next one, or None.

        Raises:
            ModelError: the model does not allow these places.
        """
        arrangement = staged(scene, self.places)
        cell.begin(arrangement, positions(scene, arrangement))
        ahead = [Action("release", self.obj, self.location)]
        for done, action in enumerate(self.actions):
            try:
                perform(cell, action, skills, ahead=ahead)
            except SimulationError as error:
                return done, error
        return len(self.actions), None


def unable_to_begin(scene: Scene, error: SimulationError) -> str:
    """Return the message that the hand cannot reach its start location, and why."""
    return f"model.start: the hand cannot begin over {scene.model.start!r}: {error}"
