"""An observer that calls a function."""

from __future__ import annotations

from collections.abc import Callable

from sim.simulation.plant import Observer, Plant


class Before(Observer):
    """Calls a function before every control period of a workcell."""

    def __init__(self, cell: Plant, function: Callable[[], None]) -> None:
        """Begin to observe a workcell."""
        self._function = function
        cell.observers.append(self)

    def before_period(self, cell: Plant) -> None:
        """Call the function."""
        self._function()
