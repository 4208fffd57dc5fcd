"""Rehearsals: actions tried out as in a run, but without physics and with objects arranged for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from sim.capability.arrangement import Places, positions, staged
from sim.errors import SimulationError
from sim.simulation.kinematic_cell import KinematicCell
from sim.skills.catalogue import perform
from sim.skills.skill import Skill
from sim.world.scene import Scene


@dataclass(frozen=True)
class Rehearsal:
    """A sequence of actions with one object, from the arm's home pose.

    Attributes:
        actions: as in plans, such as `transport blue san`.
        places: locations of the objects; others are left out.
        obj: the object to grasp.
        location: where it is put down.
        via: location over which the hand is brought first; none if empty.
    """

    actions: tuple[str, ...]
    places: Places
    obj: str
    location: str
    via: str = ""

    def beginning(self, count: int) -> Rehearsal:
        """Return the rehearsal of the first actions alone."""
        return replace(self, actions=self.actions[:count])

    def run(self, cell: KinematicCell, scene: Scene, skills: Mapping[str, Skill]) -> tuple[int, SimulationError | None]:
        """Return how many actions succeed in a cell of a scene, and the error of the next one, or None.

        Raises:
            ModelError: the model does not allow these places.
        """
        arrangement = staged(scene, self.places)
        cell.begin(arrangement, positions(scene, arrangement))
        for done, action in enumerate(self.actions):
            try:
                if self.via and not done:
                    perform(cell, f"transit {self.via}", skills)
                perform(cell, action, skills, ahead=self.actions[done + 1 :])
            except SimulationError as error:
                return done, error
        return len(self.actions), None


def unable_to_begin(scene: Scene, error: SimulationError) -> str:
    """Return the message that the hand cannot reach its start location, and why."""
    return f"model.start: the hand cannot begin over {scene.model.start!r}: {error}"
