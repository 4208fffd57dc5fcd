"""Errors of the simulation, under the planner's root."""

from __future__ import annotations

from prefplan.errors import PrefplanError


class SimulationError(PrefplanError):
    """A scene that cannot be built or carried out, e.g. a location out of the arm's reach."""


class RenderingError(PrefplanError):
    """No picture can be made on this machine; the message names what mends it."""


class RobotError(PrefplanError):
    """A robot that is unknown or cannot be fetched; the message names one that can be had."""


class LogError(PrefplanError):
    """A file that is no log of a run, or none that can be read."""
