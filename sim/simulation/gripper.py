"""The gripper's actuator."""

from __future__ import annotations

import mujoco


class Gripper:
    """Drives the fingers."""

    def __init__(self, data: mujoco.MjData, actuator: int) -> None:
        """Drive the actuator of that index in a running state."""
        self._data, self._actuator = data, actuator

    @property
    def width(self) -> float:
        """The commanded width between the pads, m; narrower than a held object, so that they press it."""
        return float(self._data.ctrl[self._actuator])

    @width.setter
    def width(self, width: float) -> None:
        self._data.ctrl[self._actuator] = width
