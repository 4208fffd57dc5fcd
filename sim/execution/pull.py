"""A user pulls an object, as with the mouse in the viewer."""

import numpy as np

from sim.simulation.plant import Observer, Plant
from sim.simulation.run import EXCUSED_S

PULL_RATE_RAD_S = 15.0
"""Natural frequency of the critically damped spring by which a user pulls an object."""

MAX_PULL_N = 8.0
"""Greatest force of this spring, N: less than a third of the hand's gripping force."""


class Pull(Observer):
    """Pulls an object towards a point by a spring while there is a target.

    It is logged as a fault when it begins, and again while it lasts: what the object touches is excused.

    Attributes:
        target: the object's name and the (3,) point, m; None to let go.
        action: number of the action that is carried out, from 1, for the event.
    """

    def __init__(self) -> None:
        """Begin without a target."""
        self.target: tuple[str, np.ndarray] | None = None
        self.action = 1
        self._pulled: str | None = None
        self._logged = 0.0

    def before_period(self, cell: Plant) -> None:
        """Apply the force of the spring."""
        obj, point = self.target or (None, None)
        if self._pulled is not None and obj != self._pulled:
            cell.data.body(self._pulled).xfrc_applied[:] = 0.0
        now = float(cell.data.time)
        if obj is not None and (obj != self._pulled or now - self._logged >= EXCUSED_S):
            cell.log_event("fault", fault=f"pull:{obj}@{self.action}", object=obj)
            self._logged = now
        self._pulled = obj
        if obj is None:
            return
        mass, joint = float(cell.scene.mujoco.body(obj).mass[0]), cell.data.joint(obj)
        spring = PULL_RATE_RAD_S**2 * (point - joint.qpos[:3]) - 2 * PULL_RATE_RAD_S * joint.qvel[:3]
        force = mass * (spring - cell.scene.mujoco.opt.gravity)
        cell.data.body(obj).xfrc_applied[:3] = force * min(1.0, MAX_PULL_N / float(np.linalg.norm(force)))
