"""Observers of a running simulation."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sim.simulation.plant import Plant


class Observer:
    """Is called before and after each control period of a workcell in whose `observers` it is.

    It may look, disturb the world, or raise an error, which stops the run.
    """

    def before_period(self, cell: Plant) -> None:
        """Do something before a control period is simulated."""

    def after_period(self, cell: Plant) -> None:
        """Do something after a control period was simulated."""
