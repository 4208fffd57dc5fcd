"""The gripper's actuator."""

from __future__ import annotations

from typing import Protocol

import mujoco


class Gripper(Protocol):
    """Drives the fingers; a faulty one can stand in for it."""

    @property
    def width(self) -> float:
        """The commanded width between the pads, m; narrower than a held object, so that they press it."""

    @width.setter
    def width(self, width: float) -> None: ...


class GripperActuator:
    """The actuator of a MuJoCo model, whose command is the width."""

    def __init__(self, data: mujoco.MjData, actuator: int) -> None:
        """Drive the actuator of that index in a state."""
        self._data, self._actuator = data, actuator

    @property
    def width(self) -> float:
        """See `Gripper.width`."""
        return float(self._data.ctrl[self._actuator])

    @width.setter
    def width(self, width: float) -> None:
        self._data.ctrl[self._actuator] = width
