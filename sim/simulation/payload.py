"""Payload compensation: the commands are offset for the weight of a held object of known mass."""

import mujoco
import numpy as np

from sim.motion.trajectory import CONTROL_PERIOD_S, smooth_step
from sim.world.scene import Scene

SHIFT_DURATION_S = 0.4
"""Time in which the compensated weight changes, s."""


class Payload:
    """A mass at the tool, and the offsets of the n joint commands that compensate for its weight.

    Without them, the Panda sags by 2 mm under 2 kg, and presses the object onto its support with as much force again.
    """

    def __init__(self, scene: Scene, stiffness: np.ndarray) -> None:
        """Begin without a load; `stiffness` is (n,) of the joints' position actuators, N m/rad or N/m."""
        self._model, self._stiffness = scene.mujoco, stiffness
        self._tool, self._dofs = scene.mujoco.site(scene.robot.tool).id, scene.robot.dofs(scene.mujoco)
        self._mass = 0.0
        self._coming: list[float] = []
        self._offset = np.zeros(len(stiffness))

    @property
    def mass(self) -> float:
        """The compensated mass once no change is under way, kg."""
        return self._coming[-1] if self._coming else self._mass

    @property
    def is_borne(self) -> bool:
        """Whether any mass is compensated for, now or after a change that is under way."""
        return bool(self._mass or self._coming)

    def shift(self, mass: float) -> None:
        """Begin to change the compensated mass smoothly to another one, kg, within `SHIFT_DURATION_S`."""
        shares = smooth_step(np.linspace(0, 1, round(SHIFT_DURATION_S / CONTROL_PERIOD_S) + 1)[1:])
        self._coming = (self._mass + shares * (mass - self._mass)).tolist()

    def offsets(self, data: mujoco.MjData, steps: int) -> np.ndarray:
        """Return the (steps, n) offsets of the commands from the references in the next control period, rad or m."""
        if self._coming:
            self._mass = self._coming.pop(0)
        jacobian = np.empty((3, self._model.nv))
        mujoco.mj_jacSite(self._model, data, jacobian, None, self._tool)
        before = self._offset
        self._offset = -self._mass * float(self._model.opt.gravity[2]) * jacobian[2, self._dofs] / self._stiffness
        return np.linspace(before, self._offset, steps + 1)[1:]
