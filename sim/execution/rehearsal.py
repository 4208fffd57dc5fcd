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

    def __call__(self, cell: KinematicCell, scene: Scene) -> None:
        """Carry the actions out in a cell of a scene.

        Raises:
            ModelError: the objects cannot be so.
            SimulationError: an action cannot be carried out.
        """
        arrangement = staged(scene, self.places)
        cell.begin(arrangement, positions(scene, arrangement))
        cell.destination = self.location
        for action in self.actions:
            perform(cell, action)

    def works(self, cell: KinematicCell, scene: Scene) -> bool:
        """Return whether the actions can be carried out in a cell of a scene."""
        try:
            self(cell, scene)
        except SimulationError:
            return False
        return True
