"""Rehearsals: what a run would do, tried out without physics with the objects arranged for it."""

from __future__ import annotations

from dataclasses import dataclass

from sim.errors import SimulationError
from sim.execution.arrangement import Places, positions, staged
from sim.simulation.kinematic_cell import KinematicCell
from sim.skills.catalogue import perform
from sim.world.scene import Scene


@dataclass(frozen=True)
class Rehearsal:
    """Actions one after another, from home.

    Attributes:
        actions: as in plans, such as `transport blue san`.
        places: where the objects are; others are left out.
        obj: the object that is taken.
        location: where it is put down.
    """

    actions: tuple[str, ...]
    places: Places
    obj: str
    location: str

    def run(self, cell: KinematicCell, scene: Scene) -> tuple[int, SimulationError | None]:
        """Return how many actions can be carried out in a cell of a scene, and why the next one cannot.

        Raises:
            ModelError: the objects cannot be so.
        """
        arrangement = staged(scene, self.places)
        cell.begin(arrangement, positions(scene, arrangement))
        cell.destination = self.location
        for done, action in enumerate(self.actions):
            try:
                perform(cell, action)
            except SimulationError as error:
                return done, error
        return len(self.actions), None


def unable_to_begin(scene: Scene, error: SimulationError) -> str:
    """Return in words that the hand cannot be over the location where it starts, and why."""
    return f"model.start: the hand cannot begin over {scene.model.start!r}: {error}"
