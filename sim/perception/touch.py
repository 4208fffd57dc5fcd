"""Contact monitoring of a running simulation: forces on the finger pads, and unwanted contacts."""

import mujoco
import numpy as np

from sim.geometry.mjcf import solid_geoms
from sim.world.scene import Scene

WORLD, HANDLED, ALOFT, ROBOT = range(4)
"""Roles of geoms. The handled object may touch the fingers and the world; while carried (aloft), only the fingers."""

HOLD_FORCE_N = 0.5
"""Least contact force of each pad on a held object: about the weight of a default cube; the Panda grips with 15 N."""


class ContactMonitor:
    """Forces on the gripper's pads, and unwanted contacts by the roles of geoms.

    Attributes:
        handled: the object that the fingers may touch, or None.
        pad_forces: (pads,) force of each pad on the handled object at the last update, N.
        pressed: time at which all pads last pressed it while the gripper was commanded to hold, s; -inf for never.
    """

    def __init__(self, scene: Scene) -> None:
        """Give the robot's geoms the role `ROBOT`, and all others `WORLD`."""
        self._model = model = scene.mujoco
        self._gripper = gripper = scene.robot.gripper
        self._motor = model.actuator(gripper.actuator).id
        self._pads = [model.geom(name).id for name in gripper.pads]
        self._fingers: list[bool] = scene.robot.fingers(model).tolist()
        self._roles: list[int] = np.where(scene.robot.bodies(model), ROBOT, WORLD)[model.geom_bodyid].tolist()
        self.handled: str | None = None
        self.pad_forces = np.zeros(len(self._pads))
        self.pressed = -np.inf

    @property
    def aloft(self) -> bool:
        """Whether the handled object may touch nothing but the fingers."""
        return ALOFT in self._roles

    def handle(self, obj: str | None, *, aloft: bool = False) -> None:
        """Set the object that the fingers may touch; while it is aloft, it may touch nothing but the fingers."""
        self._roles = [role if role == ROBOT else WORLD for role in self._roles]
        if obj is not None:
            for geom in solid_geoms(self._model, obj).tolist():
                self._roles[geom] = ALOFT if aloft else HANDLED
        if obj != self.handled:
            self.handled, self.pressed = obj, -np.inf

    def update(self, data: mujoco.MjData) -> list[tuple[str, str]]:
        """Update the pad forces from the latest simulated state, and return the unwanted contacts.

        Each has the names of two bodies: a link of the robot or the object aloft, and the body that this touches.
        """
        presses, touches = self._sorted_by_role(data.contact.geom)
        pressed = [0.0] * len(self._pads)
        if presses:
            forces, rows = data.efc_force, data.contact.efc_address
            for pad, contact in presses:
                # The first row of an elliptic cone is the normal force.
                pressed[pad] += forces[rows[contact]]
            if min(pressed) > HOLD_FORCE_N and self._gripper.holds(data.ctrl[self._motor]):
                self.pressed = data.time
        self.pad_forces = np.array(pressed)
        return touches

    def _sorted_by_role(self, pairs: np.ndarray) -> tuple[list[tuple[int, int]], list[tuple[str, str]]]:
        """Return (pad, contact) for every contact of a pad with the handled object, and the unwanted contacts."""
        roles = self._roles
        presses, touches = [], []
        for i, (a, b) in enumerate(pairs.tolist()):
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
