"""Contact monitoring of a running simulation: forces on the finger pads, and unwanted contacts."""

from __future__ import annotations

import mujoco
import numpy as np

from sim.world.scene import Scene

WORLD, HANDLED, ALOFT, ROBOT = range(4)
"""Roles of geoms. The handled object may touch the fingers and the world; aloft, the fingers alone."""

HOLD_FORCE_N = 0.5
"""Least contact force of each pad on a held object: its weight; a firm grip has 15 N."""


class ContactMonitor:
    """Roles of the bodies, and their latest contacts.

    Attributes:
        handled: the object that the fingers may touch, or None.
        pad_forces: (2,) N, of the left and the right pad on it at the last update.
        pressed: when both pads last pressed it, s; -inf if they have not.
    """

    def __init__(self, scene: Scene) -> None:
        """Assign its own bodies to the robot, and all others to the world."""
        self._model = model = scene.mujoco
        self._pads = [model.geom(name).id for name in scene.robot.gripper.pads]
        self._fingers: list[bool] = scene.robot.fingers(model).tolist()
        self._roles: list[int] = np.where(scene.robot.bodies(model), ROBOT, WORLD)[model.geom_bodyid].tolist()
        self.handled: str | None = None
        self.pad_forces = np.zeros(2)
        self.pressed = -np.inf

    @property
    def aloft(self) -> bool:
        """Whether the handled object hangs in the air."""
        return ALOFT in self._roles

    @property
    def moving(self) -> np.ndarray:
        """(ngeom,) bool: the robot's geoms and that of the object aloft."""
        return np.isin(self._roles, (ALOFT, ROBOT))

    def handle(self, obj: str | None, *, aloft: bool = False) -> None:
        """Set the object that the fingers may touch, and whether it is aloft, so that it may touch nothing else."""
        self._roles = [role if role == ROBOT else WORLD for role in self._roles]
        if obj is not None:
            self._roles[self._model.geom(obj).id] = ALOFT if aloft else HANDLED
        if obj != self.handled:
            self.handled, self.pressed = obj, -np.inf

    def update(self, data: mujoco.MjData) -> list[tuple[str, str]]:
        """Update from a state just simulated; return the unwanted contacts as `touches` does."""
        presses, touches = self._sort(data)
        self.pad_forces = np.zeros(2)
        if presses:
            forces, rows = data.efc_force, data.contact.efc_address
            for pad, contact in presses:
                # The first row of an elliptic cone is the normal force.
                self.pad_forces[pad] += forces[rows[contact]]
        if self.pad_forces.min() > HOLD_FORCE_N:
            self.pressed = data.time
        return touches

    def touches(self, data: mujoco.MjData) -> list[tuple[str, str]]:
        """Return the unwanted contacts.

        Returns:
            Names of bodies: one of the robot or the object aloft, and what it touches.
        """
        return self._sort(data)[1]

    def _sort(self, data: mujoco.MjData) -> tuple[list[tuple[int, int]], list[tuple[str, str]]]:
        """Return (pad, contact) for every contact of a pad with the handled object, and the unwanted contacts."""
        roles = self._roles
        presses, touches = [], []
        for i, (a, b) in enumerate(data.contact.geom.tolist()):
            if roles[a] == roles[b]:
                continue
            low, high = (a, b) if roles[a] < roles[b] else (b, a)
            if roles[high] == HANDLED:
                continue
            if roles[low] == WORLD or not self._fingers[high]:
                moving, other = (self._model.body(self._model.geom_bodyid[geom]).name for geom in (high, low))
                touches.append((moving, other))
            elif high in self._pads:
                presses.append((self._pads.index(high), i))
        return presses, touches
